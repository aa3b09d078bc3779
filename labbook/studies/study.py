"""What a study is asked with, and what of its book it comes from; what it shows is `reports.page.study.Study`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, fields, replace
from pathlib import Path
from typing import Generic, TypeVar

import sqlalchemy as sa

from data_schema import journal
from data_schema.errors import UsageError
from data_schema.frozen import frozen
from data_schema.vocabulary import FactorKind
from labbook.analysis.comparison.pairing import swept_factor
from labbook.config.model import Configuration, StudyProtocol
from reports.page.study import Study
from stats.checks import as_level

S_co = TypeVar("S_co", bound=Study, covariant=True)
V = TypeVar("V")


@frozen
class Asked:
    """What a study is asked: of `book`, None being the one that holds this folder, or of the sheet `file`.

    `options` are those of the command line, None where `[studies.NAME]` of labbook.toml decides. `complete`: the last
    line of a file is whole without a line end. `step` is told what is being done.
    """

    book: Path | None = None
    file: Path | None = None
    options: StudyProtocol = field(default_factory=StudyProtocol)
    complete: bool = False
    step: Callable[[str], None] = lambda _what: None

    def settled(self, study: str, configuration: Configuration) -> StudyProtocol:
        """Return the options, each as given, else as `[studies.NAME]` says."""
        of_book = configuration.studies.get(study, StudyProtocol())
        given = {one.name: getattr(self.options, one.name) for one in fields(StudyProtocol)}
        return replace(of_book, **{name: value for name, value in given.items() if value is not None})


def first_given(option: V | None, usual: V) -> V:
    """Return an option, or what is usual where it was not given."""
    return usual if option is None else option


def level_of(options: StudyProtocol) -> float:
    """Return the level of a study's intervals, 0.95 where nothing else is asked."""
    return as_level("--level", first_given(options.level, 0.95))


@frozen
class Found(Generic[S_co]):
    """A study with what it comes from: by name the facts of its book, and the files read with their SHA-256."""

    study: S_co
    sources: tuple[tuple[str, str], ...]
    files: tuple[tuple[str, str], ...] = ()


def book_sources(
    connection: sa.Connection, configuration: Configuration, runs: str | None = None
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
    """Return the name of the factor of the active-damping gain; a refusal suggests `levels` for it."""
    damping = swept_factor(configuration)
    if damping is None or configuration.factors[damping].kind is not FactorKind.NUMBER:
        raise UsageError(
            "the study compares active-damping gains with a control, and labbook.toml has none: write "
            f'[factors.{damping or "b_ad_gain"}] with kind = "number", levels = [{levels}] and control = 0.'
        )
    return damping
