"""Why a table refused a row, in words: read from the table's own constraints, whichever database said so."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import sqlalchemy as sa

_COMPARISON = re.compile(r"(?:(\w+) IS NULL OR )?(\w+) (>=|<=|>|<) (-?[\w.]+)")
_CHOICE = re.compile(r"(?:\w+ IS NULL OR )?(\w+) IN \((.+)\)")
_BOUNDS = {">=": "{} or more", "<=": "{} or less", ">": "more than {}", "<": "less than {}"}
_CALLED_BY = ("name", "key", "label", "date_local")
"""Columns by which people call a row."""


def why_refused(error: sa.exc.StatementError | OverflowError, table: sa.Table, values: Mapping[str, Any]) -> str:
    """Say which rule of `table` the `values` break and what it allows; what is no rule of it is said as it came."""
    original = getattr(error, "orig", None) or error
    said = str(original).strip().splitlines()[0]
    if isinstance(original, OverflowError) or "out of range" in said:
        return f"a whole number goes from {-(2**63)} to {2**63 - 1}"
    words = set(re.findall(r"\w+", said))
    for rule in table.constraints:
        if isinstance(rule, sa.CheckConstraint) and rule.name in words:
            return what_is_allowed(rule)
        if isinstance(rule, sa.UniqueConstraint) and (rule.name in words or _named_by_columns(rule, said)):
            return _there_is_one(table.name, [column.name for column in rule.columns], values)
    return said


def what_is_allowed(rule: sa.CheckConstraint) -> str:
    """Say what a check demands: `jumps_made >= 0` is "jumps_made must be 0 or more"."""
    test = str(rule.sqltext)
    comparison = _COMPARISON.fullmatch(test)
    if comparison is not None:
        absent, column, sign, bound = comparison.groups()
        return f"{column} must be {_BOUNDS[sign].format(bound)}{'' if absent is None else ', or not known'}"
    choice = _CHOICE.fullmatch(test)
    if choice is not None:
        return f"{choice[1]} must be one of {choice[2].replace(chr(39), '')}"
    return f"it must hold that {test}"


def _named_by_columns(rule: sa.UniqueConstraint, said: str) -> bool:
    """SQLite names the columns of a key that is there already, not the constraint."""
    columns = ", ".join(f"{column.table.name}.{column.name}" for column in rule.columns)
    return said.removeprefix("UNIQUE constraint failed: ") == columns


def _there_is_one(kind: str, columns: list[str], values: Mapping[str, Any]) -> str:
    called = next((values[name] for name in _CALLED_BY if name in columns and name in values), None)
    if called is not None:
        return f"there is a {kind} {called} already"
    return f"there is a {kind} with the same {' and '.join(columns)} already"
