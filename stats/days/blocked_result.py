"""What a comparison of conditions over several days says: means, differences, variances, tests, and its limits."""

from __future__ import annotations

from dataclasses import dataclass

from data_schema.reasons import Reason
from data_schema.rounding import alpha_of_level, error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Remark, Undefined
from stats.exact.tails import Tail, f_upper
from stats.results import Result, missing_text, with_unit

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class ConditionMean(Result):
    """A condition as the model estimates it, in the unit of the values."""

    condition: str
    """Its label."""
    n: int
    """Number of values."""
    n_days: int
    """Number of days it was measured on."""
    estimate: float | Undefined
    """Generalised least-squares mean, for an average day, in the unit of the values."""
    se: float | Undefined
    """Standard error, for days drawn at random, in the unit of the values."""
    df: float | Undefined
    """Degrees of freedom after Satterthwaite (1946)."""
    interval: Interval | Undefined
    """Student's interval of the estimate."""


@dataclass(frozen=True, slots=True)
class Contrast(Result):
    """A condition minus the control, in the unit of the values."""

    condition: str
    """Label of the condition."""
    control: str
    """Label of the condition that it is compared with."""
    difference: float | Undefined
    """Condition minus control, in the unit of the values."""
    se: float | Undefined
    """Standard error of the difference, in the unit of the values."""
    df: float | Undefined
    """Degrees of freedom after Satterthwaite (1946), or those of the exact test."""
    t: float | Undefined
    """Difference over its standard error."""
    p: float | Undefined
    """Two-sided, for this comparison alone."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right at any size."""
    interval: Interval | Undefined
    """Student's interval of the difference."""

    def sentence(self, level: float, unit: str = "") -> str:
        """Return the difference in words, with its interval of that level and its test, or why there is none."""
        text = (
            f"{self.condition} minus {self.control} is "
            f"{number_text(self.difference, error=error_of(self.interval))}{with_unit(unit)} "
            f"({interval_text(self.interval, level, unit)})"
        )
        if isinstance(self.t, Undefined):
            return f"{text}; no test, because {self.t.reason}."
        p = p_text(self.p, alpha_of_level(level))
        return f"{text}, {statistic_text('t', self.t, (self.df,))}, {p}."


def exact_method(unit: str, block: str) -> str:
    """Name an exact test by what it counts and what it holds fixed, as `ExactTest` has them."""
    held = "" if block == "nothing" else f", {block} held fixed"
    return f"exact test on {unit}s{held}"


@dataclass(frozen=True, slots=True)
class ExactTest(Result):
    """Analysis of variance whose size is exact for normal values, whatever the days' variance, where all conditions
    scatter alike; where the one of fewer values scatters more it errs too often (see `BlockedByDay.paired`)."""

    unit: str
    """What is counted as one observation: "value", "run mean" or "day mean"."""
    block: str
    """What is held fixed: "day", "run" or "nothing"."""
    balanced: bool
    """Whether every block holds every condition equally often; the mixed model then has the same F, unless its days'
    variance is estimated as 0 and days are pooled with values."""
    f: float
    """Mean square between the conditions over that of the scatter, dimensionless."""
    df_between: int
    """Number of conditions minus 1."""
    df_within: int
    """Degrees of freedom of the scatter."""
    p: float
    """P(F >= f)."""
    log10_p: float
    """Decimal logarithm of p, right at any size."""
    contrasts: tuple[Contrast, ...]
    """Differences to the control from the same mean square; shape (k - 1,)."""

    @property
    def method(self) -> str:
        """The test in words: "exact test on values, day held fixed", "exact test on day means"."""
        return exact_method(self.unit, self.block)


MIXED_MODEL = "mixed model"


@dataclass(frozen=True, slots=True)
class MixedModel(Result):
    """Tests of y ~ condition + (1 | day) [+ (1 | day:run)], fitted by REML: all conditions scatter alike about days."""

    f: float | Undefined
    """F of all conditions being equal, dimensionless."""
    df_between: int
    """Number of conditions minus 1."""
    df_within: float | Undefined
    """Denominator's degrees of freedom after Satterthwaite; where several differ, joined as Fai and Cornelius do over
    the uncorrelated contrasts of an orthonormal basis, which knows no order of the conditions."""
    p: float | Undefined
    """P(F >= f)."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right at any size."""
    contrasts: tuple[Contrast, ...]
    """Every other condition minus the control; shape (k - 1,)."""
    lmertest_df_within: float | Undefined
    """As lmerTest's `anova` gives it, from contrasts that depend on the order of the conditions; equal to `df_within`
    where all contrasts have the same degrees of freedom, as in every balanced design."""

    @property
    def lmertest_p(self) -> float | Undefined:
        """P(F >= f) with lmerTest's degrees of freedom."""
        tail = self._lmertest_tail()
        return tail if isinstance(tail, Undefined) else tail.p

    @property
    def lmertest_log10_p(self) -> float | Undefined:
        """Decimal logarithm of `lmertest_p`, right at any size."""
        tail = self._lmertest_tail()
        return tail if isinstance(tail, Undefined) else tail.log10_p

    @property
    def method(self) -> str:
        """The test in words."""
        return MIXED_MODEL

    def _lmertest_tail(self) -> Tail | Undefined:
        if isinstance(self.f, Undefined) or isinstance(self.lmertest_df_within, Undefined):
            return self.f if isinstance(self.f, Undefined) else Undefined(Reason.NO_DF)
        return f_upper(self.f, self.df_between, self.lmertest_df_within)


@dataclass(frozen=True, slots=True)
class BlockedByDay(Result):
    """Conditions compared over days: f, p and contrasts are those of its sentence, by the test that `method` names.

    That is the exact test where the design is balanced, else the mixed model. Both are one where REML finds that days
    differ. Where it puts their variance at 0 the model counts days and values together, and errs a little too often if
    days do differ; the exact test does not, whatever days do.
    """

    n: int
    """Number of values."""
    n_days: int
    """Number of days."""
    n_runs: int | Undefined
    """Number of runs, those of all days together."""
    level: float
    """Level of the intervals."""
    conditions: tuple[ConditionMean, ...]
    """The control first, then in the order given; shape (k,)."""
    mixed: MixedModel
    """The mixed model's tests."""
    exact: ExactTest | Undefined
    """The exact F-test, where the design has one."""
    paired: tuple[Contrast, ...]
    """Every other condition minus the control by the means of the days that hold both, by Student's test of their
    differences; shape (k - 1,). It holds its level however much either scatters, and where days act on them
    differently."""
    day_variance: float | Undefined
    """Variance between days by the mixed model, unit of the values squared; 0 where REML puts it at its boundary."""
    run_variance: float | Undefined
    """Variance between the runs of a day, unit of the values squared."""
    residual_variance: float | Undefined
    """Variance within runs (or days), unit of the values squared."""
    day_ratio: float
    """Variance between days over that within runs (or days), as means and differences weigh days by it, in any unit; 0
    where the model has no variance of days, 1e12 where nothing is tested and differences within days alone count."""
    singular: bool | Undefined
    """Whether a variance is estimated as 0."""
    reml_criterion: float | Undefined
    """-2 log restricted likelihood (lme4's REMLcrit)."""
    confounding: Remark | None
    """Which conditions share no day and what follows; nothing where all are joined by shared days."""
    notes: tuple[Remark, ...]
    """What the design could not tell, and what was therefore left out of the model; shape (0,) or (1,)."""
    missing: int
    """How many values were left out because they or a label were missing."""

    def leading(self) -> ExactTest | MixedModel:
        """Return the test that sentence, figure and report state: the exact one where the design is balanced."""
        return self.exact if isinstance(self.exact, ExactTest) and self.exact.balanced else self.mixed

    @property
    def method(self) -> str:
        """The leading test, in words: "mixed model", "exact test on values, day held fixed"."""
        return self.leading().method

    @property
    def f(self) -> float | Undefined:
        """F of all conditions being equal, dimensionless."""
        return self.leading().f

    @property
    def df_between(self) -> int:
        """Number of conditions minus 1."""
        return self.mixed.df_between

    @property
    def df_within(self) -> float | Undefined:
        """Degrees of freedom of the scatter."""
        return self.leading().df_within

    @property
    def p(self) -> float | Undefined:
        """P(F >= f)."""
        return self.leading().p

    @property
    def log10_p(self) -> float | Undefined:
        """Decimal logarithm of p, right at any size."""
        return self.leading().log10_p

    @property
    def contrasts(self) -> tuple[Contrast, ...]:
        """Every other condition minus the control; shape (k - 1,)."""
        return self.leading().contrasts

    def rows(self) -> tuple[Contrast, ...]:
        """Return the contrasts, for `to_frame`."""
        return self.contrasts

    def sentence(self, unit: str = "") -> str:
        """Return the test, the differences to the control and what the design cannot tell, in words.

        Each difference is followed by the paired one of day means, where two days or more hold both and it is another.
        """
        days = f"{self.n_days} day{'' if self.n_days == 1 else 's'}"
        conditions = f"{len(self.conditions)} condition{'' if len(self.conditions) == 1 else 's'}"
        where = f"{conditions}, {days}, n = {self.n}{missing_text(self.missing)}"
        exact = [self._exact_text(self.exact)] if isinstance(self.exact, ExactTest) else []
        mixed = [] if isinstance(self.mixed.f, Undefined) or self._without_mixed() else [self._mixed_text()]
        tests = [*mixed, *exact] if self.leading() is self.mixed else [*exact, *mixed]
        text = f"The conditions ({where}) give {'; '.join(tests)}."
        if isinstance(self.f, Undefined):
            text = f"No test of the conditions with day as a random effect ({where}): {self.f.reason}."
        parts = [text]
        for contrast, paired in zip(self.contrasts, self.paired, strict=True):
            parts += [contrast.sentence(self.level, unit), *self._paired_text(paired, unit)]
        remarks = [*([] if self.confounding is None else [self.confounding]), *self.notes]
        return " ".join([*parts, *(remark.text for remark in remarks)])

    def _without_mixed(self) -> bool:
        """Whether the exact test stands for the mixed model's, which has no day in it.

        So it is on a single day, where both are one, and where conditions had days of their own and REML puts the days'
        variance at 0: the model then counts values where the exact test counts days.
        """
        if self.leading() is self.mixed:
            return False
        of_one_day = self.n_days == 1 and isinstance(self.run_variance, Undefined)
        return of_one_day or (self.confounding is not None and self.day_variance == 0.0)

    def _is_paired(self, exact: ExactTest) -> bool:
        """Whether the exact test is itself the paired one, that of two conditions with one value each on every day."""
        return exact.balanced and exact.block == "day" and (exact.df_between, exact.df_within) == (1, self.n_days - 1)

    def _paired_text(self, paired: Contrast, unit: str) -> list[str]:
        """Return the paired difference in a sentence, unless there is none or the exact test is that one."""
        if isinstance(paired.t, Undefined) or isinstance(paired.df, Undefined):
            return []
        if isinstance(self.exact, ExactTest) and self._is_paired(self.exact):
            return []
        return [
            f"Paired on the means of {int(paired.df) + 1} days, which holds however much either scatters, it is "
            f"{number_text(paired.difference, error=error_of(paired.interval))}{with_unit(unit)} "
            f"({interval_text(paired.interval, self.level, unit)}), {statistic_text('t', paired.t, (paired.df,))}, "
            f"{p_text(paired.p, alpha_of_level(self.level))}."
        ]

    def _exact_text(self, exact: ExactTest) -> str:
        alike = "" if self._is_paired(exact) else ", if all conditions scatter alike"
        return (
            f"{statistic_text('F', exact.f, (exact.df_between, exact.df_within))}, "
            f"{p_text(exact.p, alpha_of_level(self.level))} ({exact.method}{alike})"
        )

    def _mixed_text(self) -> str:
        """Return the mixed model's test, with what is random in it."""
        by_run = isinstance(self.run_variance, float)
        random = ["day"] * (self.day_variance == 0.0 or self.day_ratio > 0.0) + ["run"] * by_run
        as_what = "random effects" if random[1:] else "a random effect"
        effects = f"with {' and '.join(random)} as {as_what} " if random else ""
        limit = ""
        if self.day_variance == 0.0:
            units = "runs" if by_run and self.run_variance else "values"
            limit = f"; days estimated not to differ, so that {units} count as independent"
        mixed = self.mixed
        return (
            f"{effects}{statistic_text('F', mixed.f, (mixed.df_between, mixed.df_within))}, "
            f"{p_text(mixed.p, alpha_of_level(self.level))} (REML, Satterthwaite{limit})"
        )
