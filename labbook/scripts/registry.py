"""What makes the script of a number, by the kind of its result."""

from collections.abc import Callable, Mapping

from labbook.scripts.facts import Facts
from labbook.scripts.kinds import (
    anova,
    biases,
    budgets,
    conditions,
    contrasts,
    decisions,
    drains,
    equivalence,
    families,
    hypotheses,
    overall,
    packs,
    predictions,
    two_samples,
)
from labbook.scripts.script import Asked, Script

KINDS: Mapping[str, Callable[[Asked, Facts], Script | None]] = {
    "condition_summary": conditions.script,
    "passive_drain": drains.script,
    "decision": decisions.script,
    "decision_family": families.script,
    "decision_equivalence": equivalence.script,
    "contrast": contrasts.script,
    "overall_savings": overall.script,
    "overall_equivalence": overall.script_of_equivalence,
    "thesis_route": two_samples.script,
    "thesis_route_over_jumps": two_samples.script_over_jumps,
    "anova": anova.script,
    "pack_deviation": packs.script,
    "hypothesis": hypotheses.script,
    "energy_budget": budgets.script,
    "prediction_check": predictions.script,
    "prediction_bias": biases.script,
    "joint_bias": biases.script_of_all,
    "limits_of_agreement": biases.script_of_limits,
}
"""By the kind of result, as `numbers.json` has it; what a maker returns is None where a number has no script."""
