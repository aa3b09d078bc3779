"""The figures of `labbook stats`: estimation plot, normal quantiles, residuals, from values and the results on them.

At a large offset or a tiny scale an axis shows values less a number, or in powers of ten, exactly. Groups of a book are
called as the report calls them, a gain by its physical value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from fractions import Fraction

from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.observations import Observations
from labbook.analysis.results.result_cache import interval_ends
from labbook.presenting.report.campaign import study_factor
from reports.content import Factor, Level
from reports.display import NO_BREAK, in_sentence
from reports.figures.estimation import Estimation, EstimationGroup
from reports.figures.quantiles import Quantiles
from reports.figures.residuals import Against, ResidualPlot
from reports.naming import level_name, swept_words, title_of
from reports.numbers import Number
from stats.groups.residuals import Residuals, additive_residuals, normal_quantiles, residuals_of_groups

_LEAST_SPREAD = Fraction(1, 10**6)
"""A range that is less than so much of the largest value does not show on an axis that is labelled with values."""
_LONGEST = 30
"""Letters of a number that is written without a power of ten."""
_MOST_DIGITS = 2000
"""More than any double has, or a table's number of a usual length."""
_ORDINARY = 200
"""Powers of ten that doubles and axes take without loss."""


@dataclass(frozen=True, slots=True)
class Scale:
    """What is drawn is (value - `offset`) / 10 ** `power`; differences are divided only."""

    offset: Fraction = Fraction(0)
    power: int = 0

    def drawn(self, value: float | Decimal) -> float:
        """Return a value as it is drawn, rounded once."""
        if not self.offset and not self.power:
            return float(value)
        return float((Fraction(value) - self.offset) / Fraction(10) ** self.power)

    def difference(self, value: float) -> float:
        """Return a difference as it is drawn; an endless one stays so."""
        return float(Fraction(value) / Fraction(10) ** self.power) if math.isfinite(value) else value

    def quantity(self, name: str, unit: str) -> str:
        """Say what is subtracted."""
        if not self.offset:
            return name
        return f"{name} less {_exact_text(self.offset)}{'' if unit in ('', '1') else f' {unit}'}"

    def unit(self, unit: str) -> str:
        """Return the unit of what is drawn."""
        if not self.power:
            return unit
        return f"10^{self.power}{'' if unit in ('', '1') else f' {unit}'}"


def _scale_of(values: Sequence[float | Decimal]) -> Scale:
    """Choose how these are drawn: as they are, where their spread shows so."""
    if not values:
        return Scale()
    low, high = Fraction(min(values)), Fraction(max(values))
    largest, spread = max(abs(low), abs(high)), high - low
    offset = _round_below(low, spread) if 0 < spread < _LEAST_SPREAD * largest else Fraction(0)
    size = spread if offset else largest
    power = _power(size) if size else 0
    return Scale(offset, power if abs(power) > _ORDINARY else 0)


def _round_below(low: Fraction, spread: Fraction) -> Fraction:
    """Return the next number at or below `low` that has no digit beyond the first of the spread."""
    step = Fraction(10) ** (_power(spread) - 1)
    return low // step * step


def _exact_text(value: Fraction) -> str:
    """Write a number of finitely many decimals with all of them, or as a power of ten times a whole number."""
    with localcontext(prec=_MOST_DIGITS):
        exact = (Decimal(value.numerator) / value.denominator).normalize()
    text = f"{exact:f}"
    return text if len(text) <= _LONGEST else f"{exact:E}"


def _power(size: Fraction) -> int:
    """Return the power of ten of a positive number, give or take one."""
    return len(str(size.numerator)) - len(str(size.denominator))


def number_of(value: float | Undefined, interval: tuple[float, float] | Undefined, level: float, unit: str) -> Number:
    """Return a difference with its interval as figures take it."""
    low, high = interval_ends(interval)
    return Number(value, unit, ci_low=low, ci_high=high, ci_level=level)


def estimation_of(
    observed: Observations,
    differences: Mapping[str, Number],
    bounds: Sequence[float | Undefined] = (),
    difference: str = "",
    interval: str = "",
) -> Estimation:
    """Return an estimation plot of all groups; `differences` from the control by a group's label.

    `difference` begins what these are called, `interval` says which method their intervals are of.
    """
    known = observed.known()
    labels = observed.labels
    scale = _scale_of([row.value for row in known.rows if row.value is not None])
    numbers = {label: _scaled(number, observed.unit, scale) for label, number in differences.items()}
    same_unit = all(number.unit == observed.unit for number in differences.values())
    groups = tuple(
        EstimationGroup(
            drawn_name(observed, label),
            tuple(scale.drawn(row.value) for row in known.rows if row.label == label and row.value is not None),
            tuple(row.day for row in known.rows if row.label == label) if any(row.day for row in known.rows) else (),
        )
        for label in labels
    )
    return Estimation(
        quantity=scale.quantity(_sentence_case(observed.quantity), observed.unit),
        unit=scale.unit(observed.unit),
        groups=groups,
        reference=0,
        differences=tuple(numbers.get(label) for label in labels),
        bounds=tuple(
            scale.difference(bound) if same_unit else bound for bound in bounds if not isinstance(bound, Undefined)
        ),
        difference=f"{difference} {drawn_name(observed, observed.control)}" if difference else "",
        interval=interval,
    )


def _scaled(number: Number, unit: str, scale: Scale) -> Number:
    """Return a difference in the values' unit as it is drawn; one in percent stays."""
    if number.unit != unit:
        return number

    def drawn(value: float | Undefined | None) -> float | Undefined | None:
        return scale.difference(value) if isinstance(value, int | float) else value

    value = number.value if isinstance(number.value, Undefined) else scale.difference(number.value)
    return replace(
        number, value=value, unit=scale.unit(unit), ci_low=drawn(number.ci_low), ci_high=drawn(number.ci_high)
    )


def as_drawn(observed: Observations) -> Observations:
    """Return observations whose residuals an axis can show: values far from zero less an exact number, tiny and huge
    ones in powers of ten. Ordinary values stay as they are.
    """
    scale = _scale_of([row.value for row in observed.rows if row.value is not None])
    if scale == Scale():
        return observed
    rows = tuple(row if row.value is None else replace(row, value=scale.drawn(row.value)) for row in observed.rows)
    return replace(observed, rows=rows, unit=scale.unit(observed.unit))


def residuals_of(observed: Observations, *, by_day: bool = False) -> Residuals:
    """Return values less their group's mean, or less what group and day add up to; in the order of `in_groups`."""
    ordered = in_groups(observed)
    if by_day:
        values = [float(row.value) for row in ordered.rows if row.value is not None]
        return additive_residuals(values, [row.label for row in ordered.rows], [row.day for row in ordered.rows])
    return residuals_of_groups({label: ordered.values(label) for label in ordered.labels})


def in_groups(observed: Observations) -> Observations:
    """Return the known observations, group after group."""
    known = observed.known()
    place = {label: number for number, label in enumerate(known.labels)}
    return replace(known, rows=tuple(sorted(known.rows, key=lambda row: place[row.label])))


def quantiles_of(observed: Observations, residuals: Residuals, level: float) -> Quantiles:
    """Return residuals beside normal quantiles, each with its group."""
    found = normal_quantiles(residuals, level)
    order = sorted(range(len(residuals.values)), key=residuals.values.__getitem__)
    labels = [row.label for row in in_groups(observed).rows]
    names = {label: drawn_name(observed, label) for label in observed.labels}
    return Quantiles(
        _sentence_case(observed.quantity),
        observed.unit,
        found,
        tuple(names[labels[place]] for place in order),
        tuple(names.values()),
    )


def residual_plot_of(observed: Observations, residuals: Residuals) -> ResidualPlot:
    """Return residuals against groups, and against days where these are known."""
    rows = in_groups(observed).rows
    names = {label: drawn_name(observed, label) for label in observed.labels}
    against = [Against(_drawn_axis(observed), tuple(names[row.label] for row in rows), means=False)]
    days = tuple(row.day for row in rows)
    if len(set(days)) > 1:
        against.append(Against("Day", days, order=tuple(sorted(set(days)))))
    return ResidualPlot(_sentence_case(observed.quantity), observed.unit, residuals.values, tuple(against))


LONGEST = 48
"""Letters of a name that a figure has room for."""


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


def _drawn_axis(observed: Observations) -> str:
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
        return shorten_name(observed.name(label))
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


def shorten_name(name: str) -> str:
    """Return a name as a figure has room for it."""
    return name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}\u2026"


def _factor(observed: Observations) -> Factor | None:
    """Return the factor that makes the groups as the report knows it, None where no factor of a book does."""
    configuration = observed.configuration
    if configuration is None or observed.by not in configuration.factors:
        return None
    return study_factor(configuration, observed.by)
