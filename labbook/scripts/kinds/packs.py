"""How far the runs of a battery pack lie from the means of their conditions."""

from data_schema.outcomes import Outcome
from labbook.scripts.facts import Facts
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a pack's deviation."""
    rows = rows_of(facts, facts.conditions(Outcome.JOULES), Outcome.JOULES)
    settings = {**facts.settings, "PACK": asked.scope["pack"]}
    return Script(rows, (reading_of(Outcome.JOULES), "packs.pack_deviation"), settings)
