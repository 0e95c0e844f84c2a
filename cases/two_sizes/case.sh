# For ../run. The beds are 36 mm wide: ranks on top of each other.
title="two sizes"
what="glass of 1.5 and 2.5 mm that mixes in fast gas and segregates in slow gas; light spheres of 4.5 mm that rise in formulations A and B"
against="conservation; drag law; index of segregation between the two minimum fluidisations and above both; Archimedes"
time_short="12 s" time_run="8 min" memory="90 MB"
most=2
first=pz
# Two of the four beds can't be left out; all are short and smaller, and who is where is printed without a verdict.
short="-var tend 0.06 0.06 0.06 0.1 -var NL 200 4 4 300 -var NS 900 1500 1500 1400 -var Tsettle 0.1 -var tframe 0.02 -var kn 200 -var dt 2.4e-5"
compare_short=--short
