# For ../run. The bed is 5 diameters wide: one rank.
title="fluidisation curve"
what="gas, or water, through a narrow bed, turned up through minimum fluidisation and down again"
against="Ergun (1952) over the bed's own void fractions, 5 %"
time_short="15 s" time_run="30 s" memory="70 MB"
most=1
short="-var tup 0.2 -var tdown 0.6"
