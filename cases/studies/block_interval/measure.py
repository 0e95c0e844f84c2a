"""The sinking block's measure, and the interval in the units that count: the largest b Delta/(eps m) (drag number, B: over
the response time of the particles) and the way of the block in particle cells."""
import importlib.util
import os

HERE = os.path.dirname(os.path.abspath(__file__))
spec = importlib.util.spec_from_file_location("block", os.path.join(HERE, "..", "sedimenting_block", "measure.py"))
block = importlib.util.module_from_spec(spec)
spec.loader.exec_module(block)
prepare = block.prepare


def measure(folder, c):
    m = block.measure(folder, c)
    m["interval"] = c.get("every") * 1.5e-5
    m["cells"] = max(abs(m["velocity"])) * m["interval"] / 4e-3
    return m
