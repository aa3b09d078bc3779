"""The test that decides a comparison with a control: difference, saving, t, p, mean of the control, SD of runs."""

from data_schema.vocabulary import Rule
from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.comparison.order import ADJUSTED
from labbook.analysis.comparison.pairing import Pair
from labbook.scripts.facts import Facts, conditions_in, keys_of
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of

_ALWAYS = {"difference": "days.difference_of_means", "savings": "days.savings", "control_mean": "days.mean_of_control"}
_TESTED = {"p": "days.p_of_difference", "run_sd": "days.run_sd"}


def pair_of(asked: Asked, facts: Facts) -> Pair | None:
    """Return the comparison that a number is of."""
    pairs = facts.pairs(asked.outcome, asked.variant)
    return next(
        (pair for pair in pairs if (pair.family, pair.label) == (asked.scope["family"], asked.scope["label"])), None
    )


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of the deciding test."""
    pair, outcome = pair_of(asked, facts), asked.outcome
    steps = {**_ALWAYS, **_TESTED, "t": "days.t_of_saving" if outcome.has_savings else "days.t_of_difference"}
    if pair is None or asked.name not in steps:
        return None
    step = steps[asked.name]
    if asked.name in _ALWAYS and contrast_of(pair).rule is Rule.NONE:
        step = f"{step}_without_claim"
    settings = {
        **facts.settings,
        "PAIR": keys_of(pair),
        "LEVEL": facts.decision_level(outcome),
        "ONE_SIDED": facts.planned.settings.one_sided and outcome.has_savings,
    }
    if asked.variant != ADJUSTED:
        rows = rows_of(facts, conditions_in([pair]), outcome, asked.variant)
        return Script(rows, (reading_of(outcome), step), settings)
    pooled = facts.pooled(outcome)
    rows = rows_of(facts, conditions_in(pooled), outcome)
    groups = {each.label.partition(":")[0]: keys_of(each) for each in pooled}
    return Script(rows, (reading_of(outcome), "position.at_mean_position", step), {**settings, "GROUPS": groups})
