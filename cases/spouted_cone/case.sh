# For ../run. Ranks side by side, and behind each other from 4 on.
title="spouted cone"
what="8000 grains in a cone over a nozzle, from an STL file"
against="conservation; drag law; balance of forces; minimum spouting of Olazar et al. (1992), 30 %; symmetry"
time_short="40 s" time_run="15 min" time_long="40 min" memory="150 MB"
second=py
long="-var tend 4.0"
# Coarse cells, soft contacts, fewer grains, all of it fast: what needs a long mean is printed without a verdict.
short="-var N 4000 -var n 16 -var nz 32 -var r 1 -var kn 50 -var dt 5e-5 -var every 3 -var Tsettle 0.15 -var Tup 0.08 -var Tdown 0.04 -var Thold 0.02 -var tend 0.28 -var tframe 0.02 -var U 6 -var Ulow 4"
compare_short=--short
prepare() {
  "$case"/make_stl.py "$out"/vessel.stl "$out"/screen.stl
}
