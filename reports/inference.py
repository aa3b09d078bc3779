"""What stands beside a comparison on run means: its sides, the day as a random effect, equivalence within bounds."""

from __future__ import annotations

from dataclasses import dataclass

from reports.numbers import Number, SignificanceTest, Value


@dataclass(frozen=True, slots=True)
class Side:
    """Mean and standard deviation of the runs of one side of a comparison."""

    mean: Value
    sd: Value


@dataclass(frozen=True, slots=True)
class ByDay:
    """Treatment less control by y ~ condition + (1 | day).

    `method` names the test: "mixed model" (REML, degrees of freedom after Satterthwaite), or "exact test on ..." where
    the design is balanced. `day_sd` and `run_sd` are the standard deviations between days and between runs of a day, by
    REML. `confounding` says what cannot be told because days and conditions go together, "" where they do not; `notes`
    what the model left out.
    """

    difference: Number
    test: SignificanceTest
    days: int
    day_sd: Number
    run_sd: Number
    method: str
    confounding: str = ""
    notes: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """The test in two words: "mixed model" or "exact test"."""
        return self.method.partition(" on ")[0]


@dataclass(frozen=True, slots=True)
class Equivalence:
    """Two one-sided Welch tests of apex heights against bounds in m, or in % of the control's mean.

    `estimate` is treatment less control in the unit of the bounds, with an interval of level 1 - 2 alpha; `shown` is
    None where there is no test. `exploratory` says why the test was not planned, "" where it was.
    """

    estimate: Number
    low: float
    high: float
    at_low: SignificanceTest
    at_high: SignificanceTest
    p: Value
    shown: bool | None
    exploratory: str = ""
