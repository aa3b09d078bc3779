"""What the commands of `labbook stats` have in common: values are observed, a question is asked of them, its answer is
put into lines and data, and its figures are drawn.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from data_schema.errors import UsageError
from data_schema.rounding import alpha_of_level
from labbook.actions.stats.data import DataSource, observe
from labbook.analysis.observations import Observations
from labbook.presenting.stats.fields import field_lines, field_lines_of_each, reasons_of, table_of
from labbook.presenting.stats.figures import as_drawn, as_shown_to_people, quantiles_of, residual_plot_of, residuals_of
from reports.figures.estimation import Estimation
from reports.figures.kind import check_form
from stats.checks import as_level

ALPHA = 0.05
SHARED_NOTE = "The error of the passive drain, which groups share in part, is left out of this."

Rows = list[list[str]]
"""A table as texts, its heads first."""


@dataclass(frozen=True, slots=True)
class Question:
    """The values that a test is asked about, and its level; they are `scale` times what was read."""

    observed: Observations
    source: DataSource
    alpha: float
    pooled: bool
    step: Callable[[str], None]
    scale: float = 1.0

    @property
    def level(self) -> float:
        """The level of intervals, 1 - alpha."""
        return 1.0 - self.alpha

    @property
    def control(self) -> str:
        """The control's name."""
        return self.observed.name(self.observed.control)

    @property
    def has_shared_errors(self) -> bool:
        """Whether values share an error, as joules corrected by one drain line do."""
        return any(row.shared.se > 0.0 for row in self.observed.rows)


@dataclass
class Answer:
    """Sentences and notes; `fields` are what stands behind them, shown on request; `data` all of it for programs.

    `drawn` makes the estimation plot, whose intervals are those of the test; `quantile_level` is that of the band of
    normal quantiles; with `by_day` residuals are those of the model with days.
    """

    sentences: list[str]
    data: dict[str, Any]
    drawn: Callable[[], Estimation]
    notes: Sequence[str] = ()
    fields: list[str | Rows] = field(default_factory=list)
    quantile_level: float = 0.95
    by_day: bool = False

    def add_fields(self, title: str, result: Any) -> None:
        """Add all fields of a result under a title."""
        self.fields += ["", f"{title}:", *field_lines(result)]

    def add_fields_of_each(self, titled: Iterable[tuple[str, Any]]) -> None:
        """Add the fields of several results, with the meaning of each field once."""
        titles, results = zip(*titled, strict=True)
        for title, lines in zip(titles, field_lines_of_each(results), strict=True):
            self.fields += ["", f"{title}:", *lines]

    def add_table(self, title: str, results: Sequence[Any], left_out: Sequence[str] = ()) -> None:
        """Add results of one class as a table, and why fields of theirs are undefined."""
        if results:
            self.fields += ["", f"{title}:", table_of(results, left_out), *reasons_of(results, left_out)]


@dataclass(frozen=True, slots=True)
class CommandOutput:
    """Data for programs; sentences and notes for people, the fields behind them, and the files that were written."""

    data: dict[str, Any]
    lines: Sequence[str]
    fields: Sequence[str | Rows] = ()
    files: Sequence[str] = ()


def answer(
    source: DataSource,
    ask: Callable[[Question], Answer],
    *,
    alpha: float | None,
    level: float | None,
    pooled: bool,
    pictures: Mapping[str, Path],
    step: Callable[[str], None],
) -> CommandOutput:
    """Observe the values, ask, draw what is wanted; the level is given as alpha, or as that of intervals.

    `pictures` are files by what they show: an estimation "plot", normal quantiles ("qq") of the residuals, "residuals"
    against groups and days. Data have the values' unit and the groups' own names, as programs ask for them; what people
    read has lengths below 1 m in mm, and groups of a book named as in its report.
    """
    for name, path in pictures.items():
        check_form(f"--{name}", path)
    observed = observe(source, step)
    if pooled:
        observed = observed.pooled()
    question = Question(observed, source, _alpha_of(alpha, level, observed), pooled, step)
    found = ask(question)
    step("figures" if pictures else "tables")
    _draw(pictures, observed, found)
    shown = as_shown_to_people(observed.in_small_units())
    scale = 1.0 if shown.unit == observed.unit else 1000.0
    as_shown = found if shown is observed else ask(replace(question, observed=shown, scale=scale))
    notes = [*shown.notes, *as_shown.notes]
    known = observed.known()
    files = {name: str(path) for name, path in pictures.items()}
    data = {
        "source": observed.source,
        "quantity": observed.quantity,
        "unit": observed.unit,
        "by": observed.by,
        "control": question.control,
        "groups": {observed.name(label): len(known.values(label)) for label in observed.labels},
        "notes": [*observed.notes, *found.notes],
        **found.data,
        "files": files,
    }
    lines = [*as_shown.sentences, *([""] if notes else []), *(f"note: {note}" for note in notes)]
    return CommandOutput(data, lines, as_shown.fields, [*files.values()])


def _alpha_of(alpha: float | None, level: float | None, observed: Observations) -> float:
    """Return the level of tests: given as alpha, as the level of intervals, by the book, or 0.05.

    Raises `UsageError` where both are given and differ.
    """
    if level is not None:
        of_level = alpha_of_level(as_level("--level", level))
        if alpha is not None and alpha != of_level:
            raise UsageError(
                f"--alpha {alpha:g} and --level {level:g} differ: an interval has level 1 - alpha, give one."
            )
        return of_level
    if alpha is not None:
        if not 0.0 < alpha < 1.0:
            raise UsageError(f"--alpha is {alpha!r}: give a number between 0 and 1, for example 0.05 for 5 %.")
        return alpha
    return ALPHA if observed.settings is None else observed.settings.alpha


def _draw(pictures: Mapping[str, Path], observed: Observations, found: Answer) -> None:
    """Draw and write what is wanted."""
    if not pictures:
        return
    from reports.figures.estimation import draw_estimation
    from reports.figures.kind import write_figure
    from reports.figures.quantiles import draw_quantiles
    from reports.figures.residuals import draw_residuals
    from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN

    width_in = ONE_COLUMN_IN if len(observed.labels) <= 2 else TWO_COLUMNS_IN
    has_days = any(row.day for row in observed.rows)
    drawn = as_drawn(observed)
    residuals = functools.cache(lambda by_day: residuals_of(drawn, by_day=by_day))
    draw = {
        "plot": lambda: draw_estimation(found.drawn(), width_in),
        "qq": lambda: draw_quantiles(quantiles_of(drawn, residuals(found.by_day), found.quantile_level)),
        "residuals": lambda: draw_residuals(
            residual_plot_of(drawn, residuals(False)), TWO_COLUMNS_IN if has_days else width_in
        ),
    }
    for name, path in pictures.items():
        write_figure(draw[name](), path)
