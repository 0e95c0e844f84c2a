# For ../run. The bed is 9 diameters wide: ranks on top of each other.
title="liquid bed"
what="4800 alumina spheres of 3.1 mm that water expands, at five velocities"
against="conservation; drag law; weight; a uniform suspension by the law; Richardson & Zaki (1954), 10 % of the void fraction"
time_short="8 s" time_run="4 min" time_long="13 min" memory="80 MB"
most=2
first=pz
long="-var hold 6.0"
# Two velocities, fewer grains, coupled as often: what needs the bed to be as high as it will be is printed without a verdict.
short="-var N 600 -var width 9 -var height 48 -var levels 2 -var Uhigh 0.21 -var hold 0.4 -var Tsettle 0.3 -var tframe 0.05"
compare_short=--short
