"""Mean, standard deviation, standard error and interval of one sample."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from numpy.typing import ArrayLike

from data_schema.rounding import error_of, interval_text, number_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level, as_sample
from stats.exact.distributions import t_quantile
from stats.exact.error_free import exact_root
from stats.exact.finite import as_interval, finite
from stats.exact.sums import moments
from stats.results import Result
from stats.wording import missing_text, with_unit

_NO_SCATTER = Undefined("the values do not scatter")


@dataclass(frozen=True, slots=True)
class Summary(Result):
    """One sample in numbers, in the unit of its values."""

    n: int
    """Number of values."""
    mean: float | Undefined
    """Arithmetic mean, in the unit of the values."""
    sd: float | Undefined
    """Standard deviation with n - 1, in the unit of the values."""
    se: float | Undefined
    """Standard error of the mean, in the unit of the values."""
    ci_low: float | Undefined
    """Lower end of Student's interval for the mean, in the unit of the values."""
    ci_high: float | Undefined
    """Its upper end, in the unit of the values."""
    level: float
    """Level of the interval."""
    missing: int = 0
    """Values left out because they were NaN."""

    def sentence(self, name: str = "mean", unit: str = "") -> str:
        """Return the summary in words: mean, SD, interval, n."""
        if isinstance(self.mean, Undefined):
            return f"{name}: undefined, {self.mean.reason} (n = {self.n}{missing_text(self.missing)})."
        interval = as_interval(self.ci_low, self.ci_high)
        mean = number_text(self.mean, error=error_of(interval))
        return (
            f"{name} {mean}{with_unit(unit)} (SD {number_text(self.sd)}, "
            f"{interval_text(interval, self.level)}, n = {self.n}{missing_text(self.missing)})."
        )


def describe(values: ArrayLike, level: float = 0.95, missing: Missing = "refuse") -> Summary:
    """Describe one sample, shape (n,), of any unit; the interval is mean -/+ t(level, n - 1) * sd / sqrt(n).

    It is undefined where all values are equal: that they scatter by nothing is not what they show.
    Raises `InputRefused` for infinite or non-numeric values, and for NaN unless `missing` is "drop".
    """
    sample = as_sample("the sample", values, missing)
    level = as_level("level", level)
    n = sample.values.size
    if n == 0:
        none = Undefined("there is no value")
        return Summary(0, none, none, none, none, none, level, sample.missing)
    about = moments(sample.values, rest=sample.rest)
    if n < 2:
        one = Undefined("a single value has no scatter; at least 2 are needed")
        return Summary(1, about.mean, one, one, one, one, level, sample.missing)
    sd, se = exact_root(about.exact_variance), exact_root(about.exact_variance / n)
    half = Fraction(t_quantile(level, n - 1)) * se
    ends = about.exact_mean - half, about.exact_mean + half
    low, high = (finite(end, "an end of the interval") if se else _NO_SCATTER for end in ends)
    return Summary(
        n,
        about.mean,
        finite(sd, "the standard deviation"),
        finite(se, "the standard error"),
        low,
        high,
        level,
        sample.missing,
    )
