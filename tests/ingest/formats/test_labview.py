"""LabVIEW measurement files: units, start and separators are those of their header."""

from __future__ import annotations

import numpy as np
import pytest

from ingest.model import Declarations
from ingest.read import read_file
from tests.ingest.formats.synthetic_labview import labview
from tests.ingest.reading import rules

HEIGHT_M = (300.5 + np.arange(50) % 7) / 1000


@pytest.mark.parametrize(
    "data",
    [
        labview(),
        labview(comment=False),
        labview(decimal=","),
        labview(tab=","),
        labview().replace(b"X_Columns\tOne\r\n", b"").replace(b"\r", b""),
    ],
    ids=["tabs", "no comments", "decimal comma", "commas", "short"],
)
def test_a_measurement_file_says_units_start_and_rate(data: bytes) -> None:
    """Its header lines were read as tables, without a word on the lines that hold the names."""
    result = read_file(data, Declarations())
    assert (result.format, result.refused, result.rows_kept) == ("labview", False, 50), result.findings
    (part,) = result.parts
    height, battery = part.channels
    assert (height.name, battery.name, height.source_unit) == ("body_height", "battery_voltage", "mm")
    assert height.values == pytest.approx(HEIGHT_M)
    assert set(battery.values) == {15.4}
    assert part.rate_hz == pytest.approx(250)
    assert str(part.start_original).endswith("14:02:11.5")


@pytest.mark.parametrize(
    ("data", "rule"),
    [
        (labview(columns="Multi"), "layout_unknown"),
        (labview() + labview(), "layout_unknown"),
        (labview()[:-600], "sample_count_contradicts"),
    ],
    ids=["stamps for each channel", "two segments", "cut short"],
)
def test_other_layouts_are_refused(data: bytes, rule: str) -> None:
    result = read_file(data, Declarations())
    assert result.refused
    assert rule in rules(result)
