"""Stamps and other integers with more digits than float64 has."""

from __future__ import annotations

import numpy as np
import pytest

from ingest.model import Declarations, ReadFile
from ingest.read import read_file
from tests.ingest.synthetic import text

FIRST_NS = 1_690_000_000_123_456_789
"""2023-07-22 04:26:40 UTC, of which float64 holds every 256th."""
HEIGHTS = [f"{0.4 + 0.05 * np.sin(k / 15):.5f}" for k in range(600)]


def read(header: str, rows: list[str], **declared: object) -> ReadFile:
    return read_file(text(header, rows), Declarations(**declared))  # type: ignore[arg-type]


@pytest.mark.parametrize("first", [FIRST_NS, 133_500_000_000_000_000, 2**63 - 1000, 18_446_744_073_709_551_000, 10**39])
def test_long_integers_in_any_column_drop_no_row(first: int) -> None:
    rows = [f"{5 * k},{first + k},{h}" for k, h in enumerate(HEIGHTS)]
    result = read("time [ms],id,height [m]", rows)
    assert (result.refused, result.rows_kept) == (False, 600)
    (channel,) = [channel for channel in result.parts[0].channels if channel.name == "id"]
    assert channel.values.tolist() == [float(first + k) for k in range(600)]
    assert "digits_rounded" in {finding.rule for finding in result.findings}
