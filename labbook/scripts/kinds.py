"""The script of a number by the kind of its result: of which runs, and by which functions of the templates."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.contrasts import AskedContrast, contrast_result
from labbook.analysis.comparison.deciding import contrast_of, decide_pair
from labbook.analysis.comparison.order import ADJUSTED
from labbook.analysis.comparison.pairing import Pair, group_label
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.prediction.hypotheses import comparisons_of
from labbook.config.model import ClaimKind
from labbook.scripts.facts import (
    Asked,
    Facts,
    Script,
    conditions_in,
    idle_rows,
    keys_of,
    reading_of,
    rows_of,
    rows_with_simulated,
)
from stats.days.overall import overall_savings

Settings = Mapping[str, object]


def _script(
    asked: Asked,
    facts: Facts,
    steps: str | Sequence[str] | None,
    conditions: Sequence[ConditionValues],
    settings: Settings | None = None,
    *,
    first: str | None = None,
    simulated: bool = False,
) -> Script | None:
    """Return the script that takes these steps once the values of the runs are read; None without a step or a run.

    Where the last step computes several numbers together, `first` is the one that it calls its value, "" if none is.
    """
    if not steps or not conditions:
        return None
    read_with = rows_with_simulated if simulated else rows_of
    every = [reading_of(asked.outcome), *([steps] if isinstance(steps, str) else steps)]
    all_settings = {**facts.settings, **(settings or {})}
    if first is not None and asked.name != first:
        every.append("picked")
        all_settings["PICKED"] = asked.name
    return Script(read_with(facts, conditions, asked.outcome, asked.variant), every, all_settings)


def _conditions(asked: Asked, facts: Facts) -> list[ConditionValues]:
    """Return the condition that a number is of."""
    return [one for one in facts.conditions(asked.outcome, asked.variant) if one.key == asked.scope["condition"]]


def _pair(asked: Asked, facts: Facts) -> Pair | None:
    """Return the comparison that a number is of."""
    pairs = facts.pairs(asked.outcome, asked.variant)
    wanted = asked.scope.get("family"), asked.scope["label"]
    return next((pair for pair in pairs if wanted in ((pair.family, pair.label), (None, pair.label))), None)


_CONDITION = {"mean": "condition_mean", "sd": "condition_sd"}


def _condition(asked: Asked, facts: Facts) -> Script | None:
    """Mean of a condition, and the standard deviation of its runs."""
    return _script(asked, facts, _CONDITION.get(asked.name), _conditions(asked, facts))


def _drain(asked: Asked, facts: Facts) -> Script | None:
    """Slope, intercept and R squared of a passive-drain line, and the charge that it gives at a run's duration."""
    robots = {run.robot_uid: run.robot for run in (*facts.evidence.idle, *facts.evidence.runs)}
    wanted = [uid for uid, name in robots.items() if name == asked.scope["robot"]]
    if asked.name not in ("slope", "intercept", "r_squared", "at_run") or not wanted:
        return None
    rows = idle_rows(facts, wanted, asked.variant)
    durations_s = [float(row["duration_s"]) for row in rows]
    duration_s = facts.configuration.protocol.run_duration_s
    settings = {"RUN_DURATION_S": sum(durations_s) / len(durations_s) if duration_s is None else float(duration_s)}
    return Script(rows, (asked.name,), settings)


_DIFFERENCE = "difference_of_means"
_DECISION = {
    **dict.fromkeys(("difference", "p"), _DIFFERENCE),
    "savings": "savings",
    "control_mean": "mean_of_control",
    "run_sd": "run_sd",
}


def _decision(asked: Asked, facts: Facts) -> Script | None:
    """The test that decides a comparison: difference, saving, t, p, mean of the control, SD of runs."""
    pair, outcome = _pair(asked, facts), asked.outcome
    if pair is None:
        return None
    step = _DECISION.get(asked.name)
    if asked.name == "t":
        step = "t_of_saving" if outcome.has_savings else _DIFFERENCE
    settings: dict[str, object] = {
        "PAIR": keys_of(pair),
        "LEVEL": facts.decision_level(outcome),
        "ONE_SIDED": facts.planned.settings.one_sided and outcome.has_savings,
    }
    steps, pairs = [step] if step else [], [pair]
    if step and asked.variant == ADJUSTED:
        steps, pairs = ["at_mean_position", step], facts.pooled(outcome)
        settings["GROUPS"] = {each.label.partition(":")[0]: keys_of(each) for each in pairs}
    first = "difference" if step == _DIFFERENCE else None
    return _script(asked, facts, steps, conditions_in(pairs), settings, first=first)


def _family(asked: Asked, facts: Facts) -> Script | None:
    """Holm's adjusted p of a test among those of its family."""
    head, _comma, label = asked.name.partition(", ")
    if head != "adjusted_p":
        return None
    if asked.scope["family"] == "contrasts":
        return _family_of_contrasts(label, asked, facts)
    outcome, settings = asked.outcome, facts.planned.settings
    several = [*facts.conditions(outcome), *facts.conditions_beside(outcome)]
    pairs = [pair for pair in pairing.pairs_with_control(several, facts.swept) if pair.family == asked.scope["family"]]
    tested = [pair for pair in pairs if not isinstance(decide_pair(pair, outcome, settings).p.value, Undefined)]
    values = {
        "LEVEL": facts.decision_level(outcome),
        "ONE_SIDED": settings.one_sided and outcome.has_savings,
        "TESTS": {pair.label: keys_of(pair) for pair in tested},
        "ASKED": label,
        "WITHOUT_P": len(pairs) - len(tested),
    }
    return _script(asked, facts, "adjusted_p", conditions_in(tested), values)


def _family_of_contrasts(label: str, asked: Asked, facts: Facts) -> Script | None:
    alpha, every = facts.planned.settings.alpha, facts.contrasts()
    results = {name: contrast_result(one, facts.swept, alpha) for name, one in every.items()}
    tested = {name: one for name, one in every.items() if not isinstance(results[name].p.value, Undefined)}
    outcomes = {one.settings.outcome for one in tested.values()}
    if len(outcomes) != 1:  # values of one table have one unit
        return None
    values = {
        "LEVEL": 1.0 - alpha,
        "CONTRASTS": {name: (one.percent, _effects(one)) for name, one in tested.items()},
        "ASKED": label,
        "WITHOUT_P": len(every) - len(tested),
    }
    pairs = [pair for one in tested.values() for _weight, pair in one.terms]
    of_outcome = Asked(asked.name, {**asked.scope, "quantity": outcomes.pop()})
    return _script(of_outcome, facts, "adjusted_p_of_contrast", conditions_in(pairs), values)


def _bounds(facts: Facts, low: str, high: str) -> dict[str, object] | None:
    """Return the settings of tests against the bounds of apex heights; None without bounds."""
    bounds = facts.planned.settings.apex_bounds
    if bounds is None:
        return None
    return {
        "LEVEL": 1.0 - 2.0 * facts.planned.settings.alpha,
        low: -math.inf if bounds.low is None else bounds.low,
        high: math.inf if bounds.high is None else bounds.high,
        "IN_PERCENT": bounds.percent,
    }


def _equivalence(asked: Asked, facts: Facts) -> Script | None:
    """Two one-sided tests that apex heights changed within bounds, of one comparison."""
    pair, settings = _pair(asked, facts), _bounds(facts, "LOW", "HIGH")
    if pair is None or settings is None:
        return None
    settings |= {"PAIR": keys_of(pair)}
    return _script(asked, facts, "equivalence", conditions_in([pair]), settings, first="estimate")


def _effects(contrast: AskedContrast) -> tuple[tuple[float, tuple[tuple[str, ...], tuple[str, ...]]], ...]:
    """Return the weights and comparisons that a contrast is made of."""
    return tuple((weight, keys_of(pair)) for weight, pair in contrast.terms)


def _contrast(asked: Asked, facts: Facts) -> Script | None:
    """Contrasts of means: estimate, t and p of differences between levels, interactions and trends."""
    contrast = facts.contrasts().get(str(asked.scope["label"]))
    if contrast is None or not contrast.terms:
        return None
    level = 1.0 - facts.planned.settings.alpha
    settings = {"LEVEL": level, "PERCENT": contrast.percent, "EFFECTS": _effects(contrast)}
    conditions = conditions_in([pair for _weight, pair in contrast.terms])
    return _script(asked, facts, "contrast", conditions, settings, first="estimate")


def _overall(asked: Asked, facts: Facts) -> Script | None:
    """The effect over all groups: mean saving, its test, and whether groups saved the same."""
    settings = facts.planned.settings
    about = {"LEVEL": 1.0 - settings.outside, "ONE_SIDED_OVERALL": settings.one_sided}
    if asked.name in ("spread", "heterogeneity_p"):
        return _over_groups(asked, facts, asked.name, about)
    return _over_groups(asked, facts, "overall_savings", about, "savings")


def _overall_equivalence(asked: Asked, facts: Facts) -> Script | None:
    """The equivalence of heights over all groups."""
    settings = _bounds(facts, "LOWEST_CHANGE", "HIGHEST_CHANGE")
    if settings is None:
        return None
    return _over_groups(asked, facts, "overall_equivalence", settings, "estimate")


def _over_groups(asked: Asked, facts: Facts, step: str, about: Settings, first: str | None = None) -> Script | None:
    pooled, adjusted = facts.pooled(asked.outcome), asked.variant == ADJUSTED
    compared = facts.pooled(asked.outcome, ADJUSTED) if adjusted else pooled
    claimed = overall_savings({group_label(pair.group): contrast_of(pair) for pair in compared}).scope.groups
    groups = {group_label(pair.group): keys_of(pair) for pair in pooled}
    settings = {**about, "CLAIMED": {name: pair for name, pair in groups.items() if name in claimed}, "GROUPS": groups}
    wanted = [pair for pair in pooled if adjusted or group_label(pair.group) in claimed]
    steps = ["at_mean_position", step] if adjusted else [step]
    return _script(asked, facts, steps, conditions_in(wanted), settings, first=first)


def _thesis_route(asked: Asked, facts: Facts) -> Script | None:
    """The thesis's own tests of a comparison, over runs: F, then Student's or Welch's t."""
    pair = _pair(asked, facts)
    if pair is None:
        return None
    settings = {"PAIR": keys_of(pair), "ALPHA": facts.planned.settings.alpha}
    return _script(asked, facts, "thesis_route", conditions_in([pair]), settings, first="difference")


def _thesis_route_over_jumps(asked: Asked, facts: Facts) -> Script | None:
    """The same over jumps."""
    script = _thesis_route(asked, facts)
    return script and Script(script.rows, ("heights_of_jumps", *script.steps[1:]), script.settings)


def _anova(asked: Asked, facts: Facts) -> Script | None:
    """F and p of the one-way analysis of variance over the treated levels of a group."""
    groups = {
        group_label(group): pairing.treated_and_control(items)[0]
        for group, items in pairing.groups(facts.conditions(asked.outcome), facts.swept)
    }
    treated = groups.get(str(asked.scope["label"]), ())
    settings = {"CONDITIONS": tuple(one.key for one in treated)}
    return _script(asked, facts, "analysis_of_variance", treated, settings, first="")


def _pack(asked: Asked, facts: Facts) -> Script | None:
    """How far the runs of a battery pack lie from the means of their conditions."""
    settings = {"PACK": asked.scope["pack"]}
    return _script(asked, facts, "pack_deviation", facts.conditions(asked.outcome), settings)


def _hypothesis(asked: Asked, facts: Facts) -> Script | None:
    """What was measured of a hypothesis, and simulated: a change in percent, or of a saving in percentage points."""
    hypothesis = facts.configuration.hypotheses.get(str(asked.scope["hypothesis"]))
    if hypothesis is None or asked.name not in ("measured", "simulated"):
        return None
    several = comparisons_of(hypothesis, facts.conditions(asked.outcome), facts.swept)
    one = next((each for each in several if each.label == asked.scope["label"]), None)
    if one is None:
        return None
    conditions = conditions_in(one.pairs)
    if asked.name == "simulated":
        settings: dict[str, object] = {"COMPARED": tuple(tuple(each.key for each in side) for side in one.sides)}
        return _script(asked, facts, "simulated_change", conditions, settings, simulated=True)
    decided = facts.planned.settings
    as_planned = len(one.pairs) > 1 or hypothesis.claim is ClaimKind.SAVES
    settings = {"LEVEL": 1.0 - (decided.outside if as_planned else 2.0 * decided.alpha)}
    if len(one.pairs) > 1:
        other, own = one.pairs
        settings["EFFECTS"] = ((1.0, keys_of(other)), (-1.0, keys_of(own)))
        return _script(asked, facts, "change_of_saving", conditions, settings)
    settings["PAIR"] = keys_of(one.pairs[0])
    return _script(asked, facts, "change", conditions, settings)


def _budget(asked: Asked, facts: Facts) -> Script | None:
    """What the uncertainty of joules a jump is made of, of one run and of a condition's mean."""
    return _script(asked, facts, "budget", _conditions(asked, facts), first="")


_PREDICTED = {
    "predicted": ("predicted_mean", "predicted_saving"),
    "difference": ("mean_predicted_less_measured", "saving_predicted_less_measured"),
    "error_ratio": ("error_ratio_of_mean", "error_ratio_of_saving"),
    "error": ("error_of_mean_by", "error_of_saving_by"),
}
_PART = "predicted, error by "


def _prediction(asked: Asked, facts: Facts) -> Script | None:
    """Predictions beside what was measured: of a condition's mean, or of a saving."""
    settings: dict[str, object] = {"ERROR_BY": asked.name.removeprefix(_PART)}
    steps = _PREDICTED.get("error" if asked.name.startswith(_PART) else asked.name)
    if steps is None:
        return None
    if "label" not in asked.scope:
        return _script(asked, facts, steps[0], _conditions(asked, facts), settings, simulated=True)
    pair = _pair(asked, facts)
    if pair is None:
        return None
    settings |= {"PAIR": keys_of(pair), "LEVEL": facts.decision_level(asked.outcome)}
    return _script(asked, facts, steps[1], conditions_in([pair]), settings, simulated=True)


_BIAS = {
    **dict.fromkeys(("bias", "p"), "bias"),
    "of_measured": "bias_of_measured",
    "measured": "measured_over_days",
    "predicted": "predicted_over_days",
}
_JOINT = {"p": "joint_p", "tau": "tau_of_groups"}
_LIMITS = ("mean_difference", "lower_limit", "upper_limit")


def _simulated_groups(asked: Asked, facts: Facts) -> dict[str, list[ConditionValues]]:
    """Return the conditions that have a prediction with its error, by their groups."""
    found: dict[str, list[ConditionValues]] = {}
    for one in facts.conditions(asked.outcome):
        if facts.is_simulated(one, asked.outcome, varied=True):
            levels = {factor: level for factor, level in one.levels.items() if factor != facts.swept}
            found.setdefault(group_label(levels), []).append(one)
    return found


def _bias(asked: Asked, facts: Facts) -> Script | None:
    """How far predictions of a group lie from what was measured."""
    group = _simulated_groups(asked, facts).get(str(asked.scope["group"]), [])
    first = "bias" if asked.name == "p" else None
    return _script(asked, facts, _BIAS.get(asked.name), group, first=first, simulated=True)


def _joint_bias(asked: Asked, facts: Facts) -> Script | None:
    """The same of all groups jointly."""
    groups = _simulated_groups(asked, facts)
    settings = {"JUDGED": {label: tuple(one.key for one in group) for label, group in groups.items()}}
    every = [one for group in groups.values() for one in group]
    return _script(asked, facts, _JOINT.get(asked.name), every, settings, simulated=True)


def _limits(asked: Asked, facts: Facts) -> Script | None:
    """Limits of agreement of predicted and measured over conditions."""
    every = [one for one in facts.conditions(asked.outcome) if facts.is_simulated(one, asked.outcome)]
    return _script(asked, facts, asked.name if asked.name in _LIMITS else None, every, simulated=True)


KINDS: Mapping[str, Callable[[Asked, Facts], Script | None]] = {
    "condition_summary": _condition,
    "passive_drain": _drain,
    "decision": _decision,
    "decision_family": _family,
    "decision_equivalence": _equivalence,
    "contrast": _contrast,
    "overall_savings": _overall,
    "overall_equivalence": _overall_equivalence,
    "thesis_route": _thesis_route,
    "thesis_route_over_jumps": _thesis_route_over_jumps,
    "anova": _anova,
    "pack_deviation": _pack,
    "hypothesis": _hypothesis,
    "energy_budget": _budget,
    "prediction_check": _prediction,
    "prediction_bias": _bias,
    "joint_bias": _joint_bias,
    "limits_of_agreement": _limits,
}
"""By the kind of result, as `numbers.json` has it; what a maker returns is None where a number has no script."""
