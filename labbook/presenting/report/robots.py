"""Which robots the analysed runs are of, and where a comparison sets one robot against another."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from labbook.analysis.comparison import pairing
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.study import StudyAnalysis
from reports.content import ReportContent
from reports.naming import levels_name
from reports.wording import list_text


def runs_by_robot(analysis: StudyAnalysis) -> dict[str, int]:
    """Count the analysed runs of each robot, in the order in which the robots were used."""
    used = {uid for found in analysis.results.values() for uid in found.results}
    return dict(Counter(run.robot for run in analysis.evidence.runs if run.uid in used))


def limitations(analysis: StudyAnalysis, content: ReportContent) -> tuple[str, ...]:
    """Say in which groups the control and the treated runs are not of the same robots; `content` names groups."""
    found = []
    for item in analysis.compared:
        if item.pair.family != pairing.POOLED:
            continue
        control, treated = _robots(item.pair.a), _robots(item.pair.b)
        if control.keys() != treated.keys():
            name = levels_name(content, item.pair.group)
            found.append(
                f"{f'With {name}' if name else 'In this selection'} the control runs are of {_listed(control)} and the "
                f"treated runs of {_listed(treated)}: the differences may be the robots'."
            )
    return tuple(dict.fromkeys(found))


def _robots(side: Iterable[ConditionValues]) -> Mapping[str, int]:
    return Counter(item.run.robot for condition in side for item in condition.runs)


def _listed(robots: Mapping[str, int]) -> str:
    return list_text([f"{robot} ({runs})" for robot, runs in robots.items()])
