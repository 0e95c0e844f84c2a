# For ../run. Ranks side by side, and on top of each other from 4 on.
title="tube bank"
second=pz
long="-var tend 6.0 -var tavg 1.0"
# Fewer grains, coarse cells.
short="-var N 5000 -var nx 22 -var ny 3 -var nz 39 -var r 1 -var ne 12 -var hold 0.02 -var U 0.6 -var tend 0.14 -var tavg 0.09 -var tframe 0.02 -var every 12"
compare_short=--short
