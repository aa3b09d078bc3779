"""The demonstration's numbers as they were frozen by `tests/labbook/demo/test_frozen_numbers.py`."""

from __future__ import annotations

import csv
import io
import lzma
import math
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path

DATA = Path(__file__).parents[1] / "labbook" / "demo" / "data"
RELATIVE = 1e-9
NUMBERS = ("value", "se", "shared_se", "ci_low", "ci_high", "ci_level", "df", "n")
TEXTS = ("kind", "scope_json", "name", "unit", "undefined_reason")


def numbers_in(data: bytes) -> dict[str, dict[str, str]]:
    """The frozen numbers of a file by what they are."""
    return by_name(csv.DictReader(io.StringIO(lzma.decompress(data).decode())))


def by_name(rows: Iterable[dict[str, str]]) -> dict[str, dict[str, str]]:
    """Numbers by kind, scope and name; of several with the same, in their order, each has its place."""
    seen: Counter[str] = Counter()
    found = {}
    for row in rows:
        name = " ".join(row[text] for text in TEXTS[:3])
        seen[name] += 1
        found[f"{name} {seen[name]}"] = row
    return found


def same(frozen: str, now: str) -> bool:
    """Whether a number is what it was, but for the last digits that another processor may give."""
    if not frozen or not now:
        return frozen == now
    return math.isclose(float(frozen), float(now), rel_tol=RELATIVE, abs_tol=0.0)


def differs(frozen: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    return [name for name in TEXTS if frozen[name] != now[name]] + [
        name for name in NUMBERS if not same(frozen[name], now[name])
    ]
