"""Tables of fix ave/time of a run that has come in several legs."""
import glob
import warnings

import numpy as np


def table(path):
    """Rows of the file, by their step, with those of the files NAME.1, NAME.2, ... that earlier legs have left, as far as a later one
    hasn't begun before their end."""
    earlier = sorted((int(p[len(path) + 1:]), p) for p in glob.glob(glob.escape(path) + ".*") if p[len(path) + 1:].isdigit())
    rows = np.empty((0, 0))
    for name in [p for _, p in earlier] + [path]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a leg that ended before its first row
            more = np.loadtxt(name, ndmin=2)
        if more.size:
            rows = more if not rows.size else np.vstack([rows[rows[:, 0] < more[0, 0]], more])
    return rows
