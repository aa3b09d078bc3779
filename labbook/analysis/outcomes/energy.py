"""Joules a jump from a recharge, and what their uncertainty is made of (thesis 5.1.4).

joules a jump = 3.6 * reference voltage * (charge - passive charge) / jumps made, with 3.6 C in a mAh. The charge is
what the charger put back, the passive charge the drain line at the run's own duration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import number_text
from data_schema.units import MAH_TO_COULOMB
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_number, as_values, complete_rows
from stats.compare.summary import describe
from stats.exact.numbers import Floats, finite, moments, refuse_beyond
from stats.lines.passive_drain import rounding_sd_mah
from stats.results import Result, missing_text, with_unit

_TERM = "the standard error"


def joules_per_jump(
    charge_mah: float, passive_mah: float, reference_voltage_v: float, jumps_made: int
) -> float | Undefined:
    """Return the energy of one jump in joules; `Undefined` where no jump was made.

    Jumps made, not jumps detected. Raises `InputRefused` for values that are not finite, a voltage that is not
    positive or a negative count.
    """
    charge_mah = as_number("the charge", charge_mah, low=0.0)
    passive_mah = as_number("the passive charge", passive_mah)
    if jumps_made < 0:
        raise InputRefused(f"jumps made is {jumps_made}: give a count of 0 or more.")
    if jumps_made == 0:
        return Undefined(Reason.NO_JUMP_MADE)
    joules = joules_per_mah(reference_voltage_v, jumps_made) * (charge_mah - passive_mah)
    return finite(joules, "the energy of a jump")


def joules_per_mah(reference_voltage_v: float, jumps_made: float) -> float:
    """Return what one mAh is worth in joules a jump: 2.2 J at 15.4 V and 25 jumps."""
    voltage = as_number("the reference voltage", reference_voltage_v, above=0.0)
    per_mah = MAH_TO_COULOMB * voltage / as_number("jumps made", jumps_made, above=0.0)
    refuse_beyond("what a mAh is worth in joules a jump", [per_mah])
    return per_mah


@dataclass(frozen=True, slots=True)
class BudgetTerm(Result):
    """One source of uncertainty of joules a jump, as standard errors in joules."""

    name: str
    """What errs."""
    one_run_j: float | Undefined
    """Standard error that it gives a single run, in joules a jump."""
    mean_j: float | Undefined
    """Standard error that it gives the mean of the condition, in joules a jump."""
    shared: bool
    """Whether it shifts all runs alike, so that more runs do not make it smaller."""
    in_scatter: bool
    """Whether the scatter between runs contains it already; such a term is shown and not added again."""
    assumed: bool
    """Whether its size is assumed, not measured or stated by a source."""


@dataclass(frozen=True, slots=True)
class EnergyBudget(Result):
    """Uncertainty budget of joules a jump in one condition."""

    n: int
    """Runs."""
    mean_j: float
    """Mean of the runs, in joules a jump."""
    terms: tuple[BudgetTerm, ...]
    """Scatter between runs, drain fit, charger resolution, reference voltage, in this order; shape (4,)."""
    total_one_run_j: float | Undefined
    """Scatter and shared terms of a single run, added in quadrature, in joules a jump."""
    total_mean_j: float | Undefined
    """Scatter and shared terms together, added in quadrature, in joules a jump."""
    joules_per_mah: float
    """What one mAh at the charger is worth in joules a jump (mean over the runs)."""
    missing: int = 0
    """Runs left out because a value was NaN."""

    def rows(self) -> tuple[BudgetTerm, ...]:
        """Return the terms, for `to_frame`."""
        return self.terms

    def sentence(self) -> str:
        """Return the budget in words: mean, its standard error, what each term adds to it, n."""
        terms = [
            f"{term.name} {number_text(term.mean_j, 2)}{with_unit('' if isinstance(term.mean_j, Undefined) else 'J')}"
            f"{' (assumed)' if term.assumed else ''}{' (in the scatter)' if term.in_scatter else ''}"
            for term in self.terms
        ]
        unit = "" if isinstance(self.total_mean_j, Undefined) else "J"
        return (
            f"The mean is {number_text(self.mean_j)} J a jump, standard error {number_text(self.total_mean_j, 2)}"
            f"{with_unit(unit)} ({', '.join(terms)}; n = {self.n}{missing_text(self.missing)})."
        )


def energy_budget(
    joules: ArrayLike,
    jumps_made: ArrayLike,
    *,
    reference_voltage_v: float,
    drain_se_run_j: float,
    drain_se_mean_j: float,
    resolution_mah: float,
    voltage_relative_se: float = 0.0,
    voltage_assumed: bool = True,
    missing: Missing = "refuse",
) -> EnergyBudget:
    """Return the budget of one condition from its runs' joules a jump and jumps made, both of shape (n,).

    `drain_se_run_j` and `drain_se_mean_j` are what the drain line's error makes of one run's joules and of their mean
    (`compare.shared_error`; the same at equal durations and jumps). A charger that counts in steps of `resolution_mah`
    errs by at most half a step, standard deviation step / sqrt(12); it differs from run to run, so the scatter holds it
    already. The voltage's relative standard error shifts all joules by one factor.
    Raises `InputRefused` for infinite values, for NaN unless `missing` is "drop" (which leaves out runs), lengths that
    differ, counts that are not positive, or no run.
    """
    values, counts, left_out = _checked_runs(joules, jumps_made, missing)
    relative = as_number("the voltage's relative standard error", voltage_relative_se, low=0.0)
    step_sd_mah = rounding_sd_mah(resolution_mah)
    about = describe(values)
    mean = moments(values).mean
    per_mah = joules_per_mah(reference_voltage_v, _harmonic_mean(counts))

    of_run = as_number("the drain fit's standard error of a run", drain_se_run_j, low=0.0)
    of_mean = as_number("the drain fit's standard error of the mean", drain_se_mean_j, low=0.0)
    voltage = relative * abs(mean)
    of_step, of_steps, of_voltage = (
        finite(size, _TERM) for size in (per_mah * step_sd_mah, per_mah * step_sd_mah / math.sqrt(about.n), voltage)
    )
    return EnergyBudget(
        n=about.n,
        mean_j=mean,
        terms=(
            BudgetTerm("scatter between runs", about.sd, about.se, shared=False, in_scatter=False, assumed=False),
            BudgetTerm("drain fit", of_run, of_mean, shared=True, in_scatter=False, assumed=False),
            BudgetTerm("charger resolution", of_step, of_steps, shared=False, in_scatter=True, assumed=False),
            BudgetTerm(
                "reference voltage", of_voltage, of_voltage, shared=True, in_scatter=False, assumed=voltage_assumed
            ),
        ),
        total_one_run_j=_in_quadrature(about.sd, of_run, voltage),
        total_mean_j=_in_quadrature(about.se, of_mean, voltage),
        joules_per_mah=per_mah,
        missing=left_out,
    )


def _checked_runs(joules: ArrayLike, jumps_made: ArrayLike, missing: Missing) -> tuple[Floats, Floats, int]:
    """Return the joules and the counts of complete runs, each of shape (n,), and how many runs were left out."""
    (joules, jumps_made), left_out = complete_rows([joules, jumps_made], missing)
    values, counts = as_values("the joules", joules), as_values("jumps made", jumps_made)
    if values.size != counts.size:
        raise InputRefused(f"there are {values.size} joules and {counts.size} counts: give one count for each run.")
    if values.size == 0:
        raise InputRefused("there is no run: a budget needs the joules of at least one.")
    if float(counts.min()) <= 0.0:
        raise InputRefused("a run without jumps has no joules a jump: leave it out of the budget.")
    return values, counts, left_out


def _harmonic_mean(counts: Floats) -> float:
    """Return the number of jumps at which a mAh is worth what it is in the mean over runs."""
    with np.errstate(over="ignore"):
        shares = 1.0 / counts
    jumps = 1.0 / moments(shares).mean if np.isfinite(shares).all() else math.inf
    refuse_beyond("the jumps made or one over them", [jumps])
    return jumps


def _in_quadrature(scatter: float | Undefined, *shared: float) -> float | Undefined:
    return scatter if isinstance(scatter, Undefined) else finite(math.hypot(scatter, *shared), "the total")
