"""`python -m simulator.reference [SCENE ...]` computes the stored reference results anew."""

import sys

from simulator.reference.cases import CASES
from simulator.reference.storage import regenerate

if __name__ == "__main__":
    regenerate(sys.argv[1:] or tuple(CASES))
