"""Two one-sided tests that apex heights changed within bounds, of one comparison."""

import math

from labbook.scripts.facts import Facts, conditions_in, keys_of
from labbook.scripts.kinds.decisions import pair_of
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of

_NUMBERS = ("estimate", "t_low", "p_low", "t_high", "p_high", "p")


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of an equivalence test."""
    pair, bounds = pair_of(asked, facts), facts.planned.settings.apex_bounds
    if pair is None or bounds is None or asked.name not in _NUMBERS:
        return None
    settings = {
        **facts.settings,
        "PAIR": keys_of(pair),
        "LEVEL": 1.0 - 2.0 * facts.planned.settings.alpha,
        "LOW": -math.inf if bounds.low is None else bounds.low,
        "HIGH": math.inf if bounds.high is None else bounds.high,
        "IN_PERCENT": bounds.percent,
    }
    step = "p_of_both" if asked.name == "p" else asked.name
    rows = rows_of(facts, conditions_in([pair]), asked.outcome)
    return Script(rows, (reading_of(asked.outcome), f"equivalence.{step}"), settings)
