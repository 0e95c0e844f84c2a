# For ../run. Ranks side by side, and on top of each other from 4 on.
title="jetting bed"
what="one, two or three jets of 1.6 mm in a flat bed of 9600 grains for each: the bed of Deb & Tafti"
against="conservation; drag law; balance of forces; jet lengths of Yang & Keairns (1978), Merry (1975), 40 %"
time_short="15 s" time_run="3 min" time_long="25 min" memory="100 MB"
second=pz
long="-var tend 6.0 -var tavg 1.0"
# A thin bed, not yet at its mean.
short="-var Neach 3000 -var tend 0.08 -var tavg 0.05 -var tframe 0.01"
compare_short=--short
