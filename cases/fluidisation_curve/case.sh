# For ../run. The bed is 5 diameters wide: one rank.
title="fluidisation curve"
most=1
