# For ../run. Ranks side by side, and behind each other from 4 on.
title="round bed"
second=py
long="-var tend 5.0 -var tavg 1.0"
# A thin bed, coarse cells: what needs a long mean is printed without a verdict.
short="-var N 2500 -var nx 21 -var nz 30 -var tend 0.24 -var tavg 0.2 -var tframe 0.03 -var every 12"
compare_short=--short
prepare() {
  "$case"/make_stl.py "$out"/vessel.stl
}
