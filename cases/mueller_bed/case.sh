# For ../run. Ranks side by side.
title="mueller bed"
what="a bubbling bed of 9240 grains"
against="magnetic resonance: void fraction at 2 heights, velocity of grains at 3 (Mueller et al. 2009); drag law"
time_short="1 min" time_run="17 min" memory="100 MB"
most=4
# A coarse grid, soft contacts.
short="-var tend 0.7 -var tavg 0.35 -var tframe 0.01 -var kn 50 -var dt 2e-5 -var every 5 -var nx 12 -var ny 2 -var nz 32 -var rx 1 -var ry 1 -var rz 1"
compare_short="--no-verdict --from 0.35"
