"""How far predictions, or a second method, lie from what was measured of the same things.

Bias of predictions, with the day as the unit: with e the prediction for a run's condition less what was measured of the
run, the bias is the mean over days of each day's mean e. Runs of a day are not independent, whatever their levels, so
the scatter between days is its error. What all runs take from one calibration (`SharedError`), and what all predictions
take from the inputs that they assume, no number of days averages out. The parts are added in quadrature, with Welch and
Satterthwaite's effective degrees of freedom (JCGM 100:2008, G.4); assumed inputs count as known.

Limits of agreement: the mean difference of two methods, and between what most further differences will lie (Bland and
Altman 1986).

Root mean squares over the interquartile range of what was measured: the thesis has 0.63 for the cost estimated from
forces (3.2.2).

Cohen's kappa: how far two people who sort the same things agree beyond what chance makes of how often each gives each
answer (Cohen 1960).
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import fixed_text, interval_text, number_text
from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_values
from stats.compare.shared_error import SharedError, shared_of_mean
from stats.results import Result
from stats.scatter import Value, finite, scale_of
from stats.tails import satterthwaite_df, t_quantile, t_two_sided


@dataclass(frozen=True, slots=True)
class PredictedRun:
    """One run beside the prediction for its condition, in one unit."""

    day: str
    measured: float
    shared: SharedError
    """What its error has in common with other runs."""
    predicted: float
    predicted_se: float
    """Standard uncertainty of the prediction, from inputs that all predictions assume alike."""


@dataclass(frozen=True, slots=True)
class Interval:
    """A standard error with its degrees of freedom, and the interval of the bias that they give."""

    se: float
    df: float
    ci: tuple[float, float]
    p: float
    """Two-sided p of no bias."""


@dataclass(frozen=True, slots=True)
class Bias:
    """Predicted less measured, in the unit of the runs."""

    bias: float
    measured: float
    """Mean over days of what was measured."""
    predicted: float
    """The same of the predictions."""
    days: int
    n: int
    """Runs."""
    in_all: Interval | Undefined
    """With the errors of what was measured and of what was assumed."""
    of_measured: Interval | Undefined
    """As if predictions had no error."""


def bias_by_day(runs: Sequence[PredictedRun], level: float = 0.95) -> Bias:
    """Return the bias of the predictions of some runs; without a second day it has no interval.

    Raises `InputRefused` where there is no run, or a number is not finite or an error negative.
    """
    level = as_level("level", level)
    if not runs:
        raise InputRefused("without runs predictions have no bias: give each run's value and its prediction.")
    for run in runs:
        numbers = (run.measured, run.predicted, run.predicted_se)
        if not all(map(math.isfinite, numbers)) or run.predicted_se < 0.0:
            raise InputRefused(f"{run} cannot be compared: give finite numbers, and an error of at least 0.")
    by_day: dict[str, list[PredictedRun]] = {}
    for run in runs:
        by_day.setdefault(run.day, []).append(run)
    measured = [statistics.fmean(run.measured for run in of_day) for of_day in by_day.values()]
    predicted = [statistics.fmean(run.predicted for run in of_day) for of_day in by_day.values()]
    biases = [one - other for one, other in zip(predicted, measured, strict=True)]
    bias, days = statistics.fmean(biases), len(by_day)
    in_all: Interval | Undefined = Undefined(Reason.ONE_DAY)
    of_measured = in_all
    if days > 1:
        shared = shared_of_mean([run.shared for run in runs])
        own = (statistics.variance(biases) / days, days - 1.0)
        common = (shared.se**2, shared.degrees_of_freedom)
        assumed = (statistics.fmean(run.predicted_se for run in runs) ** 2, math.inf)
        in_all = _interval(bias, [own, common, assumed], level)
        of_measured = _interval(bias, [own, common], level)
    return Bias(bias, statistics.fmean(measured), statistics.fmean(predicted), days, len(runs), in_all, of_measured)


def _interval(bias: float, parts: Sequence[tuple[float, float]], level: float) -> Interval | Undefined:
    """Return the interval from variances with their degrees of freedom; undefined where nothing scatters."""
    se = math.sqrt(math.fsum(variance for variance, _df in parts))
    if se == 0.0:
        return Undefined(Reason.BOTH_EXACT)
    df = satterthwaite_df(parts)
    half_width = t_quantile(level, df) * se
    return Interval(se, df, (bias - half_width, bias + half_width), t_two_sided(bias / se, df))


def joint_p(ps: Sequence[Value]) -> Value:
    """Return the p of no bias in any group that has a p: Bonferroni's, which holds however groups depend.

    Groups share days, a calibration and assumed inputs, whose correlations few days cannot estimate. Undefined where no
    group has a p.
    """
    known = [p for p in ps if not isinstance(p, Undefined)]
    return min(1.0, len(known) * min(known)) if known else next(iter(ps), Undefined(Reason.MEASURED_WITHOUT_INTERVAL))


FEWEST_DIFFERENCES = 3
"""With fewer, their scatter says nothing about the next one."""


@dataclass(frozen=True, slots=True)
class LimitsOfAgreement:
    """In the unit of the differences: their mean, and the limits between which 95 % of further ones are expected.

    Each has its standard error and a Student interval with n - 1 degrees of freedom at `level`.
    """

    mean: float
    se: float
    ci: tuple[float, float]
    low: float
    low_ci: tuple[float, float]
    high: float
    high_ci: tuple[float, float]
    limit_se: float
    n: int
    level: float


def limits_of_agreement(differences: Sequence[float], level: float = 0.95) -> LimitsOfAgreement:
    """Return the mean difference and the limits of agreement.

    Parameters
    ----------
    differences : (n,) one method less the other, of n things, each counted once
    level : of the intervals, and the share that the limits should hold

    Raises
    ------
    InputRefused
        With fewer than three differences, or one that is not finite.

    Source: Bland and Altman (1986), The Lancet 327, 307; the standard error of a limit as there.

    >>> found = limits_of_agreement([1.0, 2.0, 3.0])
    >>> f"{found.mean:.2f}, {found.low:.2f} to {found.high:.2f}"
    '2.00, 0.04 to 3.96'
    """
    values, level = np.asarray(differences, np.float64), as_level("level", level)
    n = values.size
    if n < FEWEST_DIFFERENCES or not np.isfinite(values).all():
        raise InputRefused(
            f"limits of agreement need at least {FEWEST_DIFFERENCES} finite differences: {n} were given."
        )
    sd, z = float(values.std(ddof=1)), NormalDist().inv_cdf(0.5 + level / 2.0)
    t = t_quantile(level, n - 1)
    mean, se = float(values.mean()), sd / math.sqrt(n)
    limit_se = sd * math.sqrt(1.0 / n + z**2 / (2.0 * (n - 1)))

    def interval(value: float, error: float) -> tuple[float, float]:
        return value - t * error, value + t * error

    low, high = mean - z * sd, mean + z * sd
    return LimitsOfAgreement(
        mean, se, interval(mean, se), low, interval(low, limit_se), high, interval(high, limit_se), limit_se, n, level
    )


@dataclass(frozen=True, slots=True)
class Kappa(Result):
    """How two people agree who gave each of n things one of several answers; shares are of 1."""

    n: int
    """Things that both answered."""
    answers: tuple[str, ...]
    """The answers that were given, in order of the alphabet; shape (k,)."""
    counts: tuple[tuple[int, ...], ...]
    """How often the first gave the answer of the row, the second that of the column; shape (k, k)."""
    agreed: Value
    """Share of the things on which both gave the same answer."""
    expected: Value
    """That share by chance, each giving each answer as often as they did."""
    kappa: Value
    """What agreement exceeds chance by, of what it could: 1 is agreement on all, 0 what chance gives."""
    se: Value
    """Its standard error in large samples."""
    ci: tuple[float, float] | Undefined
    """Its normal interval, within -1 and 1."""
    level: float
    """Level of the interval."""

    def sentence(self, names: tuple[str, str] = ("the first", "the second"), unit: str = "value") -> str:
        """Return the agreement in words: kappa, interval, shares, n."""
        who = f"{names[0]} and {names[1]}"
        if isinstance(self.agreed, Undefined) or isinstance(self.expected, Undefined):
            return f"{who} share no {unit}: no agreement (n = {self.n})."
        shares = (
            f"{who} agree on {fixed_text(100.0 * self.agreed, 1)} % of {self.n} {unit}s, where chance would give "
            f"{fixed_text(100.0 * self.expected, 1)} %"
        )
        if isinstance(self.kappa, Undefined):
            return f"{shares}; kappa does not exist, because {self.kappa.reason} (n = {self.n})."
        if isinstance(self.se, Undefined):
            none = f"no interval, because {self.se.reason}"
            return f"{shares}: Cohen's kappa {number_text(self.kappa)} ({none}, n = {self.n})."
        interval = interval_text(self.ci, self.level, "", self.se)
        return f"{shares}: Cohen's kappa {number_text(self.kappa, error=self.se)} ({interval}, n = {self.n})."


def cohen_kappa(first: Sequence[str], second: Sequence[str], level: float = 0.95) -> Kappa:
    """Return how two people agree on the same things.

    Parameters
    ----------
    first, second : (n,) the answer of each to the same n things, in one order
    level : of the interval, which is normal and for large n; it does not exist where its error is 0

    Raises
    ------
    InputRefused
        Where one gave more answers than the other.

    Source: Cohen (1960), Educational and Psychological Measurement 20, 37; the error by Fleiss, Cohen and Everitt
    (1969), Psychological Bulletin 72, 323.

    >>> found = cohen_kappa(["yes", "yes", "no", "no"], ["yes", "no", "no", "no"])
    >>> found.agreed, found.kappa
    (0.75, 0.5)
    """
    level, n = as_level("level", level), len(first)
    if n != len(second):
        raise InputRefused(f"{n} answers of one and {len(second)} of the other: give both people's to the same things.")
    answers = tuple(sorted({*first, *second}))
    place = {answer: at for at, answer in enumerate(answers)}
    table = np.zeros((len(answers), len(answers)))
    for one, other in zip(first, second, strict=True):
        table[place[one], place[other]] += 1.0
    about = n, answers, tuple(tuple(int(count) for count in row) for row in table.tolist())
    if n == 0:
        none = Undefined(Reason.NO_VALUE)
        return Kappa(*about, none, none, none, none, none, level)
    shares = table / n
    rows, columns = shares.sum(axis=1), shares.sum(axis=0)
    agreed, expected = float(np.trace(shares)), float(rows @ columns)
    if len(answers) == 1:
        only = Undefined(Reason.ONE_ANSWER, answer=answers[0])
        return Kappa(*about, agreed, 1.0, only, only, only, level)
    kappa = (agreed - expected) / (1.0 - expected)
    same = float(np.diag(shares) @ (1.0 - (rows + columns) * (1.0 - kappa)) ** 2)
    apart = (1.0 - kappa) ** 2 * (shares * (columns[:, np.newaxis] + rows) ** 2)
    off = float(apart.sum() - np.trace(apart))
    variance = (same + off - (kappa - expected * (1.0 - kappa)) ** 2) / ((1.0 - expected) ** 2 * n)
    if variance <= _NO_VARIANCE:
        exact = Undefined(Reason.KAPPA_EXACT)
        return Kappa(*about, agreed, expected, kappa, exact, exact, level)
    se = math.sqrt(variance)
    half_width = t_quantile(level, math.inf) * se
    ci = (max(-1.0, kappa - half_width), min(1.0, kappa + half_width))
    return Kappa(*about, agreed, expected, kappa, se, ci, level)


_NO_VARIANCE = 1e-14
"""A variance below is 0 but for rounding."""


@dataclass(frozen=True, slots=True)
class RmseOverIqr(Result):
    """Error of a prediction in interquartile ranges of what was measured."""

    ratio: Value
    """`rmse` over `iqr`, dimensionless."""
    rmse: Value
    """Root of the mean squared difference, predicted minus measured, in the unit of the values."""
    iqr: Value
    """Upper minus lower quartile of the measured values, in their unit."""
    n: int
    """Number of pairs."""


def rmse_over_iqr(measured: ArrayLike, predicted: ArrayLike) -> RmseOverIqr:
    """Compare predictions with measurements, both of shape (n,), in one unit; quartiles are numpy's default.

    Raises `InputRefused` for no values, missing or infinite ones, or lengths that differ.
    """
    truth, guess = as_values("the measured values", measured), as_values("the predicted values", predicted)
    n = truth.size
    if n != guess.size or not n:
        raise InputRefused(
            f"there are {n} measured and {guess.size} predicted values: give one prediction for each "
            "measurement, and at least one."
        )
    scale = scale_of(truth, guess)
    measured_scaled, away = scale.scaled(truth), scale.scaled(guess) - scale.scaled(truth)
    rmse = math.sqrt(float(away @ away) / n)
    low, high = np.percentile(measured_scaled, (25.0, 75.0)).tolist()
    iqr = high - low
    return RmseOverIqr(
        ratio=finite(rmse / iqr, "the ratio") if iqr > 0.0 else Undefined(Reason.NO_QUARTILE_RANGE),
        rmse=scale.length(rmse, "the root mean square error"),
        iqr=scale.length(iqr, "the interquartile range"),
        n=n,
    )
