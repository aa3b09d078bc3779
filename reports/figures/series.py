"""Conditions as lines of a plot: one series a combination of the factors that are not swept."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal, TypeAlias

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from reports.display import given_text, sentence_start
from reports.figures.style import SERIES_COLOURS
from reports.naming import group_name, is_number, level_value, swept_factor, swept_words, title_of
from reports.results import Condition, Factor, StudyResults

LineStyle: TypeAlias = Literal["-", "--", ":", "-."]
"""How a series' line is broken."""

_LINE_STYLES: tuple[LineStyle, ...] = ("-", "--", ":", "-.")
_APART = 4.0
_SMALLEST_MARKER_PT, _LARGEST_MARKER_PT = 4.0, 7.5


@dataclass(frozen=True, slots=True)
class Series:
    """One line: first factor -> marker size and hue, second -> line style, shade and filled or open markers."""

    label: str
    colour: str
    line_style: LineStyle
    marker_pt: float
    filled: bool
    conditions: tuple[Condition, ...]


@dataclass(frozen=True, slots=True)
class Axis:
    """The x axis: where each level of the swept factor stands and how its tick reads."""

    title: str
    ticks: tuple[float, ...]
    labels: tuple[str, ...]
    gains: tuple[str, ...]
    continuous: bool
    positions: dict[str, float]
    control_position: float
    factor: Factor | None = None

    @property
    def step(self) -> float:
        """Return the smallest distance between two ticks; 1 where there is one tick."""
        return min((after - before for before, after in itertools.pairwise(self.ticks)), default=1.0)

    def position(self, condition: Condition) -> float:
        """Return where the condition stands on this axis."""
        if self.factor is None or (condition.control and self.factor.swept):
            return self.control_position
        level = condition.level(self.factor.name)
        return self.positions[level.label] if level is not None else self.control_position


def _levels(results: StudyResults, factor: Factor) -> list[str]:
    """Return a factor's labels, by physical value where they have one, else in the order they appear."""
    found = [level for condition in results.conditions if (level := condition.level(factor.name)) is not None]
    if all(level.value is not None for level in found):
        found.sort(key=lambda level: level.value or 0.0)
    return list(dict.fromkeys(level.label for level in found))


def drawn_factor(results: StudyResults) -> Factor | None:
    """Return the factor of the x axis: the swept one, else that of most levels; None where there is none."""
    known = [factor for factor in results.factors if _levels(results, factor)]
    return swept_factor(results) or max(known, key=lambda factor: _suits_an_axis(results, factor), default=None)


def _suits_an_axis(results: StudyResults, factor: Factor) -> tuple[int, bool]:
    """Rank a factor for the x axis: by the number of its levels, and of two alike the one whose levels are numbers."""
    found = [level for condition in results.conditions if (level := condition.level(factor.name)) is not None]
    return len(_levels(results, factor)), all(level.gain is not None or is_number(level) for level in found)


def series_of(results: StudyResults) -> tuple[Series, ...]:
    """Return the series in the order of their first conditions."""
    drawn = drawn_factor(results)
    factors = [factor for factor in results.factors if factor != drawn]
    order = {factor.name: _levels(results, factor) for factor in factors}
    keys = [tuple(one.labels.get(factor.name, "") for factor in factors) for one in results.conditions]
    found = []
    for number, (key, conditions) in enumerate(grouped(results.conditions, keys).items()):
        ranks = [
            order[factor.name].index(label) if label in order[factor.name] else 0
            for factor, label in zip(factors, key, strict=True)
        ]
        sizes = [len(order[factor.name]) for factor in factors]
        hue, shade = 0, 0
        if len(ranks) == 1:
            hue = ranks[0]
        elif len(ranks) == 2:
            hue, shade = ranks[0], sizes[1] - 1 - ranks[1]  # the stiffest is dark, solid and filled
        elif ranks:
            hue, shade = divmod(number, 2)  # more factors than styles: by turns, so that no two lines look the same
        share = ranks[0] / (sizes[0] - 1) if ranks and sizes[0] > 1 else 0.5
        found.append(
            Series(
                label=group_name(results, conditions[0], gain=True, axis=drawn) or "all runs",
                colour=SERIES_COLOURS[hue % len(SERIES_COLOURS)][shade % 2],
                line_style=_LINE_STYLES[shade % len(_LINE_STYLES)],
                marker_pt=_SMALLEST_MARKER_PT + share * (_LARGEST_MARKER_PT - _SMALLEST_MARKER_PT),
                filled=shade == 0,
                conditions=tuple(conditions),
            )
        )
    return tuple(found)


def series_lie_apart(results: StudyResults, quantity: Outcome) -> bool:
    """Whether the series lie so much further apart than each spreads that one scale would hide what is in them.

    Without a control no difference inside a series is looked for, and one scale shows the series beside each other.
    """
    if swept_factor(results) is None:
        return False
    ranges = []
    for series in series_of(results):
        summaries = [summary for c in series.conditions if (summary := c.summary(quantity)) is not None]
        values = [value for summary in summaries for _run, value in summary.runs]
        values += [summary.mean.known for summary in summaries if summary.mean.known is not None]
        if values:
            ranges.append((min(values), max(values)))
    if len(ranges) < 2:
        return False
    whole = max(high for _, high in ranges) - min(low for low, _ in ranges)
    return whole > _APART * max(high - low for low, high in ranges) > 0.0


def axis_of(results: StudyResults) -> Axis:
    """Lay out the levels of the x axis: at their physical values where all have one, else evenly spaced."""
    drawn = drawn_factor(results)
    if drawn is None:
        return Axis("", (0.0,), ("all conditions",), (), False, {}, 0.0)
    found = [(c, level) for c in results.conditions if (level := c.level(drawn.name)) is not None]
    levels = {level.label: level for c, level in found if not (c.control and drawn.swept)}
    controls = [level for c, level in found if c.control and drawn.swept]
    continuous = all(level.gain is not None or is_number(level) for level in levels.values())
    if continuous:
        positions = {label: float(level.value or 0.0) for label, level in levels.items()}
    else:
        positions = {
            label: 1.0 + index for index, label in enumerate(n for n in _levels(results, drawn) if n in levels)
        }
    labels = {at: level_value(levels[label]) if continuous else label for label, at in positions.items()}
    gains = {at: given_text(gain) for label, at in positions.items() if (gain := levels[label].gain) is not None}
    # A gain's control stands for 0, that of a plain number for itself.
    control_at = float(controls[0].value or 0.0) if continuous and controls and is_number(controls[0]) else 0.0
    if controls or any(condition.control for condition in results.conditions if drawn.swept):
        labels = {control_at: swept_words(drawn).control_level, **labels}
        gains = {control_at: "0", **gains} if gains else {}
    title = sentence_start(title_of(drawn)) + (f" {drawn.symbol}" if drawn.symbol else "")
    ticks = tuple(sorted(labels))
    return Axis(
        title=f"{title} ({drawn.unit})" if drawn.unit and continuous else title,
        ticks=ticks,
        labels=tuple(labels[tick] for tick in ticks),
        gains=tuple(gains[tick] for tick in ticks) if len(gains) == len(ticks) else (),
        continuous=continuous,
        positions=positions,
        control_position=control_at,
        factor=drawn,
    )
