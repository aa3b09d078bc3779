"""The passive-drain fit and the uncertainty budget of a joule as a report shows them."""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np

from data_schema.vocabulary import Undefined
from labbook.analysis.passive_drain import MAH_MIN, fitted, idle_charges
from labbook.analysis.study import StudyAnalysis
from labbook.presenting.methods import drain_sentence
from labbook.presenting.numbers import Shown
from reports.content import BudgetItem, DrainFit, IdlePoint

LINE_POINTS = 61


def drain_fit(analysis: StudyAnalysis, shown: Shown) -> DrainFit | None:
    """Return points, line and band of the fit; None where there is none."""
    drain = fitted(analysis.evidence)
    duration_s = analysis.evidence.configuration.protocol.run_duration_s
    if isinstance(drain, Undefined) or duration_s is None:
        return None
    minutes = np.linspace(0.0, drain.duration_max_s * 1.05 / MAH_MIN, LINE_POINTS)
    band = [drain.at(minute * MAH_MIN) for minute in minutes]
    return DrainFit(
        points=tuple(
            IdlePoint(run.name, (run.duration_s or 0.0) / MAH_MIN, charge.charge_mah)
            for run, charge in idle_charges(analysis.evidence)
        ),
        line_min=tuple(float(minute) for minute in minutes),
        line_mah=tuple(at.charge_mah for at in band),
        band_low_mah=tuple(float(at.ci_low) for at in band),
        band_high_mah=tuple(float(at.ci_high) for at in band),
        slope=shown.number(analysis.drain, "slope"),
        intercept=shown.number(analysis.drain, "intercept"),
        r_squared=shown.value(analysis.drain, "r_squared"),
        at_run=shown.number(analysis.drain, "at_run"),
        run_duration_min=duration_s / MAH_MIN,
        range_sentence=drain_sentence(analysis),
    )


def budget(analysis: StudyAnalysis, shown: Shown) -> tuple[tuple[BudgetItem, ...], str]:
    """Return where the uncertainty of one run's joules comes from, for the condition with the most runs."""
    row = analysis.budget
    if row is None:
        return (), ""
    payload = json.loads(row.payload_json)
    items = [
        BudgetItem(term["name"], shown.value(row, term["name"]), term["shared"], _budget_note(term))
        for term in payload["terms"]
    ]
    items.append(BudgetItem("one run in all", shown.value(row, "one run in all"), shared=False, total=True))
    return tuple(items), f"Condition {json.loads(row.scope_json)['condition']}. {payload['sentence']}"


def _budget_note(term: Mapping[str, bool]) -> str:
    notes = [("contained in the scatter", term["in_scatter"]), ("assumed", term["assumed"])]
    return " and ".join(note for note, holds in notes if holds)
