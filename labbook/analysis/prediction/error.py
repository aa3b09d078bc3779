"""The error of a predicted value from its parts: the simulator's accuracy, and everything that was varied."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from data_schema.vocabulary import Undefined

ACCURACY = "accuracy"
"""The part of an error that is the simulator's own; the others go by the names of what was varied."""


def error_parts(
    value: float, accuracy_part: float, otherwise: Mapping[str, Sequence[float | None]]
) -> dict[str, float | Undefined]:
    """Return the parts of a predicted value's error: the accuracy's, and the largest change under each variation."""
    parts: dict[str, float | Undefined] = {ACCURACY: accuracy_part}
    for source, values in otherwise.items():
        known = [other for other in values if other is not None]
        parts[source] = (
            max(abs(other - value) for other in known)
            if len(known) == len(values)
            else Undefined(f"with another {source} the simulated robot does not jump")
        )
    return parts


def in_all(parts: Mapping[str, float | Undefined]) -> float | Undefined:
    """Add the parts of an error in quadrature; undefined where one of them is."""
    known = [part for part in parts.values() if not isinstance(part, Undefined)]
    undefined = next((part for part in parts.values() if isinstance(part, Undefined)), None)
    return math.hypot(*known) if undefined is None else undefined
