"""What people give where a list of numbers belongs, and what to give instead."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from data_schema.errors import InputRefused


def refuse_what_is_no_list(name: str, values: Any) -> None:
    """Raise `InputRefused` for a table, a dict, a set, a generator or a single number, saying what to give instead.

    `name` is what the sentence calls the values.
    """
    if is_table(values):
        columns = [repr(str(column)) for column in values.columns]
        held = f"the column {columns[0]}" if len(columns) == 1 else f"{len(columns)} columns"
        like = f", for example df[{columns[0]}]" if columns else ""
        raise InputRefused(f"{name} is a table with {held} where one list of numbers is allowed: give a column{like}.")
    kind = type(values).__name__
    if isinstance(values, Mapping):
        raise InputRefused(f"{name} is a {kind}: give a list of its numbers, for example list(numbers.values()).")
    if isinstance(values, Iterable) and not hasattr(values, "__getitem__") and not hasattr(values, "__array__"):
        raise InputRefused(f"{name} is a {kind}: give a list of its numbers, for example list(numbers).")


def is_table(values: Any) -> bool:
    """Whether something is a data frame, of pandas or another package: none of them need be loaded."""
    return hasattr(type(values), "columns")
