# For ../run. Nothing to compare with: all that the program says is shown, and the output is drawn.
title="first bed"
most=2
show=
finish() { "$cases"/plot_fields.py first_bed.h5 --out . --heights 10 20 30; }
