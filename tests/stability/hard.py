"""What the hard cases share: the harness of the system tests, the form (short or long), and formulas."""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))
from harness import *  # noqa: E402,F401,F403
