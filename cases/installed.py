"""Whether these are the cases of an installation, which all users share: results and new cases then lie where one stands (as program.sh has it)."""
import os

CASES = os.path.dirname(os.path.abspath(__file__))
INSTALLED = not os.path.exists(os.path.join(CASES, "..", "CMakeLists.txt")) and os.access(os.path.join(CASES, "..", "..", "..", "bin", "twogrid"), os.X_OK)
