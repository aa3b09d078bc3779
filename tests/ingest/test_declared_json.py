"""How a file was read can be written down and read back, whatever was declared."""

from __future__ import annotations

import json

from hypothesis import given
from hypothesis import strategies as st

from ingest.declared_json import declared_from_json, declared_to_json
from ingest.model import ColumnDeclaration, Declarations, Profile

TEXT = st.text(max_size=8)
NUMBER = st.floats(allow_nan=False, allow_infinity=False)
COLUMN = st.builds(ColumnDeclaration, st.none() | TEXT, st.none() | TEXT, st.sampled_from((-1, 1)))
COLUMNS = st.dictionaries(TEXT, COLUMN, max_size=3)
PROFILE = st.builds(
    Profile,
    name=TEXT,
    recognise=st.lists(TEXT, max_size=3).map(tuple),
    rate_hz=st.none() | NUMBER,
    time_column=st.none() | TEXT,
    time_unit=st.none() | TEXT,
    columns=COLUMNS,
)
DECLARED = st.builds(
    Declarations,
    rate_hz=st.none() | NUMBER,
    time_column=st.none() | TEXT,
    time_unit=st.none() | TEXT,
    columns=COLUMNS,
    profiles=st.lists(PROFILE, max_size=2).map(tuple),
    encoding=TEXT,
    time_zone=st.none() | TEXT,
    decimal_sign=st.none() | st.sampled_from((".", ",")),
    format=st.none() | TEXT,
    instrument=st.none() | TEXT,
)


@given(DECLARED)
def test_what_was_declared_comes_back(declared: Declarations) -> None:
    assert declared_from_json(json.loads(json.dumps(declared_to_json(declared)))) == declared


def test_a_field_that_is_not_there_is_as_usual_and_an_unknown_one_is_left_out() -> None:
    assert declared_from_json({"rate_hz": 300, "of_the_future": 1}) == Declarations(rate_hz=300.0)
    assert declared_from_json({}) == Declarations()
