"""The bubbling bed's measure, mean height of the particles at rest before the gas, and DEM steps in a contact."""
import importlib.util
import math
import os
import re

HERE = os.path.dirname(os.path.abspath(__file__))
spec = importlib.util.spec_from_file_location("bed", os.path.join(HERE, "..", "bubbling_bed", "measure.py"))
bed = importlib.util.module_from_spec(spec)
spec.loader.exec_module(bed)


def measure(folder, c):
    out = bed.measure(folder, c)
    with open(os.path.join(folder, "log.liggghts")) as f:
        rows = re.findall(r"^ +\d+ +900 +([-+.e0-9]+) *$", f.read(), re.M)
    out["settled"] = float(rows[-1])
    m = math.pi / 6 * 1.2e-3**3 * 1000
    out["contact_steps"] = math.pi * math.sqrt(m / 2 / c["kn"]) / (1.5e-5 / c["slow"])
    return out
