"""Results of `stats` for people: their fields with what each means, as the classes themselves say it."""

from __future__ import annotations

import ast
import functools
import inspect
import textwrap
from collections.abc import Collection, Iterator, Sequence
from dataclasses import is_dataclass
from typing import Any

from data_schema.rounding import error_of, number_text
from stats.results import as_dict

DIGITS = 6
"""Significant digits shown; JSON has all."""
_REASON = "_reason"
_INTERVALS = ("ci", "interval")
_WIDEST = 24


def field_lines_of_each(results: Sequence[Any]) -> list[list[str]]:
    """Return the lines of every result; a field is explained where a class first has a value of it."""
    explained: set[tuple[type, str]] = set()
    found = []
    for result in results:
        kind = type(result)
        found.append(field_lines(result, {name for of, name in explained if of is kind}))
        explained |= {(kind, name) for name, _value, reason in _fields(result) if reason is None}
    return found


def field_lines(result: Any, known: Collection[str] = ()) -> list[str]:
    """Return one line a field: name, value, what it is; results within the result and tables are left out.

    Fields that are `known` are not explained.
    """
    kind: Any = type(result)
    explained = explanations(kind)
    rows = [
        (name, value_text(name, value), reason, "" if name in known else explained.get(name, ""))
        for name, value, reason in _fields(result)
    ]
    names = max((len(name) for name, *_rest in rows), default=0)
    texts = max((len(text) for _name, text, reason, _explained in rows if reason is None), default=0)
    texts = min(texts, _WIDEST)
    return [
        f"  {name:<{names}}  undefined because {reason}"
        if reason is not None
        else f"  {name:<{names}}  {text:<{texts}}  {explanation}".rstrip()
        for name, text, reason, explanation in rows
    ]


def table_of(results: Sequence[Any], left_out: Sequence[str] = ()) -> list[list[str]]:
    """Return results of one class as rows of texts, heads first; reasons of what is undefined in its place."""
    found = [
        {
            name: value_text(name, value) if reason is None else "undefined"
            for name, value, reason in _fields(result)
            if name not in left_out
        }
        for result in results
    ]
    heads = list(dict.fromkeys(name for row in found for name in row))
    return [heads, *([row.get(head, "") for head in heads] for row in found)]


def reasons_of(results: Sequence[Any], left_out: Sequence[str] = ()) -> list[str]:
    """Return why fields of these results are undefined, each reason once."""
    fields = [field for result in results for field in _fields(result)]
    return sorted({f"undefined because {why}" for name, _value, why in fields if why and name not in left_out})


def _fields(result: Any) -> Iterator[tuple[str, Any, str | None]]:
    """Give name, value and why it is undefined of each field that is no result and no table."""
    data = as_dict(result)
    for name, value in data.items():
        reason = data.get(f"{name}{_REASON}")
        of_other = name.endswith(_REASON) and name.removesuffix(_REASON) in data
        if not of_other and (reason is not None or _is_plain(value)):
            yield name, value, reason


def value_text(name: str, value: Any) -> str:
    """Return a field as JSON holds it in words: numbers rounded for display, an interval as "1.2 to 3.4"."""
    match value:
        case None:
            return "none"
        case bool():
            return "yes" if value else "no"
        case float():
            return number_text(value, DIGITS)
        case [float(), float()] if name.endswith(_INTERVALS):
            return " to ".join(number_text(end, DIGITS, error_of((value[0], value[1]))) for end in value)
        case list():
            return ", ".join(value_text("", item) for item in value)
        case _:
            return str(value)


def _is_plain(value: Any) -> bool:
    return not isinstance(value, dict) and not (isinstance(value, list) and any(isinstance(v, dict) for v in value))


@functools.cache
def explanations(kind: type[object]) -> dict[str, str]:
    """Return the first sentence of what a class says below each of its fields, and in each of its properties."""
    found: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        if not is_dataclass(base):
            continue
        body = _body(base)
        for statement, following in zip(body, [*body[1:], None], strict=True):
            match statement, following:
                case (
                    ast.AnnAssign(target=ast.Name(id=name)),
                    ast.Expr(value=ast.Constant(value=str(text))),
                ):
                    found[name] = _first_sentence(text)
                case ast.FunctionDef(name=name), _ if isinstance(vars(base).get(name), property):
                    found[name] = _first_sentence(ast.get_docstring(statement) or "")
    return found


def _body(kind: type) -> list[ast.stmt]:
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    return definition.body if isinstance(definition, ast.ClassDef) else []


def _first_sentence(text: str) -> str:
    words = " ".join(text.split()).replace("`", "")
    return f"{words.split('. ')[0].rstrip('.')}."
