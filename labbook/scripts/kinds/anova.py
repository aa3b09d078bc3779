"""F and p of the one-way analysis of variance over the treated levels of a group."""

from labbook.analysis.comparison import pairing
from labbook.scripts.facts import Facts
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of

_STEPS = {"f": "anova.anova_f", "p": "anova.anova_p"}


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of an analysis of variance."""
    groups = {
        pairing.group_label(group): pairing.treated_and_control(items)[0]
        for group, items in pairing.groups(facts.conditions(asked.outcome), facts.swept)
    }
    treated = groups.get(str(asked.scope["label"]))
    if treated is None or asked.name not in _STEPS:
        return None
    settings = {**facts.settings, "CONDITIONS": tuple(one.key for one in treated)}
    rows = rows_of(facts, treated, asked.outcome)
    return Script(rows, (reading_of(asked.outcome), _STEPS[asked.name]), settings)
