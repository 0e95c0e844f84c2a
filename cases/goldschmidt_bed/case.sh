# For ../run. Ranks side by side, and on top of each other from 4 on.
title="Goldschmidt bed"
what="24,750 glass spheres of 2.5 mm in a flat bubbling bed"
against="conservation; drag law; weight of the bed; Wen & Yu (1966), 30 %; symmetry"
time_short="15 s" time_run="25 min" time_long="75 min" memory="150 MB"
second=pz
long="-var tend 15.0"
# Soft contacts, fewer grains on coarse cells: what needs a long mean is printed without a verdict.
short="-var N 4000 -var nx 20 -var ny 1 -var rx 1 -var nz 60 -var rz 1 -var kn 250 -var dt 4e-5 -var every 5 -var Tsettle 0.15 -var hold 0.03 -var tup 0.06 -var tend 0.2 -var tavg 0.12 -var tframe 0.02"
compare_short=--short
