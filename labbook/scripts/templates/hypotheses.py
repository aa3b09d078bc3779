"""What was measured of a hypothesis: the change of a mean in percent of another, or of a saving in points."""

from collections.abc import Mapping

from labbook.scripts.templates.contrasts import EFFECTS, contrast_of
from labbook.scripts.templates.days import PAIR, compare, saving_of
from labbook.scripts.templates.runs import Number, Runs


def as_change(saving: Mapping[str, float]) -> Number:
    """Return a change, which is less a saving, with its interval where there is one."""
    if "ci_low" not in saving:
        return {"value": -saving["value"]}
    return {
        **saving,
        "value": -saving["value"],
        "ci_low": -saving["ci_high"],
        "ci_high": -saving["ci_low"],
    }


def change(runs: Runs) -> Number:
    """Return the change of the second mean in percent of the first."""
    return as_change(saving_of(compare(runs, PAIR)))


def change_of_saving(runs: Runs) -> Number:
    """Return the last saving less the first in percentage points."""
    found = contrast_of(runs, EFFECTS, percent=True)
    return as_change({name: found[name] for name in ("value", "se", "shared_se", "ci_low", "ci_high", "df")})
