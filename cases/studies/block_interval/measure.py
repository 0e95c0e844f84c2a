"""The sinking block's measure, the coupling interval (s) and the block's way in it in particle cells."""
import os
import runpy

block = runpy.run_path(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "sedimenting_block", "measure.py"))
prepare = block["prepare"]


def measure(folder, c):
    m = block["measure"](folder, c)
    m["interval"] = c["every"] * 1.5e-5
    m["cells"] = max(abs(m["velocity"])) * m["interval"] / 4e-3
    return m
