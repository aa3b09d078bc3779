"""The data of the thesis's figures, simulated once a process."""

from __future__ import annotations

import functools

from simulator.thesis.figures import ThesisFigures


@functools.cache
def thesis_figures() -> ThesisFigures:
    """Figures 3.2 to 3.13 as `labbook sim figures` has them; each is computed when it is first asked for."""
    return ThesisFigures()
