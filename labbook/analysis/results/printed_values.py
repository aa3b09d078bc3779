"""Whether a number is still what a report printed: its value, and the versions of the algorithms it came from.

Light, because who asks about one stored number needs no algorithm; the registries are loaded when their versions are.
"""

from __future__ import annotations

import math

SAME = 1e-9
"""Values that differ by less than this part are the same: another machine may add in another order."""


def agree(printed: float | None, value: float | None) -> bool:
    """Tell whether a value is the one that was printed."""
    if printed is None or value is None:
        return printed is value
    return math.isclose(printed, value, rel_tol=SAME)


def versions_now() -> dict[str, int]:
    """Return the versions of all algorithms of this labbook, detectors among them, by name."""
    from labbook.analysis.algorithms import ALGORITHMS
    from stats.apexes.detectors import DETECTORS

    return {
        **{algorithm.kind: algorithm.version for algorithm in ALGORITHMS},
        **{name: detector.version for name, detector in DETECTORS.items()},
    }
