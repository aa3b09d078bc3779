"""What is to be known of a book's runs that are compared: left out, pooled over levels, or beside the plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from data_schema.outcomes import Outcome
from labbook.analysis.comparison import pairing
from labbook.analysis.outcomes.conditions import RunNumber
from labbook.analysis.study_data import StudyData
from labbook.config.parsing import Configuration

_MOST_NAMED = 5


def left_out(
    evidence: StudyData, numbers: Sequence[RunNumber], missing: Mapping[str, str], quantity: Outcome
) -> list[str]:
    """Say which runs have no number, and why."""
    used = {item.run.uid for item in numbers}
    left = [run for run in evidence.runs if run.uid not in used]
    if not left:
        return []
    reasons = [f"{run.name} ({missing.get(run.uid, 'undefined')})" for run in left[:_MOST_NAMED]]
    more = ", ..." if len(left) > _MOST_NAMED else ""
    of_all = f"{len(left)} of {len(evidence.runs)} runs"
    return [f"{of_all} have no {quantity.plural} and are left out: {', '.join(reasons)}{more}."]


def _several_levels(numbers: Sequence[RunNumber], by: str, configuration: Configuration) -> list[str]:
    """Return which factors differ within the groups."""
    return [
        name
        for name in configuration.factors
        if name != by and len({item.run.levels.get(name) for item in numbers}) > 1
    ]


def pooled_over(numbers: Sequence[RunNumber], by: str, configuration: Configuration) -> list[str]:
    """Say which factors differ within the groups, whose runs are then compared as one."""
    found = _several_levels(numbers, by, configuration)
    if not found:
        return []
    return [
        f"Runs of several levels of {' and '.join(found)} are compared as one: --where selects one level, within which "
        "the planned families compare."
    ]


def beside_plan(by: str, control: str, jumps: bool, numbers: Sequence[RunNumber], configuration: Configuration) -> str:
    """Say why none of the families that can be decided on has this question; "" where one has."""
    swept = pairing.swept_factor(configuration)
    if swept is None or by != swept:
        other = "" if swept is None else f", its families compare levels of {swept}"
        return f"the plan has no comparison by {by}{other}"
    usual = configuration.factors[swept].control
    if control != usual:
        return f"the plan's families compare with the control {swept} {usual}, not with {control}"
    several = _several_levels(numbers, by, configuration)
    if several:
        return f"the plan's families compare within one level of {' and '.join(several)}, not over several"
    return "the unit of analysis is a run or a day's mean, not the single jump" if jumps else ""
