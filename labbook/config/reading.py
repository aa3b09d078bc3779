"""Read TOML into a typed model, and turn what does not fit into sentences.

A fault says where it is (table and key), what was given, and what is allowed or nearest. All faults are collected.
"""

from __future__ import annotations

import functools
import json
import math
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta, inspect
from msgspec.structs import asdict

from data_schema.errors import unknown_name
from data_schema.outcomes import Outcome
from labbook.config.model import number_label

_Model = TypeVar("_Model")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")

Faults = list[str]
"""Sentences, each with its place before it."""


def is_plain(text: str) -> bool:
    """Tell whether a text can be shown, typed and stored: not empty, not padded with spaces, nothing unprintable."""
    return text != "" and text == text.strip() and not any(unicodedata.category(sign) in ("Cc", "Cs") for sign in text)


def below(path: str, key: str) -> str:
    """Return the place of a key below a place, as TOML writes it."""
    key = key if _BARE_KEY.fullmatch(key) else json.dumps(key, ensure_ascii=False)
    return f"{path}.{key}" if path else key


def read_model(model: type[_Model], table: Mapping[str, Any], faults: Faults) -> _Model | None:
    """Read a table of TOML into a model; returns None, with faults added, where it does not fit."""
    return _Reader(faults).read(_type_of(model), table, "")  # type: ignore[arg-type, no-any-return]


@functools.cache
def _type_of(model: Any) -> inspect.Type:
    """Return what msgspec knows of a model, which takes it 10 ms of the whole configuration."""
    return inspect.type_info(model)


@dataclass
class _Reader:
    """Reads values of TOML by their types, None where one does not fit."""

    faults: Faults

    def read(self, kind: inspect.Type, given: Any, path: str) -> Any:
        typed, (kind, notes) = kind, _bare(kind)
        if isinstance(kind, inspect.UnionType):
            typed = _fitting(kind, given)
            kind, notes = _bare(typed)
        if notes.get("label") and _is_number(given):
            given = number_label(float(given))
        words = _words(kind)
        match kind, given:
            case inspect.StructType() | inspect.DataclassType(), dict():
                return self._table(kind, given, path)
            case inspect.DictType(), dict():
                return self._names(kind, given, path)
            case inspect.VarTupleType(), list():
                return tuple(self.read(kind.item_type, each, path) for each in given)
            case inspect.TupleType(), list() if len(given) == len(kind.item_types):
                return tuple(self.read(one, each, path) for one, each in zip(kind.item_types, given, strict=True))
            case _, str() | int() if words:
                if given in words:
                    return words[given]
                what = path.rpartition(".")[2].replace("_", " ")
                self.faults.append(f"{path}: {unknown_name(what, str(given), map(str, words))}")
                return None
        try:
            return _scalar(kind, given)
        except ValueError:
            self.faults.append(f"{path}: {given!r} is not {_allowed(typed, path)}: correct it.")
            return None

    def _table(self, kind: inspect.StructType | inspect.DataclassType, given: dict[str, Any], path: str) -> Any:
        fields = {one.encode_name: one for one in kind.fields if not _bare(one.type)[1].get("readOnly")}
        before = len(self.faults)
        self.faults += [f"{below(path, key)}: {unknown_name('key', key, fields)}" for key in given if key not in fields]
        values = {}
        for key, one in fields.items():
            if key in given:
                values[one.name] = self.read(one.type, given[key], below(path, key))
            elif one.required:
                self.faults.append(f"{below(path, key)}: is missing: give {_allowed(one.type, below(path, key))}.")
        return kind.cls(**values) if len(self.faults) == before else None

    def _names(self, kind: inspect.DictType, given: dict[str, Any], path: str) -> dict[str, Any]:
        """Read a table whose keys are names that a person chose, or words of a closed list."""
        words = _words(kind.key_type)
        for name in given:
            if words and name not in words:
                self.faults.append(f"{below(path, name)}: {unknown_name('key', name, map(str, words))}")
            elif not is_plain(name):
                advice = "a name is not empty, padded with spaces or unprintable: change it."
                self.faults.append(f"{below(path, name)}: {advice}")
        return {name: self.read(kind.value_type, value, below(path, name)) for name, value in given.items()}


def _scalar(kind: inspect.Type, given: Any) -> Any:
    """Convert a number, a text, a flag or a date. Raises `ValueError` for what the type is not."""
    is_odd = isinstance(given, int | float) and not isinstance(given, bool) and not _is_number(given)
    is_odd |= isinstance(given, str) and not is_plain(given) and getattr(kind, "pattern", None) is None
    if is_odd or type(kind) not in _SCALARS:
        raise ValueError
    bounds = {name: bound for name, bound in asdict(kind).items() if bound is not None}
    return msgspec.convert(given, Annotated[_SCALARS[type(kind)], Meta(**bounds)])


_SCALARS: Mapping[type, Any] = {
    inspect.FloatType: float,
    inspect.IntType: int,
    inspect.BoolType: bool,
    inspect.StrType: str,
    inspect.DateType: date,
}


def _is_number(given: Any) -> bool:
    """Whether a value is a number with a finite float (true and false are none)."""
    if isinstance(given, bool) or not isinstance(given, int | float):
        return False
    try:
        return math.isfinite(float(given))
    except OverflowError:
        return False


def _bare(kind: inspect.Type) -> tuple[inspect.Type, dict[str, Any]]:
    """Return a type without what is noted about it, and the notes."""
    notes: dict[str, Any] = {}
    while isinstance(kind, inspect.Metadata):
        notes |= {**(kind.extra_json_schema or {}), **(kind.extra or {})}
        kind = kind.type
    return kind, notes


def _fitting(kind: inspect.UnionType, given: Any) -> inspect.Type:
    """Return the type of a union that something given is meant as; None is no value of TOML."""
    kinds = [one for one in kind.types if not isinstance(one, inspect.NoneType)]
    shapes: dict[type, Any] = {
        dict: (inspect.DictType, inspect.StructType, inspect.DataclassType),
        list: (inspect.VarTupleType, inspect.TupleType),
        str: (inspect.StrType,),
    }
    shape = shapes.get(type(given), (inspect.FloatType, inspect.IntType))
    return next((one for one in kinds if isinstance(_bare(one)[0], shape)), kinds[-1])


def _words(kind: inspect.Type) -> dict[Any, Any]:
    """Return the values of a closed list by what TOML calls them, none for another type."""
    if isinstance(kind, inspect.EnumType):
        return {getattr(one, "key", one.value): one for one in kind.cls}
    return {one: one for one in kind.values} if isinstance(kind, inspect.LiteralType) else {}


def _allowed(kind: inspect.Type, path: str) -> str:
    """Say what may stand at a place."""
    kind, notes = _bare(kind)
    if "description" in notes:
        return str(notes["description"])
    match kind:
        case inspect.UnionType():
            kinds = [one for one in kind.types if not isinstance(one, inspect.NoneType)]
            return " or ".join(_allowed(one, path) for one in kinds)
        case inspect.FloatType() | inspect.IntType():
            signs = ((">", kind.gt), (">=", kind.ge), ("<", kind.lt), ("<=", kind.le))
            bounds = " and".join(f" {sign} {bound:g}" for sign, bound in signs if bound is not None)
            return f"a {'whole ' if isinstance(kind, inspect.IntType) else ''}number{bounds}, without quotes"
        case inspect.BoolType():
            return "true or false, without quotes"
        case inspect.DateType():
            return "a date such as 2024-03-04"
        case inspect.TupleType():
            return f"a list of {len(kind.item_types)} numbers, [-3, 3]"
        case inspect.VarTupleType():
            return "a list in square brackets, with commas between"
        case inspect.DictType() | inspect.StructType() | inspect.DataclassType():
            return f"a table: [{path}] on a line of its own and its keys below"
    words = ", ".join(map(repr, _words(kind)))
    return f"one of {words}" if words else "a plain text in quotes"


def json_schema(model: type) -> dict[str, Any]:
    """Return the JSON schema of a model: without what is no key of TOML, and with words as TOML has them."""
    _schemas, definitions = msgspec.json.schema_components([model], ref_template="#/$defs/{name}")
    for name, definition in definitions.items():
        if "properties" in definition:
            filled = {key for key, one in definition["properties"].items() if one.get("readOnly")}
            definition["properties"] = {key: one for key, one in definition["properties"].items() if key not in filled}
            definition["additionalProperties"] = False
        if name == Outcome.__name__:
            definition["enum"] = [outcome.key for outcome in Outcome]
    return {**definitions.pop(model.__name__), "$defs": definitions}
