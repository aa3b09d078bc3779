"""The same p, to 1e-13, whatever the unit (powers of two), the offset, the order, the labels and the type of values.

Every test function of the package is tried on whole numbers, moved and scaled only where no value is rounded.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from stats.compare.resampling import bootstrap_difference, permutation_test
from stats.days.blocked import blocked_by_day

from data_schema.vocabulary import Undefined
from stats.compare.equivalence import equivalence
from stats.compare.savings import percent_savings
from stats.compare.summary import autocorrelation
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.dunnett import dunnett
from stats.groups.residuals import rmse_over_iqr
from stats.groups.tukey import compare_all_pairs
from stats.groups.variances import bartlett, brown_forsythe, f_test, levene
from stats.lines.regression import fit_linear, fit_polynomial

Groups = tuple[Any, Any, Any]
Found = list[float | Undefined]
DAYS = [0, 1, 2, 3, 0, 1, 2, 3]


def named(groups: Groups, names: str) -> dict[str, Any]:
    return dict(zip(names, groups, strict=True))


def by_day(groups: Groups, names: str, *, uneven: bool) -> Found:
    """Three conditions over four days, twice each, or (uneven) the third on two days of its own as well."""
    days = [DAYS, DAYS, [0, 0, 4, 4, 5, 5, 5, 1] if uneven else DAYS]
    values = np.concatenate([np.asarray(group) for group in groups])
    labels = [name for name in names for _ in range(8)]
    found = blocked_by_day(values, labels, [f"{names}{day}" for each in days for day in each], control=names[0])
    exact = [] if isinstance(found.exact, Undefined) else [found.exact.p]
    contrasts = sorted(found.mixed.contrasts, key=lambda each: names.index(each.condition))
    return [found.mixed.f, found.mixed.df_within, found.mixed.p, *exact, *(each.p for each in contrasts)]


def pairs(groups: Groups, names: str, variances: str) -> Found:
    found = compare_all_pairs(named(groups, names), variances=variances).pairs
    return [pair.p for pair in sorted(found, key=lambda pair: tuple(sorted(map(names.index, (pair.a, pair.b)))))]


def two(groups: Groups, _names: str, _unit: float) -> Found:
    found = compare_two(groups[0], groups[1])
    return [found.p, found.welch_p, found.f_p, found.brown_forsythe_p, found.hedges_g]


def against_control(groups: Groups, names: str, _unit: float) -> Found:
    found = dunnett(groups[0], {names[1]: groups[1], names[2]: groups[2]}, control_name=names[0])
    return [each.p for each in found.comparisons]


def line(groups: Groups, _names: str, _unit: float) -> Found:
    if len(set(np.asarray(groups[1]).tolist())) < 2:
        return []
    found = fit_linear(groups[0], {"x": groups[1]})
    return [found.r_squared, found.f_p, found.p if isinstance(found.p, Undefined) else found.p[1]]


def parabola(groups: Groups, _names: str, _unit: float) -> Found:
    found = fit_polynomial(np.arange(8), groups[0], 2)
    return [found.r_squared, found.f_p, *(found.p[1:] if isinstance(found.p, tuple) else [found.p])]


def redrawn(groups: Groups, _names: str, unit: float) -> Found:
    found = bootstrap_difference(groups[0], groups[1], resamples=200)
    if isinstance(found.interval, Undefined):
        return [found.interval]
    return [(end - found.difference) / unit for end in (*found.interval, *found.percentile_interval)]


MOVABLE: dict[str, Callable[[Groups, str, float], Found]] = {
    "two": two,
    "f": lambda groups, _names, _unit: [f_test(groups[0], groups[1]).p],
    "bartlett": lambda groups, names, _unit: [bartlett(named(groups, names)).p],
    "levene": lambda groups, names, _unit: [levene(named(groups, names)).p],
    "brown-forsythe": lambda groups, names, _unit: [brown_forsythe(named(groups, names)).p],
    "anova": lambda groups, names, _unit: [one_way_anova(named(groups, names)).p],
    "welch anova": lambda groups, names, _unit: [welch_anova(named(groups, names)).p],
    "tukey": lambda groups, names, _unit: pairs(groups, names, "equal"),
    "games-howell": lambda groups, names, _unit: pairs(groups, names, "unequal"),
    "dunnett": against_control,
    "equivalence": lambda groups, _names, unit: [equivalence(groups[0], groups[1], low=-8.0 * unit, high=4.0 * unit).p],
    "by day": lambda groups, names, _unit: by_day(groups, names, uneven=False),
    "by day, uneven": lambda groups, names, _unit: by_day(groups, names, uneven=True),
    "permutation": lambda groups, _names, _unit: [permutation_test(groups[0][:5], groups[1][:5]).p],
    "permutation drawn": lambda groups, _names, _unit: [
        permutation_test(groups[0], groups[1], DAYS, DAYS, exact_limit=10, resamples=200).p
    ],
    "bootstrap": redrawn,
    "line": line,
    "parabola": parabola,
    "rmse": lambda groups, _names, _unit: [rmse_over_iqr(groups[0], groups[1]).ratio],
    "autocorrelation": lambda groups, _names, _unit: [autocorrelation(groups[0]).r],
}
"""What each function says of three groups of eight values, in numbers that no offset and no unit may change."""
FIXED: dict[str, Callable[[Groups, str, float], Found]] = {
    "equivalence in percent": lambda groups, _names, _unit: [
        equivalence(groups[0], groups[1], low=-5.0, high=4.0, bounds="percent").p
    ],
    "savings": lambda groups, _names, _unit: savings(groups),
}
"""The same for shares of a mean, which an offset changes."""
ROWS = (
    "line",
    "parabola",
    "rmse",
    "autocorrelation",
    "by day",
    "by day, uneven",
    "permutation",
    "permutation drawn",
)
"""Where a value's place says what it belongs to: their orders are changed by rows, elsewhere."""


def savings(groups: Groups) -> Found:
    found = percent_savings(groups[0], groups[1])
    return [found.percent, *(found.percent_ci if isinstance(found.percent_ci, tuple) else [found.percent_ci])]


GROUPS = st.tuples(*[st.lists(st.integers(1, 2**20), min_size=8, max_size=8)] * 3)


def assert_same(one: Found, other: Found) -> None:
    assert len(one) == len(other)
    for a, b in zip(one, other, strict=True):
        if isinstance(a, Undefined) or isinstance(b, Undefined):
            assert type(a) is type(b)
        else:
            assert b == pytest.approx(a, rel=1e-13, abs=1e-300)


@pytest.mark.parametrize("name", [*MOVABLE, *FIXED])
@given(GROUPS, st.integers(-560, 500), st.integers(-500, 500))
def test_a_unit_of_any_power_of_two_changes_nothing(name, groups, base, exponent):
    """Down to 2^-1060, where doubles have 14 bits left, and up to 2^1020; only where every value keeps all its bits."""
    assume(base + exponent < 1000)
    assume(name != "bootstrap" or min(base, base + exponent) > -900)  # its ends are values, not shares
    shortest = [[x >> max(0, -1072 - base - exponent) for x in group] for group in groups]
    one = tuple(np.ldexp(np.array(group, dtype=float), base) for group in shortest)
    other = tuple(np.ldexp(group, exponent) for group in one)
    assume(all((np.ldexp(b, -exponent) == a).all() for a, b in zip(one, other, strict=True)))
    of = {**MOVABLE, **FIXED}[name]
    assert_same(of(one, "abc", math.ldexp(1.0, base)), of(other, "abc", math.ldexp(1.0, base + exponent)))


@pytest.mark.parametrize("name", MOVABLE)
@given(GROUPS, st.integers(-(2**52), 2**52))
def test_an_exact_offset_changes_nothing(name, groups, shift):
    """Whole numbers stay whole numbers up to 2^53."""
    one = tuple(np.array(group, dtype=float) for group in groups)
    other = tuple(np.array([x + shift for x in group], dtype=float) for group in groups)
    assert_same(MOVABLE[name](one, "abc", 1.0), MOVABLE[name](other, "abc", 1.0))


@pytest.mark.parametrize("name", [*MOVABLE, *FIXED])
@given(GROUPS, st.permutations(range(8)), st.permutations("abc"))
def test_order_and_labels_change_nothing(name, groups, order, names):
    of = {**MOVABLE, **FIXED}[name]
    one = tuple(np.array(group, dtype=float) for group in groups)
    other = one if name in ROWS else tuple(group[list(order)] for group in one)
    assert_same(of(one, "abc", 1.0), of(other, "".join(names), 1.0))


TYPES: dict[str, Callable[[list[int]], Any]] = {
    "int64": lambda values: np.array(values),
    "uint32": lambda values: np.array(values, dtype=np.uint32),
    "float32": lambda values: np.array(values, dtype=np.float32),
    "list": list,
    "decimals": lambda values: [Decimal(value) for value in values],
    "fractions": lambda values: [Fraction(value) for value in values],
}


@pytest.mark.parametrize("name", [*MOVABLE, *FIXED])
@given(GROUPS)
def test_the_type_changes_nothing(name, groups):
    of = {**MOVABLE, **FIXED}[name]
    one = of(tuple(np.array(group, dtype=float) for group in groups), "abc", 1.0)
    for typed in TYPES.values():
        assert_same(one, of(tuple(typed(list(group)) for group in groups), "abc", 1.0))


@given(GROUPS, st.permutations(range(24)), st.integers(0, 2**32))
def test_the_order_of_rows_changes_nothing(groups, order, seed):
    values = np.concatenate([np.array(group, dtype=float) for group in groups])
    labels, days = np.repeat(list("abc"), 8), np.random.default_rng(seed).integers(0, 5, 24)
    rows = list(order)
    one, other = blocked_by_day(values, labels, days), blocked_by_day(values[rows], labels[rows], days[rows])
    assert_same([one.f, one.df_within, one.p], [other.f, other.df_within, other.p])
    x, z = np.arange(24.0) ** 2, values[::-1]
    assert_same(
        *([fit.f_p, fit.r_squared] for fit in (fit_linear(values, {"x": x}), fit_linear(values[rows], {"x": x[rows]})))
    )
    assert_same([rmse_over_iqr(values, z).ratio], [rmse_over_iqr(values[rows], z[rows]).ratio])
    a, b = rows[:12], rows[12:]
    for function in (permutation_test, bootstrap_difference):
        one, other = (
            function(values[c], values[d], days[c], days[d], resamples=100, seed=seed)
            for c, d in ((a, b), (sorted(a), sorted(b, reverse=True)))
        )
        assert one == other


@given(st.integers(0, 2**32), st.sampled_from([0.3, 1.0, 5.0, 300.0]), st.permutations("abcd"), st.booleans())
@example(813, 300.0, list("cbda"), True)
def test_the_order_of_conditions_changes_no_p_of_an_uneven_design(seed, day_sd, names, with_runs):
    """lmerTest's overall p changes with it; its numbers stand apart."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(14, 40))
    condition, day, run = rng.integers(0, 4, n), rng.integers(0, 5, n), rng.integers(0, 2, n)
    values = rng.normal(size=n) + 0.5 * condition + day_sd * rng.normal(size=5)[day]
    runs = run if with_runs else None
    one = blocked_by_day(values, np.array(list("abcd"))[condition], day, runs)
    other = blocked_by_day(values, np.array(names)[condition], [f"day {9 - each}" for each in day], runs)
    # Days 300 times as different as values leave comparisons between them 300 times as many last digits of rounding.
    rel = 1e-13 if day_sd <= 5.0 else 1e-11
    assert (other.df_within, other.p) == pytest.approx((one.df_within, one.p), rel=rel)


@pytest.mark.parametrize("name", [name for name in [*MOVABLE, *FIXED] if name not in ("permutation", "parabola")])
@pytest.mark.parametrize("exponent", [-1066, 990])
def test_samples_of_many_values_keep_their_digits_too(name, exponent):
    """Longer samples are summed by arrays of doubles, which must not be subnormal."""
    rng = np.random.default_rng(5)
    groups = tuple(rng.integers(1, 2**12, 400) for _ in range(3))
    of = {**MOVABLE, **FIXED}[name]
    power_of_unit = max(exponent, -900) if name == "bootstrap" else exponent
    if name.startswith(("by day", "permutation")):
        groups = tuple(group[:8] for group in groups)
    one, other = (tuple(np.ldexp(group.astype(float), power) for group in groups) for power in (0, power_of_unit))
    assert_same(of(one, "abc", 1.0), of(other, "abc", math.ldexp(1.0, power_of_unit)))
