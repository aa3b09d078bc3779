"""How a file was read can be written down and read back, whatever was declared."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from typing import Any, get_args, get_origin, get_type_hints

from hypothesis import given
from hypothesis import strategies as st

from ingest.declared import declared_from_json, declared_to_json
from ingest.model import Declarations

TEXT = st.text(max_size=8)
NUMBER = st.floats(allow_nan=False, allow_infinity=False)


def drawn(kind: type[Any]) -> st.SearchStrategy[Any]:
    """Draw every field of a dataclass, also those that are new."""
    return st.builds(kind, **{name: of(hint) for name, hint in get_type_hints(kind).items()})


def of(hint: Any) -> st.SearchStrategy[Any]:
    inner = get_args(hint)
    if dataclasses.is_dataclass(hint):
        assert isinstance(hint, type)
        return drawn(hint)
    if type(None) in inner:
        return st.none() | of(inner[0])
    if get_origin(hint) is tuple and inner[1:] != (...,):
        return st.tuples(*map(of, inner))
    if get_origin(hint) is tuple:
        return st.lists(of(inner[0]), max_size=2).map(tuple)
    if get_origin(hint) is Mapping:
        return st.dictionaries(TEXT, of(inner[1]), max_size=2)
    return NUMBER if hint is float else TEXT if hint is str else st.from_type(hint)


DECLARED = drawn(Declarations)


@given(DECLARED)
def test_what_was_declared_comes_back(declared: Declarations) -> None:
    assert declared_from_json(json.loads(json.dumps(declared_to_json(declared)))) == declared


def test_a_field_that_is_not_there_is_as_usual_and_an_unknown_one_is_left_out() -> None:
    assert declared_from_json({"rate_hz": 300, "of_the_future": 1}) == Declarations(rate_hz=300.0)
    assert declared_from_json({}) == Declarations()
