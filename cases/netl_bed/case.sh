# For ../run. Ranks side by side, and on top of each other from 4 on.
title="NETL-like bed"
what="92,900 spheres of 3.256 mm in a bubbling bed of 230 x 76 mm"
against="conservation; drag law; weight of the bed; minimum fluidisation as measured, 20 %, and by Wen & Yu (1966), 30 %; symmetry"
time_short="15 s" time_run="35 min" time_long="90 min" memory="430 MB"
second=pz
long="-var tend 8.0"
# A thin slice with soft contacts: what needs a long mean is printed without a verdict.
short="-var N 4000 -var D 9.5e-3 -var fill 0.3 -var nx 23 -var ny 1 -var rx 1 -var nz 122 -var rz 1 -var kn 250 -var dt 4e-5 -var every 5 -var Tsettle 0.2 -var hold 0.03 -var tup 0.06 -var tend 0.2 -var tavg 0.12 -var tframe 0.02"
compare_short=--short
