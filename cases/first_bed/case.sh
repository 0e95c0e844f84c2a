# For ../run. All that the program says is shown.
title="first bed"
what="1200 spheres of 1.2 mm over a jet: the script that README.md explains line by line"
against="conservation; drag law; weight of the bed"
time_short="3 s" time_run="9 s" memory="75 MB"
most=2
short="-var settle 4000 -var tend 0.06 -var tavg 0.03"
show=
compare_short=--short
