"""A study of a book, and what of the book it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

import sqlalchemy as sa

from data_schema import journal
from data_schema.errors import UsageError
from data_schema.queries.readings import readings_in_force
from data_schema.queries.runs import has_runs
from data_schema.vocabulary import FactorKind, StudyKind
from labbook.analysis.comparison.pairing import swept_factor
from labbook.config.model import STUDY_KEYS, Configuration

S = TypeVar("S")
V = TypeVar("V")
LEVEL = 0.95
SHEETS: Mapping[str, tuple[str, str]] = {
    "compaction": ("flask_sheet", "radius_mm,state,water_ml"),
    "field": ("walk_sheet", "walk,robot,mass_kg,distance_m,energy_Wh"),
    "characterisation": ("trial_sheet", "file,gain,damping_gain,mass_kg"),
}
"""By study the format of its sheet in a book, and a header of one."""
_KINDS = {StudyKind.BED: "bed", StudyKind.EMULATOR: "emulator", StudyKind.FORCE_PLATE: "force-plate"}
"""The studies that the runs of a book of some kind are made for."""


@dataclass(frozen=True, slots=True)
class OfBook(Generic[S]):
    """A study with its sources by name: the book's configuration, the runs selected, the journal as it was read."""

    study: S
    sources: tuple[tuple[str, str], ...]


def first_given(option: V | None, protocol: V | None, usual: V) -> V:
    """Return the value of the command line, else that of labbook.toml, else the default."""
    if option is not None:
        return option
    return usual if protocol is None else protocol


def book_sources(
    connection: sa.Connection, configuration: Configuration, runs: str | None
) -> tuple[tuple[str, str], ...]:
    """Name the sources of a study, in the reading transaction that it is computed in; `runs` selects runs, if any."""
    entries, head = journal.head(connection)
    return (
        ("Study", configuration.study.name),
        *((("Runs", runs),) if runs is not None else ()),
        ("labbook.toml", f"SHA-256 {configuration.sha256}"),
        ("Journal", f"{entries} entries, the last {head}, which name every file by its hash"),
    )


def damping_factor(configuration: Configuration, levels: str) -> str:
    """Return the name of the factor of the active-damping gain; `levels` are those that a refusal suggests."""
    damping = swept_factor(configuration)
    numbers = [name for name, factor in configuration.factors.items() if factor.kind is FactorKind.NUMBER]
    if damping is None and numbers:
        raise UsageError(
            "no factor of labbook.toml has a control to compare with: write control = 0 under that of "
            f"the active-damping gain, one of {', '.join(f'[factors.{name}]' for name in numbers)}."
        )
    if damping is not None and damping not in numbers:
        raise UsageError(
            f"{damping} has levels that are words, and the study compares numbers: give [factors.{damping}] kind = "
            f'"number" and levels such as [{levels}].'
        )
    if damping is None:
        raise UsageError(
            "labbook.toml has no active-damping gain to compare by: write [factors.b_ad_gain] with "
            f'kind = "number", levels = [{levels}] and control = 0.'
        )
    return damping


def studies_of_book(connection: sa.Connection, configuration: Configuration) -> list[str]:
    """Name the studies of a book, in the order of `STUDY_KEYS`.

    They are those that labbook.toml has a table of, those whose sheet was ingested, and the one its runs are made for;
    that is the bed's, whose kind every new book has, only with a control and without a table of another of runs.
    """
    of_reader = {reader: study for study, (reader, _header) in SHEETS.items()}
    there = {of_reader[row.reader] for row in readings_in_force(connection, list(of_reader))}
    there |= set(configuration.studies)
    kind = configuration.study.kind
    of_kind = {_KINDS[kind]} if kind in _KINDS and has_runs(connection) else set()
    if swept_factor(configuration) is None or there & set(_KINDS.values()):
        of_kind.discard("bed")
    there |= of_kind
    return [study for study in STUDY_KEYS if study in there]
