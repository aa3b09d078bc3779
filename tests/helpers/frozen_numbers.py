"""The demonstration's numbers as they were frozen by `tests/labbook/demo/test_frozen_numbers.py`."""

from __future__ import annotations

import csv
import io
import lzma
import math
from collections.abc import Mapping
from pathlib import Path

DATA = Path(__file__).parents[1] / "labbook" / "demo" / "data"
RELATIVE = 1e-12
CANCELLING = {
    "dae1ab37c557": "shared error of a difference: the drain's errors of both sides but for a thousandth",
    "9904b937b008": "the same",
    "ab8aa7cf2084": "an end of an interval at -5e-7 m, a difference less nearly as much",
    "29560a7ce7cf": "an end of an interval at 0.16 mm, a bias of 12.9 mm less nearly as much",
}
"""Numbers, by id, that are a small rest of their terms: processors were seen to differ in them by up to 5e-12."""
OF_CANCELLING = 1e-11
NUMBERS = ("value", "se", "shared_se", "ci_low", "ci_high", "ci_level", "df", "n")
TEXTS = ("kind", "scope_json", "name", "unit", "undefined_reason")


def numbers_in(data: bytes) -> dict[str, dict[str, str]]:
    """The frozen numbers of a file by id."""
    return {row["uid"]: row for row in csv.DictReader(io.StringIO(lzma.decompress(data).decode()))}


def same(frozen: str, now: str, tolerance: float) -> bool:
    """Whether a number is what it was, but for the last digits that another processor may give."""
    if not frozen or not now:
        return frozen == now
    return math.isclose(float(frozen), float(now), rel_tol=tolerance, abs_tol=0.0)


def differs(frozen: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    tolerance = OF_CANCELLING if frozen["uid"] in CANCELLING else RELATIVE
    return [name for name in TEXTS if frozen[name] != now[name]] + [
        name for name in NUMBERS if not same(frozen[name], now[name], tolerance)
    ]
