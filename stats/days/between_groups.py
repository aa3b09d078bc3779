"""What one group of conditions saves beyond another, each saving by the contrast of its own control and treatment."""

from __future__ import annotations

import math

from data_schema.vocabulary import Undefined
from stats.days.decision_result import Estimate, no_estimate
from stats.exact.tails import t_quantile, t_two_sided


def difference_of_savings(one: Estimate, other: Estimate) -> Estimate:
    """Return the first saving less the second, of different runs, in percentage points.

    The errors are added in quadrature, degrees of freedom by Welch and Satterthwaite. Errors in common with others,
    which would cancel in part, are added too: the interval is wide rather than narrow. Both savings have one level.
    """
    if isinstance(one.value, Undefined) or isinstance(other.value, Undefined):
        why = one.value if isinstance(one.value, Undefined) else other.value
        assert isinstance(why, Undefined)  # noqa: S101 - one of both is
        return no_estimate(why, one.level, why)
    value = one.value - other.value
    without = next((each.ci for each in (one, other) if isinstance(each.ci, Undefined)), None)
    if without is not None:
        return no_estimate(without, one.level, value)
    ses, dfs, shared = ([_known(x) for x in several] for several in _parts(one, other))
    se, shared_se = math.hypot(*ses), math.hypot(*shared)
    df = se**4 / sum(each**4 / of for each, of in zip(ses, dfs, strict=True))
    error = math.hypot(se, shared_se)
    half = t_quantile(one.level, df) * error
    test = t_two_sided(value / error, df)
    return Estimate(
        value, se, shared_se, (value - half, value + half), one.level, value / error, df, test.p, test.log10_p
    )


def _parts(one: Estimate, other: Estimate) -> tuple[tuple[float | Undefined, ...], ...]:
    return (one.se, other.se), (one.df, other.df), (one.shared_se, other.shared_se)


def _known(value: float | Undefined) -> float:
    assert isinstance(value, float | int)  # noqa: S101 - what has an interval has an error and degrees of freedom
    return float(value)
