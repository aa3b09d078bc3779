"""What was measured of a hypothesis, and simulated: a change in percent, or of a saving in percentage points."""

from data_schema.vocabulary import Rule
from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.prediction.hypotheses import comparisons_of
from labbook.config.model import ClaimKind
from labbook.scripts.facts import Facts, conditions_in, keys_of
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of, rows_with_simulated


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of what was measured, or simulated, of one comparison of a hypothesis."""
    hypothesis = facts.configuration.hypotheses.get(str(asked.scope["hypothesis"]))
    if hypothesis is None or asked.name not in ("measured", "simulated"):
        return None
    several = comparisons_of(hypothesis, facts.conditions(asked.outcome), facts.swept)
    one = next((each for each in several if each.label == asked.scope["label"]), None)
    if one is None:
        return None
    if asked.name == "simulated":
        compared = tuple(tuple(condition.key for condition in side) for side in one.sides)
        rows = rows_with_simulated(facts, conditions_in(one.pairs), asked.outcome)
        settings = {**facts.settings, "COMPARED": compared}
        return Script(rows, (reading_of(asked.outcome), "simulated_changes.simulated_change"), settings)
    decided, pairs = facts.planned.settings, one.pairs
    as_planned = len(pairs) > 1 or hypothesis.claim is ClaimKind.SAVES
    settings = {**facts.settings, "LEVEL": 1.0 - (decided.outside if as_planned else 2.0 * decided.alpha)}
    if len(pairs) > 1:
        other, own = pairs
        settings["EFFECTS"] = ((1.0, keys_of(other)), (-1.0, keys_of(own)))
        step = "hypotheses.change_of_saving"
    else:
        settings["PAIR"] = keys_of(pairs[0])
        none = contrast_of(pairs[0]).rule is Rule.NONE
        step = "hypotheses.change_without_claim" if none else "hypotheses.change"
    rows = rows_of(facts, conditions_in(pairs), asked.outcome)
    return Script(rows, (reading_of(asked.outcome), step), settings)
