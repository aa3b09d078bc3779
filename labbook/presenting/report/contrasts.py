"""Contrasts of condition means as a report shows them."""

from __future__ import annotations

from data_schema.vocabulary import ContrastKind
from labbook.analysis.study import StudyAnalysis
from labbook.presenting.numbers import ShownNumbers
from labbook.presenting.report.comparisons import SIDES, UNITS
from reports.evidence import MeansContrast

_LEVELS = ("the level", "the reference")


def contrasts(analysis: StudyAnalysis, shown: ShownNumbers) -> tuple[MeansContrast, ...]:
    """Return the contrasts that were made, in their order."""
    planned = analysis.planned
    found = []
    for one in analysis.contrasts:
        asked, result, label = one.asked, one.result, one.asked.label
        sides = _LEVELS if asked.settings.kind is ContrastKind.DIFFERENCE else SIDES
        words = shown.of_sides(sides, planned.settings.unit_of_analysis.noun)
        why = planned.reason_of_contrast(
            asked.settings.outcome, asked.conditions, selected=bool(analysis.evidence.selection)
        )
        found.append(
            MeansContrast(
                kind=asked.settings.kind,
                quantity=asked.settings.outcome,
                factor=asked.settings.factor or analysis.swept or "",
                levels=asked.levels,
                side=str(asked.settings.side or ""),
                per=asked.per,
                left_out=asked.left_out,
                at=asked.settings.at,
                estimate=words.number(result.estimate),
                test=words.test("contrast", result.t, result.p),
                adjusted=None if one.adjusted is None else words.number(one.adjusted.adjusted_p[label]),
                rejected=result.rejected if one.adjusted is None else one.adjusted.rejected[label],
                unit=UNITS[result.rule],
                days=result.days,
                exploratory="" if why is None else why.text,
            )
        )
    return tuple(found)
