"""What all results have in common: a row for pandas and plain data for JSON, with the reasons of what is undefined.

A number that does not exist is a missing value in both, and `<field>_reason` says why; nothing is rounded.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from data_schema.vocabulary import Undefined

if TYPE_CHECKING:
    import pandas as pd

_ENDS = ("_ci", "_interval")


class Result:
    """Base of the frozen results of this package: fields and computed properties, in the order of the class."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the result as JSON holds it: numbers, words, lists; None and a reason where a value is undefined."""
        return as_dict(self)

    def to_json(self) -> str:
        """Return `to_dict` as text."""
        return json.dumps(self.to_dict(), ensure_ascii=False, allow_nan=False)

    def to_frame(self) -> pd.DataFrame:
        """Return one row: nested results as `<field>_<its field>`, intervals as `<field>_low` and `<field>_high`."""
        return frame_of([self])


def names_of(result: Any) -> list[str]:
    """Return the public fields of a result and then its properties: those computed on first access, too."""
    names = [field.name for field in fields(result) if not field.name.startswith("_")]
    for kind in reversed(type(result).__mro__):
        names += [
            name for name, value in vars(kind).items() if isinstance(value, property) and not name.startswith("_")
        ]
    return list(dict.fromkeys(names))


def as_dict(result: Any) -> dict[str, Any]:
    """Return any frozen result as `Result.to_dict` does."""
    return _with_reasons({name: getattr(result, name) for name in names_of(result)})


def frame_of(results: Iterable[Any]) -> pd.DataFrame:
    """Return any frozen results as a frame, one row a result."""
    import pandas as pd

    return pd.DataFrame([_row(result) for result in results])


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
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Fraction):
        return float(value)
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


def _row(result: Any) -> dict[str, Any]:
    row: dict[str, Any] = {}
    for name in names_of(result):
        value = getattr(result, name)
        is_interval = name.endswith(_ENDS) and (isinstance(value, Undefined) or _is_pair(value))
        if isinstance(value, Undefined):
            row |= dict.fromkeys((f"{name}_low", f"{name}_high") if is_interval else (name,), math.nan)
        elif is_interval:
            row |= {f"{name}_low": value[0], f"{name}_high": value[1]}
        elif is_dataclass(value) and not isinstance(value, type):
            row |= {f"{name}_{inner}": item for inner, item in _row(value).items()}
        else:
            row[name] = value if isinstance(value, float) else _plain(value)
        if isinstance(value, Undefined) or _may_be_undefined(result, name):
            row[f"{name}_reason"] = _reason(value)
    return row


def _is_pair(value: Any) -> bool:
    return isinstance(value, tuple) and len(value) == 2


def _may_be_undefined(result: Any, name: str) -> bool:
    """Tell from the annotation whether a field has a column of reasons, so that all rows have the same columns."""
    for field in fields(result):
        if field.name == name:
            return "Undefined" in str(field.type)
    getter = getattr(type(result), name).fget
    return "Undefined" in str(getter.__annotations__.get("return", ""))
