# For ../run. Ranks side by side, and on top of each other from 4 on.
title="tube bank"
what="a bubbling bed of 11,000 grains around eight tubes; before it gas through a closer bank"
against="conservation; drag law; balance of forces; Bergelin et al. (1950), 25 %; Wen & Yu (1966), 30 %; symmetry"
time_short="30 s" time_run="15 min" time_long="45 min" memory="140 MB"
second=pz
long="-var tend 6.0 -var tavg 1.0"
# Fewer grains, coarse cells.
short="-var N 5000 -var nx 22 -var ny 3 -var nz 39 -var r 1 -var ne 12 -var hold 0.02 -var U 0.6 -var tend 0.14 -var tavg 0.09 -var tframe 0.02 -var every 12"
compare_short=--short
