"""What the uncertainty of joules a jump is made of, of one run and of a condition's mean."""

from data_schema.outcomes import Outcome
from labbook.scripts.facts import Facts
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of
from reports.content import IN_ALL

_STEPS = {
    "scatter between runs": "budget.run_by_scatter",
    "drain fit": "budget.run_by_drain",
    "charger resolution": "budget.run_by_step",
    "reference voltage": "budget.of_voltage",
    IN_ALL: "budget.run_in_all",
    "scatter between runs, mean": "budget.mean_by_scatter",
    "drain fit, mean": "budget.mean_by_drain",
    "charger resolution, mean": "budget.mean_by_step",
    "reference voltage, mean": "budget.of_voltage",
    f"{IN_ALL}, mean": "budget.mean_in_all",
    "1 mAh": "budget.one_mah",
}


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of the budget."""
    found = [one for one in facts.conditions(Outcome.JOULES) if one.key == asked.scope["condition"]]
    if asked.name not in _STEPS or not found:
        return None
    rows = rows_of(facts, found, Outcome.JOULES)
    return Script(rows, (reading_of(Outcome.JOULES), _STEPS[asked.name]), facts.settings)
