"""The factors of a study in `labbook.toml`, their levels, and what their gains mean physically."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from data_schema.errors import unknown_name
from data_schema.vocabulary import FactorKind
from labbook.config.model import FactorSettings, GainSettings, LevelSettings, number_label
from labbook.config.tables import TableReader, as_number, is_plain

RESERVED_NAMES = frozenset(
    {
        *("run", "date", "day", "position", "kind", "state", "battery", "robot", "started", "duration_s"),
        *("jumps_made", "starts", "note", "study", "levels", "and", "or", "not", "in"),
    }
)
"""Names that mean something else in a run sheet or in `--where`, so that no factor can have them."""


def read_factors(top: TableReader) -> dict[str, FactorSettings]:
    """Read every `[factors.NAME]`; one of them at most names a control."""
    factors: dict[str, FactorSettings] = {}
    for name, table in top.tables("factors"):
        folded = [other.casefold() for other in factors]
        if not name.isidentifier() or name.casefold() in RESERVED_NAMES or name.casefold() in folded:
            table.fault("name", f"{name!r} is no name for a factor, or is taken: use other letters, digits and _.")
        factor = _factor(table)
        swept = next((other for other, before in factors.items() if before.control is not None), None)
        if factor.control is not None and swept is not None:
            table.fault("control", f"[factors.{swept}] names a control already: keep one, for one factor is swept.")
        factors[name] = factor
    return factors


def unknown_factor(name: str, factors: Iterable[str], kind: FactorKind | None = None) -> str:
    """Return the sentence for a factor that is none of `factors`, of some kind, with the section to write."""
    of_kind, keys = ("", "kind") if kind is None else (f" of kind {kind}", f'kind = "{kind}"')
    known = list(factors)
    remedy = f"{'Or write' if known else 'Write'} [factors.{name}] with {keys} and levels."
    return str(unknown_name(f"factor{of_kind}", name, known, remedy))


def read_gains(top: TableReader, factors: Mapping[str, FactorSettings]) -> dict[str, GainSettings]:
    """Read every `[gains.FACTOR]`."""
    numbers = [name for name, factor in factors.items() if factor.kind is FactorKind.NUMBER]
    gains: dict[str, GainSettings] = {}
    for name, table in top.tables("gains"):
        if name not in numbers:
            table.fault("factor", unknown_factor(name, numbers, FactorKind.NUMBER))
        gains[name] = GainSettings(
            symbol=table.text("symbol"),
            slope=table.number("slope"),
            offset=table.number("offset"),
            unit=table.text("unit"),
            zero=table.optional_number("zero"),
        )
        if gains[name].slope == 0:
            table.fault("slope", "0 makes every gain the same: give another slope.")
        table.finish()
    return gains


def _factor(table: TableReader) -> FactorSettings:
    kind = table.word("kind", FactorKind)
    title, unit = table.optional_text("title"), table.optional_text("unit")
    levels = tuple(_number_levels(table) if kind is FactorKind.NUMBER else _label_levels(table))
    labels = [level.label for level in levels]
    if not table.value("levels"):
        example = "levels = [300, 400]" if kind is FactorKind.NUMBER else 'levels = ["small", "large"]'
        table.fault("levels", f"there are none: write for example {example}.")
    for label, count in Counter(labels).items():
        if count > 1:
            table.fault("levels", f"{label!r} is there {count} times: keep one.")
    control = table.value("control")
    if control is not None:
        number = as_number(control)
        given = str(control) if number is None else number_label(number)
        control = table.known("control", given, labels, "level") if labels else None
    names = table.optional_text("control_name"), table.optional_text("treatment")
    table.finish()
    return FactorSettings(kind, title, unit, levels, control, *names)


def _number_levels(table: TableReader) -> Iterable[LevelSettings]:
    for given in table.items("levels", "numbers"):
        number = as_number(given)
        if number is None:
            table.fault("levels", f'{given!r} is not a number: write numbers without quotes, or kind = "label".')
        else:
            yield LevelSettings(number_label(number), number, {})


def _label_levels(table: TableReader) -> Iterable[LevelSettings]:
    if isinstance(table.value("levels"), dict):
        for label, below in table.tables("levels"):
            yield LevelSettings(label, None, {name: _attribute(below, name) for name in below.names()})
        return
    for given in table.items("levels", "names in quotes"):
        if isinstance(given, str) and is_plain(given):
            yield LevelSettings(given, None, {})
        else:
            table.fault("levels", f'{given!r} is not a name: write names in quotes, or kind = "number".')


def _attribute(table: TableReader, name: str) -> float | str:
    given: Any = table.value(name)
    number = as_number(given)
    return table.text(name) if number is None else number
