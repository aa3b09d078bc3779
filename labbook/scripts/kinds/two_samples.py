"""The thesis's own tests of a comparison, over runs or over jumps: F, then Student's or Welch's t."""

from labbook.scripts.facts import Facts, conditions_in, keys_of
from labbook.scripts.kinds.decisions import pair_of
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of

_STEPS = {
    "f": "two_samples.f_of_variances",
    "f_p": "two_samples.p_of_variances",
    "t": "two_samples.t_of_samples",
    "p": "two_samples.p_of_samples",
    "difference": "two_samples.difference_of_samples",
}


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of the tests over runs."""
    return _script(asked, facts, reading_of(asked.outcome))


def script_over_jumps(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of the tests over jumps."""
    return _script(asked, facts, "heights.heights_of_jumps")


def _script(asked: Asked, facts: Facts, reading: str) -> Script | None:
    pair = pair_of(asked, facts)
    if pair is None or asked.name not in _STEPS:
        return None
    settings = {**facts.settings, "PAIR": keys_of(pair), "ALPHA": facts.planned.settings.alpha}
    rows = rows_of(facts, conditions_in([pair]), asked.outcome)
    return Script(rows, (reading, _STEPS[asked.name]), settings)
