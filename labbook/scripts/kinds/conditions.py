"""Mean of a condition, with its interval, and the standard deviation of its runs."""

from labbook.scripts.facts import Facts
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of

_STEPS = {"mean": "condition.condition_mean", "sd": "condition.condition_sd"}


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a condition's number."""
    found = [one for one in facts.conditions(asked.outcome, asked.variant) if one.key == asked.scope["condition"]]
    if asked.name not in _STEPS or not found:
        return None
    rows = rows_of(facts, found, asked.outcome, asked.variant)
    return Script(rows, (reading_of(asked.outcome), _STEPS[asked.name]), facts.settings)
