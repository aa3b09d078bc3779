"""Every bound of `[files.limits]` on what a file may ask for: named where it is exceeded, and raised by its key."""

from __future__ import annotations

import dataclasses
import gzip

import numpy as np
import pytest

from ingest.model import Declarations, Limits
from ingest.read import read_file
from tests.ingest.bad_input import LOG, with_row
from tests.ingest.formats.test_archive import zipped
from tests.ingest.formats.test_excel import LOG as ROWS
from tests.ingest.formats.test_matlab import mat
from tests.ingest.synthetic import text
from tests.ingest.synthetic_workbooks import workbook

ZEROS = gzip.compress(LOG + b"\0" * (2 << 20))
NESTED = gzip.compress(gzip.compress(LOG))
WIDE_SHEET = text(f"run,mAh,{',' * 40}", [f"r{n},812,{',' * 40}" for n in range(9)])
CORTEX = (
    b"[Force Data]\nNumberOfForcePlates=1\nSampleRate=450\nNumberOfSamples=2\n#Sample\tFX1\tFY1\tFZ1\tX1\tY1\tZ1\tMZ1\n"
    b"1\t0\t0\t9\t0\t0\t0\t0\n2\t0\t0\t9\t1\t1\t0\t0\n"
)
BEYOND = [
    ("most_columns", 3, LOG),
    ("most_columns", 3, WIDE_SHEET),
    ("most_columns", 3, CORTEX),
    ("most_columns", 1, mat({"a": [[1.0, 2.0]] * 5})),
    ("longest_line_bytes", 20, LOG),
    ("longest_line_bytes", 300, with_row("1," * 300)),
    ("largest_expanded_bytes", 1000, zipped({"a.csv": LOG})),
    ("largest_expanded_bytes", 1000, gzip.compress(LOG)),
    ("largest_expanded_bytes", 1000, workbook({"a": ROWS})),
    ("largest_expansion", 20, ZEROS),
    ("largest_expansion", 20, zipped({"a.csv": LOG + b"\0" * (2 << 20)})),
    ("largest_expansion", 20, mat({"x": np.zeros(1 << 17)}, packed=True)),
    ("most_members", 3, zipped({f"{n}.csv": LOG for n in range(4)})),
    ("most_members", 3, workbook({"a": ROWS})),
    ("deepest_nesting", 1, NESTED),
    ("deepest_nesting", 1, zipped({"a.zip": zipped({"a.csv": LOG})})),
    ("most_cells", 100, workbook({"a": ROWS})),
]


@pytest.mark.parametrize(("name", "most", "data"), BEYOND, ids=lambda value: value if isinstance(value, str) else "")
def test_a_bound_is_named_where_a_file_exceeds_it_and_can_be_raised(name: str, most: int, data: bytes) -> None:
    for bound, named in ((most, True), (10**9, False)):
        result = read_file(data, Declarations(limits=Limits(**{name: bound})))
        assert any(name in finding.message for finding in result.findings) is named


def test_each_bound_is_tested_here() -> None:
    tested = {name for name, _, _ in BEYOND} | {"largest_file_bytes"}  # where a file is read at all: test_spool.py
    assert tested == {field.name for field in dataclasses.fields(Limits)}
