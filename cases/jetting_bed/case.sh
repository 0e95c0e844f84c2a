# For ../run. Ranks side by side, and on top of each other from 4 on.
title="jetting bed"
second=pz
long="-var tend 6.0 -var tavg 1.0"
