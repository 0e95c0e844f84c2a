"""The sinking block's measure."""
import os
import runpy

block = runpy.run_path(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "sedimenting_block", "measure.py"))
prepare, measure = block["prepare"], block["measure"]
