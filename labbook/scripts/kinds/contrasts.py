"""Contrasts of means: estimate, t and p of differences between levels, interactions and trends."""

from data_schema.vocabulary import Rule
from labbook.analysis.comparison.contrasts import AskedContrast, contrast_result
from labbook.scripts.facts import Facts, conditions_in, keys_of
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of

_STEPS = {"estimate": "contrasts.contrast", "t": "contrasts.contrast_t", "p": "contrasts.contrast_p"}


def effects_of(contrast: AskedContrast) -> tuple[tuple[float, tuple[tuple[str, ...], tuple[str, ...]]], ...]:
    """Return the weights and comparisons that a contrast is made of."""
    return tuple((weight, keys_of(pair)) for weight, pair in contrast.terms)


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of a contrast of means."""
    contrast = facts.contrasts().get(str(asked.scope["label"]))
    if contrast is None or not contrast.terms or asked.name not in _STEPS:
        return None
    step = _STEPS[asked.name]
    if contrast_result(contrast, facts.swept, facts.planned.settings.alpha).rule is Rule.NONE:
        step = "contrasts.contrast_without_claim"
    settings = {
        **facts.settings,
        "LEVEL": 1.0 - facts.planned.settings.alpha,
        "PERCENT": contrast.percent,
        "EFFECTS": effects_of(contrast),
    }
    rows = rows_of(facts, conditions_in([pair for _weight, pair in contrast.terms]), asked.outcome)
    return Script(rows, (reading_of(asked.outcome), step), settings)
