"""`python -m benchmarks.reference_simulator [SCENE ...]` computes the stored reference results anew."""

import sys

from benchmarks.reference_simulator.cases import CASES
from benchmarks.reference_simulator.storage import regenerate

if __name__ == "__main__":
    regenerate(sys.argv[1:] or tuple(CASES))
