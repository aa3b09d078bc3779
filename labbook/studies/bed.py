"""The bed study of a book (thesis ch. 5): what its report says of energy and apex heights, by foot and gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from matplotlib.figure import Figure

from data_schema.errors import InputRefused
from data_schema.outcomes import Outcome
from data_schema.queries.runs import refuse_empty_selection
from labbook.analysis.study import analyse
from labbook.book.opening import opened
from labbook.book.write_session import now_utc
from labbook.studies.study import Asked, Found, book_sources, damping_factor, level_of
from labbook.terminal import NOT_IN_JSON
from reports.claims import groups_in_one_sentence
from reports.display import (
    DASH,
    as_shown,
    common_places,
    count_text,
    in_sentence,
    interval_text,
    list_text,
    places_of,
    sentence_start,
    value_text,
    with_unit,
)
from reports.figures.by_level import coefficient_of, draw_side_by_side, has_quantity, points_text
from reports.numbers import Number
from reports.page.study import Study
from reports.results import StudyResults
from reports.tables.headlines import groups
from reports.tables.predictions import block_of, level_text_of, published_text, scene_sentences
from reports.tables.registry import TABLES, tables_of
from reports.tables.table import Raw

OUTCOMES = (Outcome.JOULES, Outcome.APEX)


@dataclass(frozen=True, slots=True)
class BedStudy(Study):
    """What the report claims of a selection, and all its tables by their names, a record a row, without those of runs.

    `not_simulated` says why nothing stands beside.
    """

    title: ClassVar[str] = "What active damping saves on the granular bed"
    results: StudyResults = field(metadata=NOT_IN_JSON)
    claims: tuple[str, ...]
    tables: Mapping[str, Sequence[Mapping[str, Raw]]]
    not_simulated: str

    def sentences(self) -> list[str]:
        """Say what active damping saves, in all and by group, and whether height is lost."""
        results, lines = self.results, list(self.claims)
        if results.overall:
            found = groups(results).items()
            savings = {name: joules.decision.savings for name, (joules, _apex) in found if joules is not None}
            places = common_places(savings.values())
            lines.append(
                f"Saved by group: {list_text([f'{_text(one, places)} with {name}' for name, one in savings.items()])}."
            )
        if together := groups_in_one_sentence(results, Outcome.APEX):
            lines.append(f"Apex height, {in_sentence(together)}")
        lines.append(results.no_equivalence)
        for outcome in OUTCOMES:
            if not has_quantity(results, outcome):
                without = results.flow.runs_without[outcome]
                why = list_text([f"{count_text(n, 'run')}: {reason}" for reason, n in without.items()])
                lines.append(f"There are no {outcome.plural} of these runs{f' ({why})' if why else ''}.")
        return [*filter(None, [*lines, *scene_sentences(results), self.not_simulated])]

    def table(self) -> Sequence[Sequence[str]]:
        """Return the comparisons of each damping gain with its control: joules, as the report has them."""
        table = TABLES[f"comparisons_{Outcome.JOULES.key}"].make(self.results)
        rows = [[row.block, *(cell.text for cell in table.cells(row))] for row in table.rows]
        return [["group", *(column.head for column in table.heads)], *rows]

    def beside(self) -> list[tuple[str, ...]]:
        """Return what was measured and simulated of all that the thesis has a number of (5.2)."""
        results = self.results
        return [
            (
                ", ".join(filter(None, [item.quantity.short, block_of(results, item), level_text_of(results, item)])),
                _text(item.measured),
                _text(item.check.predicted),
                published_text(item.published),
            )
            for item in results.predictions.items
            if item.published is not None
        ]

    def caption(self) -> str:
        """Say what is drawn."""
        drawn = [outcome for outcome in OUTCOMES if has_quantity(self.results, outcome)]
        what = sentence_start(list_text([in_sentence(outcome.heading) for outcome in drawn]))
        points = dict.fromkeys(points_text(self.results, outcome) for outcome in drawn)
        return " ".join([f"{what} against the {coefficient_of(self.results)} (thesis figures 5.3, 5.4).", *points])

    def draw(self) -> Figure:
        """Draw joules and apexes by damping gain."""
        return draw_side_by_side(self.results, OUTCOMES)


def _text(number: Number | None, places: int | None = None) -> str:
    """Write a number with its interval: "7.7 % (2.0 to 12.9)"."""
    if number is None or not isinstance(number.value, int | float):
        return DASH
    shown, places = as_shown(number), places_of(number) if places is None else places
    ends = interval_text(number, places, unit=False)
    text = with_unit(value_text(shown.value, places), shown.unit)
    return f"{text} ({ends})" if isinstance(shown.ci_low, float) else text


def ask(asked: Asked) -> Found[BedStudy]:
    """Make the report of a book's runs, which compares active damping with its control; the book does not have it.

    Raises `UsageError` for a book without an active-damping gain that has a control, `InputRefused` where none of its
    groups has joules of both.
    """
    with opened(asked.book) as book, book.reading() as connection:
        configuration, options = book.configuration, asked.settled("bed", book.configuration)
        level = None if options.level is None else level_of(options)
        refuse_empty_selection(connection, options.where)
        damping = damping_factor(configuration, "0, 50, 100, 150, 200, 250")
        results = analyse(
            connection,
            book.store,
            configuration,
            where=options.where,
            made_at=now_utc(),
            progress=asked.step,
            level=level,
        ).results
        sources = book_sources(connection, configuration, options.where or "all")
    if not any(one.quantity is Outcome.JOULES and one.opens for one in results.comparisons):
        without = results.flow.runs_without[Outcome.JOULES]
        why = list_text([f"{n} run{'' if n == 1 else 's'}: {reason}" for reason, n in without.items()])
        raise InputRefused(
            f"no group of the runs ({options.where or 'all'}) has joules of the control and of another {damping}, which"
            f" the study compares: run both, or select both by --where."
            f"{f' Missing: {why}; `labbook attention` says more.' if why else ''}"
        )
    unsimulated = "Not simulated: labbook.toml has no [simulation]." if configuration.simulation is None else ""
    tables = {kind.name: kind.make(results).records for kind in tables_of(results) if not kind.by_run}
    claims = tuple(claim.text for claim in results.claims)
    return Found(BedStudy(results, claims, tables, unsimulated), sources)
