# For ../run. Ranks side by side, and on top of each other from 4 on.
title="flat spouted bed"
what="12,000 spheres of 3 mm over a slot of 5 mm with a jet of 43.5 m/s, and gas through all the floor"
against="conservation; drag law; weight of the bed; Wen & Yu (1966), 30 %; jet lengths of Merry (1975) and Yang & Keairns (1978); symmetry"
time_short="15 s" time_run="10 min" time_long="45 min" memory="120 MB"
second=pz
long="-var tend 8.0"
# Soft contacts, fewer grains on coarse cells in a lower box: what needs a long mean is printed without a verdict.
short="-var N 3000 -var nx 28 -var ny 1 -var rx 2 -var nz 100 -var kn 1000 -var dt 3e-5 -var every 5 -var Tsettle 0.15 -var hold 0.03 -var tup 0.06 -var tend 0.2 -var tavg 0.12 -var tframe 0.02 -var Ujet 20"
compare_short=--short
