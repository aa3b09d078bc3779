"""What all results have in common: rows for pandas and plain data for JSON, with the reasons of what is undefined.

A number that does not exist is a missing value in both, and `<field>_reason` says why; nothing is rounded.

Sentences of results share some words; how numbers are rounded says `data_schema.rounding`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from data_schema.notebook import fields_html, table_html, value_text
from data_schema.rounding import decimals_for, fixed_text, interval_text, number_text
from data_schema.vocabulary import Remark, Undefined
from stats.scatter import Value

if TYPE_CHECKING:
    import pandas as pd


class Result:
    """Base of the frozen results of this package: fields and computed properties, in the order of the class."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the result as JSON holds it: numbers, words, lists; None and a reason where a value is undefined."""
        return as_dict(self)

    def to_json(self) -> str:
        """Return `to_dict` as text."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False)

    def _repr_html_(self) -> str:
        """Return the sentence, and the numbers below it in a fold, as notebooks show a result."""
        rows, method = self.rows(), getattr(self, "sentence", None)
        sentence = "" if method is None else method()
        if len(rows) <= 1:
            return fields_html(self.to_dict(), sentence=sentence)
        parts = [row.to_dict() for row in rows]
        shown = [name for name in parts[0] if not name.endswith("_reason") and value_text(parts[0][name]) is not None]
        texts = [[value_text(part[name]) or "" for name in shown] for part in parts]
        return f"<p>{escape(sentence)}</p>{table_html(shown, texts)}"

    def rows(self) -> Sequence[Result]:
        """Return what `to_frame` has a row of: the parts, of a result that is a list of such, or else the result."""
        return (self,)

    def to_frame(self) -> pd.DataFrame:
        """Return a row of each of `rows()`; what a list of parts has in common stands in `to_dict`.

        Nested results become `<field>_<its field>`, intervals `<field>_low` and `<field>_high`. What is undefined is
        NaN there, as pandas has it, and `<field>_reason` says why.
        """
        import pandas as pd

        return pd.DataFrame([_flat(row.to_dict()) for row in self.rows()])


@cache
def names_of(kind: Any) -> list[str]:
    """Return the public fields of a class of results and then its properties: those computed on first access, too."""
    names = [field.name for field in fields(kind) if not field.name.startswith("_")]
    for base in reversed(kind.__mro__):
        names += [
            name for name, value in vars(base).items() if isinstance(value, property) and not name.startswith("_")
        ]
    return list(dict.fromkeys(names))


def as_dict(result: Any) -> dict[str, Any]:
    """Return any frozen result as `Result.to_dict` does."""
    kind: Any = type(result)
    return _with_reasons({name: getattr(result, name) for name in names_of(kind)})


def _flat(data: Mapping[str, Any]) -> dict[str, Any]:
    row: dict[str, Any] = {}
    for name, value in data.items():
        if isinstance(value, Mapping):
            row |= {f"{name}_{inner}": item for inner, item in _flat(value).items()}
        elif name.endswith("_ci"):
            row[f"{name}_low"], row[f"{name}_high"] = value or (math.nan, math.nan)
        else:
            row[name] = math.nan if f"{name}_reason" in data else value
    return row


def _with_reasons(items: Mapping[str, Any]) -> dict[str, Any]:
    data: dict[str, Any] = {}
    for name, value in items.items():
        data[name] = _plain(value)
        reason = _reason(value)
        if reason is not None:
            data[f"{name}_reason"] = reason
    return data


def _reason(value: Any) -> str | None:
    if isinstance(value, Undefined):
        return value.reason
    if isinstance(value, float | np.floating) and not math.isfinite(value):
        return "infinite" if math.isinf(value) else "not a number"
    return None


def _plain(value: Any) -> Any:
    if _reason(value) is not None:
        return None
    if isinstance(value, Remark):
        return value.text
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if is_dataclass(value) and not isinstance(value, type):
        return as_dict(value)
    if isinstance(value, Mapping):
        return _with_reasons({str(key): item for key, item in value.items()})
    if isinstance(value, list | tuple):
        return [
            {"value": None, "reason": item.reason} if isinstance(item, Undefined) else _plain(item) for item in value
        ]
    return value


_SHARE_DECIMALS = 3


def share_text(share: Value) -> str:
    """Return a share of 1, such as R squared: three decimals, and as many more as distinguish it from 1."""
    if isinstance(share, Undefined):
        return "undefined"
    return fixed_text(share, max(_SHARE_DECIMALS, decimals_for(1.0 - share)))


def bounded_texts(
    value: float, interval: tuple[float, float] | Undefined, se: float, level: float, unit: str = ""
) -> tuple[str, str]:
    """Return an estimate and "95 % CI 1.23 to 4.56 J" with as many decimals as the standard error justifies."""
    return number_text(value, error=se), interval_text(interval, level, unit, se)


def plural(number: int, what: str) -> str:
    """Return "1 day" or "3 days"."""
    return f"{number} {what}{'' if number == 1 else 's'}"


def with_unit(unit: str) -> str:
    """Return the unit with the space that belongs before it."""
    return f" {unit}" if unit else ""


def missing_text(*missing: int) -> str:
    """Return ", 3 missing left out", or nothing where none were."""
    return f", {sum(missing)} missing left out" if any(missing) else ""
