# For ../run. Ranks side by side, and on top of each other from 4 on.
title="spouted bed with slot"
what="175,800 spheres of 2.5 mm, spouted by a jet of 20.8 m/s from a slot of 24 mm"
against="conservation; drag law; balance of forces; minimum spouting by Mathur & Gishler (1955); symmetry"
time_short="15 s" time_run="160 min" time_long="7 h" memory="610 MB"
second=pz
long="-var tend 8.0"
# A thin slice with soft contacts and a slower jet: what needs a long mean is printed without a verdict.
short="-var N 6000 -var D 8.0e-3 -var fill 0.16 -var nx 35 -var ny 1 -var rx 1 -var nz 125 -var rz 1 -var kn 500 -var dt 3e-5 -var every 5 -var Tsettle 0.15 -var tup 0.06 -var tend 0.2 -var tavg 0.12 -var tframe 0.02 -var Ujet 10"
compare_short=--short
