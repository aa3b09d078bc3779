"""Predictions beside what was measured: of conditions' means, and of savings."""

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Rule
from labbook.analysis.comparison.deciding import contrast_of
from labbook.scripts.facts import Facts, conditions_in, keys_of
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_with_simulated

_OF_MEAN = {
    "predicted": "predictions.predicted_mean",
    "difference": "predictions.mean_predicted_less_measured",
    "error_ratio": "predictions.error_ratio_of_mean",
}
_OF_SAVING = {
    "predicted": "predictions.predicted_saving",
    "difference": "predictions.saving_predicted_less_measured",
    "error_ratio": "predictions.error_ratio_of_saving",
}
_PART = "predicted, error by "


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of a prediction."""
    settings = {**facts.settings, "ERROR_BY": asked.name.removeprefix(_PART)}
    if "label" not in asked.scope:
        step = "predictions.error_of_mean_by" if asked.name.startswith(_PART) else _OF_MEAN.get(asked.name)
        found = [one for one in facts.conditions(asked.outcome) if one.key == asked.scope["condition"]]
        if step is None or not found:
            return None
        return Script(rows_with_simulated(facts, found, asked.outcome), (reading_of(asked.outcome), step), settings)
    outcome = Outcome.JOULES
    step = "predictions.error_of_saving_by" if asked.name.startswith(_PART) else _OF_SAVING.get(asked.name)
    pair = next((one for one in facts.pairs(outcome) if one.label == asked.scope["label"]), None)
    if step is None or pair is None:
        return None
    if asked.name == "difference" and contrast_of(pair).rule is Rule.NONE:
        step = f"{step}_without_claim"
    settings |= {"PAIR": keys_of(pair), "LEVEL": facts.decision_level(outcome)}
    return Script(rows_with_simulated(facts, conditions_in([pair]), outcome), (reading_of(outcome), step), settings)
