"""Runs with their values, read from the table beside the script, and printing what was computed."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

Row = dict[str, str]
"""A line of the table, by the names of its columns."""
Rows = Sequence[Row]
Number = Mapping[str, float]
"""A value, and by their names what belongs to it: standard errors, ends of its interval, degrees of freedom."""


class Source(NamedTuple):
    """An error that several runs share: the fit that it comes from, which of its terms, its degrees of freedom."""

    fit: str
    term: str
    df: float


Shared = dict[Source, float]
"""Signed standard errors that a value shares with other values, by their source; sources are independent."""


class Run(NamedTuple):
    """A run: its line of the table, its value, and the errors that it shares with other runs."""

    row: Row
    value: float
    shared: Shared


Runs = Sequence[Run]
Pair = tuple[Sequence[str], Sequence[str]]
"""The conditions of a control, and those that are compared with it."""


def read(table: str) -> list[Row]:
    """Read the table that lies beside this script."""
    with (Path(__file__).parent / table).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def of_conditions(runs: Runs, conditions: Sequence[str]) -> list[Run]:
    """Return the runs of some conditions, one condition after the other."""
    return [run for condition in conditions for run in runs if run.row["condition"] == condition]


def values_of(runs: Runs) -> list[float]:
    """Return the values of runs."""
    return [run.value for run in runs]


PICKED = "value"
"""Which of several numbers that were computed together is asked for."""


def picked(found: Number) -> Number:
    """Return the number that is asked for, with the degrees of freedom."""
    return {"value": found[PICKED], **({"df": found["df"]} if "df" in found else {})}


def show(number: Number) -> None:
    """Print the number with all its digits, and below it what belongs to it."""
    for name, value in number.items():
        print(repr(float(value)) if name == "value" else f"{name} = {float(value)!r}")
