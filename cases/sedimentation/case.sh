# For ../run. The column is 9 diameters wide: ranks on top of each other.
title="sedimentation"
what="suspensions of 1 mm spheres that settle in a viscous liquid, at three concentrations; then two sizes that segregate"
against="conservation; drag law; fronts by the law of a uniform suspension and by Richardson & Zaki (1954), 15 %; order of the sediment"
time_short="8 s" time_run="7 min" memory="80 MB"
most=2
first=pz
# One concentration, shorter: too few grains for a front with a verdict.
short="-var share 0.2 -var tend 0.2 -var tend2 0.2 -var filled 24 -var Lshare 0.05 -var Sshare 0.05 -var tframe 0.02"
compare_short=--short
