"""The figures of `labbook stats`: estimation plot, normal quantiles, residuals, from values and the results on them.

Groups of a book are called as the report calls them, a gain by its physical value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.observations import Observations
from labbook.presenting.report.campaign import study_factor
from reports.content import Factor, Level
from reports.display import NO_BREAK, in_sentence
from reports.figures.estimation import Estimation, EstimationGroup
from reports.figures.quantiles import Quantiles
from reports.figures.residuals import Against, ResidualPlot
from reports.naming import level_name, swept_words, title_of
from reports.numbers import Number
from stats.groups.residuals import Residuals, normal_quantiles, residuals_of_groups

LONGEST = 48
"""Letters of a name that a figure has room for."""


def draw_pictures(
    pictures: Mapping[str, Path], observed: Observations, estimation: Callable[[], Estimation], level: float
) -> None:
    """Draw and write what is wanted: files by "plot", "qq" (normal quantiles) and "residuals"."""
    if not pictures:
        return
    from reports.figures.estimation import draw_estimation
    from reports.figures.kind import write_figure
    from reports.figures.quantiles import draw_quantiles
    from reports.figures.residuals import draw_residuals
    from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN

    width_in = ONE_COLUMN_IN if len(observed.labels) <= 2 else TWO_COLUMNS_IN
    has_days = any(row.day for row in observed.rows)
    ordered = in_groups(observed)
    residuals = residuals_of_groups({label: ordered.values(label) for label in ordered.labels})
    draw = {
        "plot": lambda: draw_estimation(estimation(), width_in),
        "qq": lambda: draw_quantiles(quantiles_of(ordered, residuals, level)),
        "residuals": lambda: draw_residuals(
            residual_plot_of(ordered, residuals), TWO_COLUMNS_IN if has_days else width_in
        ),
    }
    for name, path in pictures.items():
        write_figure(draw[name](), path)


def difference_number(
    value: float | Undefined, interval: tuple[float, float] | Undefined, level: float, unit: str
) -> Number:
    """Return a difference with its interval as figures take it."""
    low, high = (interval, interval) if isinstance(interval, Undefined) else interval
    return Number(value, unit, ci_low=low, ci_high=high, ci_level=level)


def estimation_of(
    observed: Observations,
    differences: Mapping[str, Number],
    bounds: Sequence[float] = (),
    difference: str = "",
    interval: str = "",
) -> Estimation:
    """Return an estimation plot of all groups; `differences` from the control by a group's label.

    `difference` begins what these are called, `interval` says which method their intervals are of.
    """
    known = observed.known()
    groups = tuple(
        EstimationGroup(
            drawn_name(observed, label),
            tuple(float(row.value) for row in known.rows if row.label == label and row.value is not None),
        )
        for label in observed.labels
    )
    return Estimation(
        quantity=_sentence_case(observed.quantity),
        unit=observed.unit,
        groups=groups,
        reference=0,
        differences=tuple(differences.get(label) for label in observed.labels),
        bounds=tuple(bounds),
        difference=f"{difference} {drawn_name(observed, observed.control)}" if difference else "",
        interval=interval,
    )


def in_groups(observed: Observations) -> Observations:
    """Return the known observations, group after group."""
    known = observed.known()
    place = {label: number for number, label in enumerate(known.labels)}
    return replace(known, rows=tuple(sorted(known.rows, key=lambda row: place[row.label])))


def quantiles_of(ordered: Observations, residuals: Residuals, level: float) -> Quantiles:
    """Return residuals of ordered observations beside normal quantiles, each with its group."""
    found = normal_quantiles(residuals, level)
    order = sorted(range(len(residuals.values)), key=residuals.values.__getitem__)
    names = {label: drawn_name(ordered, label) for label in ordered.labels}
    return Quantiles(
        _sentence_case(ordered.quantity),
        ordered.unit,
        found,
        tuple(names[ordered.rows[place].label] for place in order),
        tuple(names.values()),
    )


def residual_plot_of(ordered: Observations, residuals: Residuals) -> ResidualPlot:
    """Return residuals of ordered observations against groups, and against days where these are known."""
    rows = ordered.rows
    names = {label: drawn_name(ordered, label) for label in ordered.labels}
    against = [Against(_axis_name(ordered), tuple(names[row.label] for row in rows), means=False)]
    days = tuple(row.day for row in rows)
    if len(set(days)) > 1:
        against.append(Against("Day", days, order=tuple(sorted(set(days)))))
    return ResidualPlot(_sentence_case(ordered.quantity), ordered.unit, residuals.values, tuple(against))


def as_shown_to_people(observed: Observations) -> Observations:
    """Return a book's observations with their groups named as in the report; those of a table as they are.

    Where two levels would be shown alike, all keep the names that the book writes.
    """
    if observed.configuration is None:
        return observed
    shown = {label: drawn_name(observed, label, gain=True).replace(NO_BREAK, " ") for label in observed.labels}
    if len(set(shown.values())) < len(shown):
        return observed
    factor = _factor(observed)
    return replace(observed, shown=shown, shown_by="" if factor is None else in_sentence(title_of(factor)))


def _axis_name(observed: Observations) -> str:
    """Name what the groups are levels of, at an axis: a factor of the book by its title."""
    factor = _factor(observed)
    return _sentence_case(observed.by if factor is None else title_of(factor))


def _sentence_case(words: str) -> str:
    """Return words as they begin at an axis; names such as x and b_ad_gain stay as they are."""
    named = len(words) == 1 or "_" in words
    return words if named else f"{words[:1].upper()}{words[1:]}"


def drawn_name(observed: Observations, label: str, *, gain: bool = False) -> str:
    """Name a group: "CE", "d = 186 kg/s", "active damping", "small foot"; groups of a table as the table does.

    With `gain` a level that is one has it behind: "d = 186 kg/s (gain 50)".
    """
    configuration, factor = observed.configuration, _factor(observed)
    if configuration is None or factor is None:
        name = observed.name(label)
        return name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}\u2026"
    of_gain = configuration.gains.get(observed.by)
    if observed.by == pairing.swept_factor(configuration):
        if label == observed.rest:
            return factor.treatment or "the treatment"
        if label == factor.control:
            return swept_words(factor).control_level
    try:
        value = float(label)
    except ValueError:
        return observed.name(label) if label == observed.rest else level_name(factor, Level(observed.by, label))
    if of_gain is None:
        return level_name(factor, Level(observed.by, label, value, factor.unit))
    return level_name(factor, Level(observed.by, label, of_gain.physical(value), of_gain.unit, value), gain=gain)


def _factor(observed: Observations) -> Factor | None:
    """Return the factor that makes the groups as the report knows it, None where no factor of a book does."""
    configuration = observed.configuration
    if configuration is None or observed.by not in configuration.factors:
        return None
    return study_factor(configuration, observed.by)
