"""What the simulator gives for a hypothesis: the change of a mean in percent of another, or of a saving in points."""

import math
from collections.abc import Sequence

from labbook.scripts.templates.predictions import errors_by, relative_error, simulated_mean, with_error
from labbook.scripts.templates.runs import Number, Runs, of_conditions

COMPARED: Sequence[Sequence[str]] = ()
"""The conditions of a mean and of what is compared with it; of four, the change of the last two less that of the first
two."""


def change_in_percent(means: Sequence[float]) -> float:
    """Return 100 (B / A - 1) of two means; of four A, B, C, D 100 (B / A - D / C), in percentage points."""
    changes = [100.0 * (other / one - 1.0) for one, other in zip(means[::2], means[1::2], strict=True)]
    return changes[0] if len(changes) == 1 else changes[0] - changes[1]


def simulated_change(runs: Runs) -> Number:
    """Return the simulated change with its standard uncertainty; the simulator errs in each mean by itself."""
    sides = [of_conditions(runs, conditions) for conditions in COMPARED]
    accuracy = math.sqrt(len(sides)) * relative_error(sides) * 100.0
    value = change_in_percent([simulated_mean(side) for side in sides])
    return with_error(value, errors_by(sides, change_in_percent, accuracy))
