"""How far predictions lie from what was measured: of a group, of all groups jointly, and limits of agreement."""

from collections.abc import Mapping, Sequence

from labbook.analysis.comparison.pairing import group_label
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.scripts.facts import Facts
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_with_simulated

_STEPS = {
    "bias": "biases.bias",
    "of_measured": "biases.bias_of_measured",
    "p": "biases.bias_p",
    "measured": "biases.measured_over_days",
    "predicted": "biases.predicted_over_days",
}
_JOINT = {"p": "biases.joint_p", "tau": "biases.tau_of_groups"}
_LIMITS = {
    "mean_difference": "biases.mean_difference",
    "lower_limit": "biases.lower_limit",
    "upper_limit": "biases.upper_limit",
}


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of a group's bias."""
    group = _groups(asked, facts).get(str(asked.scope["group"]), [])
    return _script(asked, facts, group, _STEPS.get(asked.name))


def script_of_all(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of the joint test."""
    groups = _groups(asked, facts)
    judged = {label: tuple(one.key for one in group) for label, group in groups.items()}
    every = [one for group in groups.values() for one in group]
    return _script(asked, facts, every, _JOINT.get(asked.name), judged)


def script_of_limits(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of the mean difference, or of a limit."""
    every = [one for one in facts.conditions(asked.outcome) if facts.is_simulated(one, asked.outcome)]
    return _script(asked, facts, every, _LIMITS.get(asked.name))


def _groups(asked: Asked, facts: Facts) -> dict[str, list[ConditionValues]]:
    """Return the conditions that have a prediction with its error, by their groups."""
    found: dict[str, list[ConditionValues]] = {}
    for one in facts.conditions(asked.outcome):
        if facts.is_simulated(one, asked.outcome, varied=True):
            levels = {factor: level for factor, level in one.levels.items() if factor != facts.swept}
            found.setdefault(group_label(levels), []).append(one)
    return found


def _script(
    asked: Asked,
    facts: Facts,
    conditions: Sequence[ConditionValues],
    step: str | None,
    judged: Mapping[str, Sequence[str]] | None = None,
) -> Script | None:
    if step is None or not conditions:
        return None
    rows = rows_with_simulated(facts, conditions, asked.outcome)
    return Script(rows, (reading_of(asked.outcome), step), {**facts.settings, "JUDGED": judged or {}})
