"""Which group of a comparison is the control, and the order of groups by their labels."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from data_schema.errors import InputRefused, unknown_name


def with_control(control: str | None, by: str, labels: Sequence[str], usual: str | None = None) -> str:
    """Return the label of the control: the one given, the usual one, or the first in order.

    Raises `UnknownName` for a label that no value has.
    """
    if not labels:
        raise InputRefused(f"there is no value to group by {by}: select others with --where.")
    if control is not None and control not in labels:
        raise unknown_name(f"level of {by}", control, labels)
    if control is None and usual in labels:
        return str(usual)
    return min(labels, key=sort_key) if control is None else control


def sort_key(label: str) -> tuple[int, float, tuple[tuple[str, int], ...], str]:
    """Return what sorts numbers by size, and words by alphabet with whole numbers in them by size."""
    try:
        number = float(label)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        parts = re.findall(r"([^0-9]*)([0-9]*)", label)
        return (1, 0.0, tuple((word, int(digits or -1)) for word, digits in parts), label)
    return (0, number, (), label)
