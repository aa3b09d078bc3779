"""Whether a number is still what a report printed: its value, and the versions of the algorithms it came from.

Light, because who asks about one stored number needs no algorithm; the registries are loaded when their versions are.
"""

from __future__ import annotations

import math

SAME = 1e-9
"""Values that differ by less than this part are the same: another machine may add in another order."""


def agree(printed: float | None, value: float | None, se: float | None = None) -> bool:
    """Tell whether a value is the one that was printed.

    Where its standard error is known, so much of that is the same, too: a difference that cancels to 1e-16 has no
    digits of its own.
    """
    if printed is None or value is None:
        return printed is value
    return math.isclose(printed, value, rel_tol=SAME, abs_tol=SAME * (se or 0.0))


def versions_now() -> dict[str, int]:
    """Return the versions of all algorithms of this labbook, detectors among them, by name."""
    from labbook.analysis.algorithms import ALGORITHMS
    from stats.apexes.detectors import DETECTORS

    return {
        **{algorithm.kind: algorithm.version for algorithm in ALGORITHMS},
        **{name: detector.version for name, detector in DETECTORS.items()},
    }
