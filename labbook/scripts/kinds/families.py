"""Holm's adjusted p of a test among those of its family."""

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.contrasts import contrast_result
from labbook.analysis.comparison.deciding import decide_pair
from labbook.scripts.facts import Facts, conditions_in, keys_of
from labbook.scripts.kinds.contrasts import effects_of
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of

_HEAD = "adjusted_p, "


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of an adjusted p."""
    if not asked.name.startswith(_HEAD):
        return None
    label = asked.name.removeprefix(_HEAD)
    return _of_contrasts(label, facts) if asked.scope["family"] == "contrasts" else _of_pairs(label, asked, facts)


def _of_pairs(label: str, asked: Asked, facts: Facts) -> Script | None:
    outcome, settings = asked.outcome, facts.planned.settings
    several = [*facts.conditions(outcome), *facts.conditions_beside(outcome)]
    pairs = [pair for pair in pairing.pairs_with_control(several, facts.swept) if pair.family == asked.scope["family"]]
    tested = [pair for pair in pairs if not isinstance(decide_pair(pair, outcome, settings).p.value, Undefined)]
    values = {
        **facts.settings,
        "LEVEL": facts.decision_level(outcome),
        "ONE_SIDED": settings.one_sided and outcome.has_savings,
        "TESTS": {pair.label: keys_of(pair) for pair in tested},
        "ASKED": label,
        "WITHOUT_P": len(pairs) - len(tested),
    }
    rows = rows_of(facts, conditions_in(tested), outcome)
    return Script(rows, (reading_of(outcome), "holm.adjusted_p"), values)


def _of_contrasts(label: str, facts: Facts) -> Script | None:
    alpha, every = facts.planned.settings.alpha, facts.contrasts()
    tested = {
        name: one
        for name, one in every.items()
        if not isinstance(contrast_result(one, facts.swept, alpha).p.value, Undefined)
    }
    outcomes = {one.settings.outcome for one in tested.values()}
    if len(outcomes) != 1:  # values of one table have one unit
        return None
    outcome: Outcome = outcomes.pop()
    values = {
        **facts.settings,
        "LEVEL": 1.0 - alpha,
        "CONTRASTS": {name: (one.percent, effects_of(one)) for name, one in tested.items()},
        "ASKED": label,
        "WITHOUT_P": len(every) - len(tested),
    }
    rows = rows_of(facts, conditions_in([pair for one in tested.values() for _weight, pair in one.terms]), outcome)
    return Script(rows, (reading_of(outcome), "holm.adjusted_p_of_contrast"), values)
