"""The interval of a mean that carries a shared error."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.shared_error import SharedError, describe_shared, joined_half_width, shared_of_mean
from stats.compare.summary import describe
from stats.tails import t_quantile
from tests.helpers.wording import refuses

ERRORS = st.builds(
    lambda level, slope: SharedError({("drain", "level"): level, ("drain", "slope"): slope}, {"drain": 4.0}),
    st.floats(-10, 10),
    st.floats(-10, 10),
)


def level_error(se: float, df: float = math.inf) -> SharedError:
    return SharedError({("drain", "level"): se}, {"drain": df})


def test_none_is_the_plain_interval_and_one_stays_with_any_number_of_values() -> None:
    values = np.random.default_rng(5).normal(40, 1, 100_000)
    plain, none = describe(values[:4]), describe_shared(values[:4], SharedError())
    assert (none.ci_low, none.ci_high) == pytest.approx((plain.ci_low, plain.ci_high), rel=1e-14)
    few, many = (describe_shared(values[:n], level_error(0.5)) for n in (10, 100_000))
    width = [float(s.ci_high) - float(s.ci_low) for s in (few, many)]  # type: ignore[arg-type]
    assert width[1] == pytest.approx(2 * 1.959964 * 0.5, rel=1e-3)
    assert width[0] > width[1]
    flat = describe_shared([1.0, 1.0, 1.0], level_error(0.5))
    assert (flat.ci_low, flat.ci_high) == pytest.approx((1.0 - 0.98, 1.0 + 0.98), abs=1e-4)
    assert isinstance(describe_shared([40.0], level_error(0.5)).ci_low, Undefined)


@pytest.mark.soak
@pytest.mark.parametrize("shared_df", [1.0, 2.0, 4.0, 20.0])
def test_a_mean_covers_at_its_level_however_little_the_fit_knows(shared_df: float) -> None:
    rng = np.random.default_rng(11)
    rounds, shared_se, covered = 3000, 0.6, 0
    for _ in range(rounds):
        error, estimated = rng.normal(0, shared_se), shared_se * np.sqrt(rng.chisquare(shared_df) / shared_df)
        found = describe_shared(rng.normal(40, 1.5, 10) + error, level_error(float(estimated), shared_df))
        assert isinstance(found.ci_low, float)
        assert isinstance(found.ci_high, float)
        covered += found.ci_low <= 40.0 <= found.ci_high
    assert 0.935 <= covered / rounds <= 0.985


@pytest.mark.parametrize("own_df", [1.0, 3.0, 3.9, 4.0, 6.0, 50.0])
@pytest.mark.parametrize(("se", "df", "shared_se"), [(1.0, 8.0, 0.6), (0.4, 3.0, 1.5), (2.0, 1.0, 0.5)])
def test_half_widths_add_in_quadrature_or_from_4_df_have_one_quantile_after_welch_and_satterthwaite(
    own_df: float, se: float, df: float, shared_se: float
) -> None:
    """Where the scatter's own interval is the wider (the last case) it stands."""
    alone, total = scipy.stats.t.ppf(0.975, df) * se, se**2 + shared_se**2
    together_df = total**2 / (se**4 / df + shared_se**4 / own_df)
    together = scipy.stats.t.ppf(0.975, together_df) * math.sqrt(total)
    by_hand = math.hypot(alone, scipy.stats.t.ppf(0.975, own_df) * shared_se) if own_df < 4.0 else max(alone, together)
    assert joined_half_width(se, df, level_error(shared_se, own_df), 0.95) == pytest.approx(by_hand, rel=1e-12)


@given(st.floats(0.1, 5.0), st.sampled_from([1.0, 2.0, 3.0, 7.0, 40.0]), ERRORS, st.sampled_from([1.0, 3.0, 5.0, 30.0]))
def test_a_further_error_never_makes_an_interval_narrower(se: float, df: float, error: SharedError, own: float) -> None:
    half = joined_half_width(se, df, replace(error, df={"drain": own}), 0.95)
    assert half >= t_quantile(0.95, df) * se * (1 - 1e-12)


@given(st.lists(ERRORS, min_size=1, max_size=5), st.lists(ERRORS, min_size=1, max_size=5))
def test_means_and_differences_are_those_of_the_gradient(one: list[SharedError], two: list[SharedError]) -> None:
    """Against the variance of the linear combination, g' C g with C = 1."""
    terms = [("drain", "level"), ("drain", "slope")]
    gradient = np.mean([[e.terms[t] for t in terms] for e in one], axis=0)
    gradient -= np.mean([[e.terms[t] for t in terms] for e in two], axis=0)
    found = shared_of_mean(one).minus(shared_of_mean(two))
    assert found.se == pytest.approx(float(np.sqrt(gradient @ gradient)), rel=1e-9, abs=1e-7)


def test_what_is_alike_cancels_exactly_and_other_fits_do_not() -> None:
    third = shared_of_mean([level_error(0.1)] * 3)  # its mean differs from 0.1 in the last digit
    assert level_error(0.1).minus(third).se == 0.0
    other = SharedError({("another robot's drain", "level"): 0.4}, {"another robot's drain": 9.0})
    both = level_error(0.3, 4.0).minus(other)
    assert both.se == pytest.approx(0.5)
    assert both.degrees_of_freedom == pytest.approx(0.25**2 / (0.09**2 / 4 + 0.16**2 / 9))
    assert level_error(0.3, 4.0).degrees_of_freedom == pytest.approx(4.0)
    assert SharedError().degrees_of_freedom == math.inf


HALF = level_error(0.5, 4.0)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (lambda: level_error(math.nan), "no finite standard error"),
        (lambda: level_error(0.5, 0.0), "degrees of freedom"),
        (lambda: SharedError({("drain", "level"): 0.1}), "no degrees of freedom of drain"),
        (lambda: SharedError({}, {"drain": math.nan}), "the degrees of freedom of drain are nan"),
        (lambda: HALF.times(math.nan), "no finite standard error"),
        (lambda: HALF.minus(level_error(0.5, 3.0)), "drain has 4 degrees of freedom in one shared error and 3"),
        (lambda: shared_of_mean([HALF, level_error(0.5, 3.0)]), "two fits need two names"),
    ],
)
def test_foreign_numbers_are_refused_with_what_to_give(asked: Callable[[], object], said: str) -> None:
    with refuses(InputRefused, said):
        asked()
    assert HALF.minus(SharedError({("drain", "level"): 0.2}, {"drain": 4})).se == pytest.approx(0.3)
