"""The passive-drain fit and the uncertainty budget of a joule as a report shows them."""

from __future__ import annotations

import numpy as np

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.budget import IN_ALL, BudgetSource
from labbook.analysis.outcomes.conditions import coarse_scatter
from labbook.analysis.outcomes.run_energy import MAH_MIN, RunEnergy, idle_charges
from labbook.analysis.study import StudyAnalysis
from reports.content import CoarseCharger, ReportContent
from reports.evidence import BudgetItem, DrainFit, IdlePoint
from reports.naming import levels_name

_LINE_POINTS = 61
_DRAIN_FIT = "drain fit"
"""The source of the budget that runs of one robot share; others are shared by all runs."""


def drain_fits(analysis: StudyAnalysis) -> tuple[DrainFit, ...]:
    """Return points, line and band of each robot's fit, of those that have one."""
    found = []
    for robot_uid, drain in analysis.drains.items():
        line, at_s = drain.line, drain.result.run_duration_s
        if isinstance(line, Undefined) or at_s is None:
            continue
        minutes = np.linspace(0.0, line.duration_max_s * 1.05 / MAH_MIN, _LINE_POINTS)
        band = [line.at(minute * MAH_MIN) for minute in minutes]
        found.append(
            DrainFit(
                robot=drain.robot,
                points=tuple(
                    IdlePoint(run.name, (run.duration_s or 0.0) / MAH_MIN, charge.charge_mah)
                    for run, charge in idle_charges(analysis.evidence)
                    if run.robot_uid == robot_uid
                ),
                line_min=tuple(float(minute) for minute in minutes),
                line_mah=tuple(at.charge_mah for at in band),
                band_low_mah=tuple(at.charge_mah if isinstance(at.ci_low, Undefined) else at.ci_low for at in band),
                band_high_mah=tuple(at.charge_mah if isinstance(at.ci_high, Undefined) else at.ci_high for at in band),
                slope=drain.result.slope,
                intercept=drain.result.intercept,
                r_squared=drain.result.r_squared,
                at_run=drain.result.at_run,
                run_duration_min=at_s / MAH_MIN,
                range_sentence=line.sentence(at_s),
            )
        )
    return tuple(found)


def budget(analysis: StudyAnalysis, content: ReportContent) -> tuple[tuple[BudgetItem, ...], str]:
    """Return where the uncertainty of joules comes from, for the condition with the most runs, and which that is.

    `content` knows what conditions are called.
    """
    found = analysis.budget
    if found is None:
        return (), ""
    terms = {term.name: term for term in found.terms}
    items = tuple(
        BudgetItem(
            name,
            found.one_run[name],
            found.mean[name],
            shared=name in terms and terms[name].shared,
            note=_budget_note(terms[name]) if name in terms else "",
            total=name == IN_ALL,
            within_robot=name == _DRAIN_FIT and len(content.robots) > 1,
        )
        for name in (*terms, IN_ALL)
    )
    key = found.origin.scope["condition"]
    condition = next(item for item in analysis.conditions[Outcome.JOULES] if item.key == key)
    n = len(condition.runs)
    return items, (
        f"Shown for {levels_name(content, condition.levels)} ({n} run{'' if n == 1 else 's'}), where 1 mAh is "
        f"{found.one_mah.value:.2g} J a jump."
    )


def coarse_charger(analysis: StudyAnalysis) -> CoarseCharger | None:
    """Return the charger's step and the scatter of charges where that is below half a step; None where it is not."""
    runs = [item for condition in analysis.conditions[Outcome.JOULES] for item in condition.runs]
    scatter = coarse_scatter(runs)
    if scatter is None:
        return None
    step_mah = max(item.result.step_mah for item in runs if isinstance(item.result, RunEnergy))
    return CoarseCharger(step_mah, scatter * step_mah)


def _budget_note(term: BudgetSource) -> str:
    notes = [("contained in the scatter", term.in_scatter), ("assumed", term.assumed)]
    return " and ".join(note for note, holds in notes if holds)
