"""Estimation plots: every value of every group, and beside them the differences with their intervals.

Two groups are drawn as Gardner and Altman do (1986, "Confidence intervals rather than P values"): the difference has
an axis of its own at the right, whose zero lies at the mean of the reference. More groups are drawn as Cumming does
("Understanding the New Statistics", 2012): the differences lie in a panel below. So are two where the difference is in
another unit than the values, or where its interval is so wide that the values would be squashed.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from data_schema.vocabulary import Undefined
from reports.display import NO_BREAK, as_shown, level_text, shown_unit
from reports.figures.estimation_parts import (
    SD_AT,
    DrawnGroup,
    axis_values,
    draw_difference,
    draw_groups,
    has_interval,
    named_with_unit,
    part_text,
    put_above,
    set_limits,
    set_names,
)
from reports.figures.style import (
    BLACK,
    BLUE,
    GREY,
    TWO_COLUMNS_IN,
    VERMILLION,
    is_narrow,
    light_grid,
    new_figure,
    plain_ticks,
    publication_style,
)
from reports.numbers import Number
from stats.compare.summary import describe

_SQUASHED = 3.0
"""An interval so many times wider than the values' range gets a panel of its own."""

_LETTERS_BESIDE, _LETTERS_ABOVE, _LETTERS_BELOW = 34, 26, 20
"""Letters that fit into a line along the axis: beside values, of values with differences below them, of these."""
_SHORT = 13
"""Letters from which on a name can be broken."""


@dataclass(frozen=True, slots=True)
class EstimationGroup:
    """A group's values; `labels` names what each belongs to (its day), drawn with a mark for each of up to six."""

    name: str
    values: tuple[float, ...]
    labels: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Estimation:
    """Groups and their differences from one of them.

    Values are in `unit` ("J", "m"); `reference` is the place of the group that the others are compared with, and
    `differences` has one number a group, in `unit` or "%", None for the reference. `bounds` are differences that
    matter, in the unit of `differences`. `difference` names these where they are no plain differences ("Savings");
    `interval` says by which method their intervals are, which a line above the figure repeats.
    """

    quantity: str
    unit: str
    groups: tuple[EstimationGroup, ...]
    reference: int
    differences: tuple[Number | None, ...]
    bounds: tuple[float, ...] = ()
    difference: str = ""
    interval: str = ""


@dataclass(frozen=True, slots=True)
class _Drawn:
    """An estimation in the units that are shown."""

    groups: tuple[DrawnGroup, ...]
    reference: DrawnGroup
    differences: tuple[Number | None, ...]
    lone: Number | None
    """The first of the differences."""
    bounds: tuple[float, ...]
    quantity: str
    difference: str
    line: str
    """What stands above the figure."""


def draw_estimation(estimation: Estimation, width_in: float = TWO_COLUMNS_IN) -> Figure:
    """Draw all values, mean and SD of each group, and the differences with their intervals.

    Two groups are drawn side by side (Gardner and Altman 1986), more with the differences in a panel below (Cumming
    2012). `width_in` is the figure's width in inches. Returns a matplotlib figure that belongs to no window.

    >>> ce, ad = EstimationGroup("CE", (44.1, 42.8, 43.9)), EstimationGroup("AD", (38.0, 39.2, 37.5))
    >>> saved = Number(-5.37, "J", ci_low=-6.98, ci_high=-3.75)
    >>> figure = draw_estimation(Estimation("Energy of a jump", "J", (ce, ad), reference=0, differences=(None, saved)))
    >>> figure.savefig("energy.pdf")  # doctest: +SKIP
    """
    with publication_style():
        drawn = _drawn(estimation)
        if _fits_beside(drawn, estimation):
            return _gardner_altman(drawn, width_in)
        return _cumming(drawn, width_in)


def _drawn(estimation: Estimation) -> _Drawn:
    unit, factor = shown_unit(estimation.unit)
    groups = []
    for place, group in enumerate(estimation.groups):
        values = tuple(value * factor for value in group.values)
        about = describe(values)
        mean = about.mean if isinstance(about.mean, float) else None
        sd = about.sd if isinstance(about.sd, float) else None
        colour = VERMILLION if place == estimation.reference else BLUE
        groups.append(DrawnGroup(group.name, values, group.labels, mean, sd, colour))
    stored = next((number for number in estimation.differences if number is not None), None)
    lone = None if stored is None else as_shown(stored)
    of_bounds = 1.0 if stored is None else shown_unit(stored.unit)[1]
    reference = groups[estimation.reference]
    difference = _whole(estimation.difference, reference.name)
    difference = difference or _whole(f"Mean difference from {reference.name}", reference.name)
    return _Drawn(
        groups=tuple(groups),
        reference=reference,
        differences=tuple(None if number is None else as_shown(number) for number in estimation.differences),
        lone=lone,
        bounds=tuple(bound * of_bounds for bound in estimation.bounds),
        quantity=named_with_unit(estimation.quantity, unit),
        difference=difference if lone is None else named_with_unit(difference, lone.unit),
        line=_line(estimation, groups),
    )


def _whole(text: str, name: str) -> str:
    """Keep a short name in one line, with the word before it."""
    if len(name) >= _SHORT:
        return text
    return text.replace(f" {name}", f" {name}".replace(" ", NO_BREAK))


def _line(estimation: Estimation, groups: Sequence[DrawnGroup]) -> str:
    """Say what is drawn, where the method of the intervals is known or where not every value is."""
    parts = []
    if estimation.interval:
        with_mean = [group for group in groups if group.mean is not None]
        parts.append("Gapped line: mean and SD." if any(group.sd for group in with_mean) else "")
        parts.append("" if all(group.sd for group in with_mean) else "Short line: mean without an SD.")
        parts.append(f"Interval: {estimation.interval}." if any(map(has_interval, estimation.differences)) else "")
        parts.append("Dashed: bounds of equivalence." if estimation.bounds else "")
    parts.append(part_text(len(group.values) for group in estimation.groups))
    return " ".join(part for part in parts if part)


def _broken(text: str, letters: int) -> str:
    """Break a text into lines between words only, a unit staying with the word before it."""
    whole = text.replace(" (", f"{NO_BREAK}(")
    lines = textwrap.fill(whole, letters, break_long_words=False, break_on_hyphens=False)
    return lines.replace(NO_BREAK, " ")


def _heighten(figure: Figure, more_in: float) -> None:
    figure.set_figheight(figure.get_figheight() + more_in)


def _fits_beside(drawn: _Drawn, estimation: Estimation) -> bool:
    ends = axis_values(drawn.lone)
    same_unit = drawn.lone is not None and drawn.lone.unit == shown_unit(estimation.unit)[0]
    if len(drawn.groups) != 2 or not same_unit or not ends or drawn.reference.mean is None:
        return False
    values = [value for group in drawn.groups for value in group.values]
    return max(0.0, *ends) - min(0.0, *ends) <= _SQUASHED * (max(values) - min(values))


def _gardner_altman(drawn: _Drawn, width_in: float) -> Figure:
    number, zero = drawn.lone, drawn.reference.mean or 0.0
    order = sorted(drawn.groups, key=lambda group: group is not drawn.reference)
    figure = new_figure(width_in, 2.7 if is_narrow(width_in) else 3.3)
    put_above(figure, drawn.line, width_in)
    axes = figure.add_subplot()
    values = [value for group in order for value in group.values]
    set_limits(axes, values + [zero + end for end in (*axis_values(number), *drawn.bounds)])
    axes.set_xlim(-0.55, 2.5)
    third = f"difference\n({level_text(number)})" if number is not None and has_interval(number) else "difference"
    _heighten(figure, set_names(axes, order, [third], width_in))
    axes.set_ylabel(_broken(drawn.quantity, _LETTERS_BESIDE))
    for place, group in enumerate(order):
        if group.mean is not None and (group is drawn.reference or _is_of_means(number, group.mean - zero)):
            axes.plot([place + SD_AT, 2.5], [group.mean, group.mean], color=GREY, linewidth=0.6, zorder=1)
    right = axes.twinx()
    right.set_ylim(*(end - zero for end in axes.get_ylim()))
    right.yaxis.set_major_locator(plain_ticks())
    right.spines["right"].set_visible(True)
    right.set_ylabel(_broken(drawn.difference, _LETTERS_BESIDE))
    for bound in drawn.bounds:
        axes.plot([1.7, 2.5], [zero + bound, zero + bound], color=BLACK, linewidth=0.8, linestyle="--", zorder=2)
    if number is not None:
        draw_difference(axes, number, 2.0, zero)
    draw_groups(figure, axes, order)
    return figure


def _is_of_means(number: Number | None, difference: float) -> bool:
    """Tell whether a difference is that of both means, to which a line leads; within days it is another one."""
    if number is None or isinstance(number.value, Undefined):
        return True
    return math.isclose(number.value, difference, rel_tol=1e-6, abs_tol=1e-9)


def _cumming(drawn: _Drawn, width_in: float) -> Figure:
    figure = new_figure(width_in, 3.9 if is_narrow(width_in) else 4.4)
    put_above(figure, drawn.line, width_in)
    upper, lower = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (3, 2)})
    groups = drawn.groups
    set_limits(upper, [value for group in groups for value in group.values])
    upper.set_ylabel(_broken(drawn.quantity, _LETTERS_ABOVE))
    upper.tick_params(axis="x", length=0)
    set_limits(lower, [0.0, *drawn.bounds, *(end for number in drawn.differences for end in axis_values(number))])
    lower.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
    for bound in drawn.bounds:
        lower.axhline(bound, color=BLACK, linewidth=0.8, linestyle="--", zorder=2)
    difference = _broken(drawn.difference, _LETTERS_BELOW)
    shown = next((number for number in drawn.differences if number is not None and has_interval(number)), None)
    lower.set_ylabel(difference if shown is None else f"{difference}\n({level_text(shown)})")
    lower.set_xlim(-0.6, len(groups) - 0.4)
    _heighten(figure, set_names(lower, groups, (), width_in))
    for place, (group, number) in enumerate(zip(groups, drawn.differences, strict=True)):
        if number is not None:
            draw_difference(lower, number, float(place), 0.0)
        elif group is drawn.reference:
            lower.plot([place], [0.0], "o", color=GREY, markersize=3.0, zorder=3)
    for axes in (upper, lower):
        light_grid(axes)
    figure.align_ylabels()
    draw_groups(figure, upper, groups)
    return figure
