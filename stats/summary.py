"""Mean, standard deviation, standard error and interval of one sample."""

from __future__ import annotations

import math
from dataclasses import dataclass

from numpy.typing import ArrayLike

from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_values
from stats.distributions import t_quantile
from stats.sums import common_shift, moments
from stats.wording import interval_text, number_text, with_unit


@dataclass(frozen=True, slots=True)
class Summary:
    """One sample in numbers, in the unit of its values."""

    n: int
    mean: float | Undefined
    sd: float | Undefined
    """Standard deviation with n - 1."""
    se: float | Undefined
    """Standard error of the mean."""
    ci_low: float | Undefined
    """Lower end of Student's interval for the mean."""
    ci_high: float | Undefined
    level: float
    """Level of the interval."""

    def sentence(self, name: str = "mean", unit: str = "") -> str:
        """Return the summary in words: mean, SD, interval, n."""
        if isinstance(self.mean, Undefined):
            return f"{name}: undefined, {self.mean.reason}."
        interval: tuple[float, float] | Undefined = Undefined("one value has no scatter")
        if not isinstance(self.ci_low, Undefined) and not isinstance(self.ci_high, Undefined):
            interval = (self.ci_low, self.ci_high)
        return (
            f"{name} {number_text(self.mean)}{with_unit(unit)} (SD {number_text(self.sd)}, "
            f"{interval_text(interval, self.level)}, n = {self.n})."
        )


def describe(values: ArrayLike, level: float = 0.95) -> Summary:
    """Describe one sample, shape (n,), of any unit; the interval is mean -/+ t(level, n - 1) * sd / sqrt(n).

    Raises `InputRefused` for NaN, infinite or non-numeric values.
    """
    sample = as_values("the sample", values)
    level = as_level("level", level)
    if sample.size == 0:
        none = Undefined("there is no value")
        return Summary(0, none, none, none, none, none, level)
    about = moments(sample, common_shift(sample))
    if about.n < 2:
        one = Undefined("a single value has no scatter; at least 2 are needed")
        return Summary(1, about.mean, one, one, one, one, level)
    sd = math.sqrt(about.variance)
    se = sd / math.sqrt(about.n)
    half = t_quantile(level, about.n - 1) * se
    return Summary(about.n, about.mean, sd, se, about.mean - half, about.mean + half, level)
