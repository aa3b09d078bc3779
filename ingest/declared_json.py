"""Declarations as JSON and back, so that how a file was read can be kept beside the file.

Every field is written, also where it says what is usual: what is usual may change. Reading back, a field that is not
there has its default, for whoever wrote it did not know the field.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from ingest.model import Declarations

_T = TypeVar("_T")


def declared_to_json(declared: Declarations) -> dict[str, Any]:
    """Return what `json.dumps` takes: objects, lists, texts, numbers and None."""
    return {field.name: _plain(getattr(declared, field.name)) for field in dataclasses.fields(declared)}


def declared_from_json(record: Mapping[str, Any]) -> Declarations:
    """Return the declarations that `declared_to_json` wrote; fields that this labbook does not know are left out."""
    return _dataclass(Declarations, record)


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple | frozenset):
        return [_plain(item) for item in value]
    return value


def _dataclass(kind: type[_T], record: Mapping[str, Any]) -> _T:
    hints = typing.get_type_hints(kind)
    return kind(**{name: _typed(hints[name], value) for name, value in record.items() if name in hints})


def _typed(hint: Any, value: Any) -> Any:
    """Return a value of JSON as the type that a field is declared with."""
    if value is None:
        return None
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return _typed(next(part for part in inner if part is not type(None)), value)
    if dataclasses.is_dataclass(hint):
        assert isinstance(hint, type)  # noqa: S101 - an instance is no annotation
        return _dataclass(hint, value)
    if origin is tuple:
        items = inner[:1] * len(value) if inner[1:] == (...,) else inner
        return tuple(_typed(part, item) for part, item in zip(items, value, strict=True))
    if origin is not None and issubclass(origin, Mapping):
        return {name: _typed(inner[1], item) for name, item in value.items()}
    if origin is not None and issubclass(origin, Sequence | frozenset):
        return origin(_typed(inner[0], item) for item in value)
    return hint(value) if isinstance(hint, type) and not isinstance(value, hint) else value
