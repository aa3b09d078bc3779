"""What a comparison of conditions over several days says: means, differences, variances, tests, and its limits."""

from __future__ import annotations

from dataclasses import dataclass

from data_schema.vocabulary import Undefined
from stats.wording import interval_text, number_text, p_text, with_unit

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class ConditionMean:
    """A condition as the model estimates it, in the unit of the values."""

    condition: str
    n: int
    """Number of values."""
    n_days: int
    """Number of days it was measured on."""
    estimate: float
    """Generalised least-squares mean, for an average day."""
    se: float | Undefined
    """Standard error, for days drawn at random."""
    df: float | Undefined
    """Degrees of freedom after Satterthwaite."""
    interval: Interval | Undefined


@dataclass(frozen=True, slots=True)
class Contrast:
    """A condition minus the control, in the unit of the values."""

    condition: str
    control: str
    difference: float
    se: float | Undefined
    df: float | Undefined
    t: float | Undefined
    p: float | Undefined
    """Two-sided, for this comparison alone."""
    interval: Interval | Undefined


@dataclass(frozen=True, slots=True)
class ExactTest:
    """Analysis of variance whose size is exact under the model, whatever the days' variance."""

    unit: str
    """What is counted as one observation: "value", "run mean" or "day mean"."""
    block: str
    """What is held fixed: "day", "run" or "nothing"."""
    balanced: bool
    """Whether every block holds every condition equally often; the mixed model then has the same F, unless its days'
    variance is estimated as 0 and days are pooled with values."""
    f: float
    df_between: int
    df_within: int
    p: float
    contrasts: tuple[Contrast, ...]
    """Differences to the control from the same mean square."""


@dataclass(frozen=True, slots=True)
class BlockedByDay:
    """Conditions compared by y ~ condition + (1 | day) [+ (1 | day:run)], fitted by REML."""

    n: int
    n_days: int
    n_runs: int | Undefined
    level: float
    """Level of the intervals."""
    conditions: tuple[ConditionMean, ...]
    """The control first."""
    contrasts: tuple[Contrast, ...]
    """Every other condition minus the control."""
    day_variance: float | Undefined
    """Variance between days, unit of the values squared; 0 where REML puts it at its boundary."""
    run_variance: float | Undefined
    """Variance between the runs of a day, unit of the values squared."""
    residual_variance: float | Undefined
    singular: bool | Undefined
    """Whether a variance is estimated as 0."""
    reml_criterion: float | Undefined
    """-2 log restricted likelihood (lme4's REMLcrit)."""
    f: float | Undefined
    """F of all conditions being equal, from the mixed model."""
    df_between: int
    df_within: float | Undefined
    """Denominator's degrees of freedom after Satterthwaite (Fai and Cornelius where several differ)."""
    p: float | Undefined
    exact: ExactTest | Undefined
    """The exact F-test, where the design has one."""
    confounding: str
    """Which conditions share no day and what follows; empty where all are joined by shared days."""
    notes: tuple[str, ...]
    """What the design could not tell, and what was therefore left out of the model."""

    def sentence(self, unit: str = "") -> str:
        """Return the test, the differences to the control and what the design cannot tell, in words.

        The exact test comes first where the design is balanced, and the differences are then its own.
        """
        days = f"{self.n_days} day{'' if self.n_days == 1 else 's'}"
        where = f"{len(self.conditions)} condition{'' if len(self.conditions) == 1 else 's'}, {days}, n = {self.n}"
        exact = self.exact if isinstance(self.exact, ExactTest) else None
        contrasts = self.contrasts
        mixed = ""
        if not isinstance(self.f, Undefined):
            mixed = (
                f"with day as a random effect F({self.df_between}, {number_text(self.df_within)}) = "
                f"{number_text(self.f)}, {p_text(self.p)} (REML, Satterthwaite)"
            )
        if exact is not None and (exact.balanced or not mixed):
            contrasts = exact.contrasts
            text = f"The conditions ({where}) give {_exact_text(exact)}{mixed and '; ' + mixed}."
        elif mixed:
            text = f"The conditions ({where}) give {mixed}{'; ' + _exact_text(exact) if exact else ''}."
        else:
            reason = self.f.reason if isinstance(self.f, Undefined) else ""
            text = f"No test of the conditions with day as a random effect ({where}): {reason}."
        parts = [text, *(contrast_sentence(each, self.level, unit) for each in contrasts)]
        parts += [self.confounding] if self.confounding else []
        return " ".join([*parts, *self.notes])


def _exact_text(exact: ExactTest) -> str:
    held = "" if exact.block == "nothing" else f", {exact.block} held fixed"
    return (
        f"F({exact.df_between}, {exact.df_within}) = {number_text(exact.f)}, {p_text(exact.p)} "
        f"(exact test on {exact.unit}s{held})"
    )


def contrast_sentence(contrast: Contrast, level: float, unit: str = "") -> str:
    """Return one difference in words, with its interval and test or why there is none."""
    text = (
        f"{contrast.condition} minus {contrast.control} is {number_text(contrast.difference)}{with_unit(unit)} "
        f"({interval_text(contrast.interval, level, unit)})"
    )
    if isinstance(contrast.t, Undefined):
        return f"{text}; no test, because {contrast.t.reason}."
    return f"{text}, t({number_text(contrast.df)}) = {number_text(contrast.t)}, {p_text(contrast.p)}."
