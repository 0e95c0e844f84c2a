# For ../run. Ranks side by side, and behind each other from 4 on.
title="round bed"
what="a bubbling bed of 20,000 grains in a cylinder from an STL file"
against="conservation; drag law; balance of forces; weight; Wen & Yu (1966), 30 %; symmetry"
time_short="18 s" time_run="25 min" time_long="1 h" memory="250 MB"
second=py
long="-var tend 5.0 -var tavg 1.0"
# A thin bed, coarse cells: what needs a long mean is printed without a verdict.
short="-var N 2500 -var nx 21 -var nz 30 -var tend 0.24 -var tavg 0.2 -var tframe 0.03 -var every 12"
compare_short=--short
prepare() {
  "$case"/make_stl.py "$out"/vessel.stl
}
