"""The kernel's one entry from Python: a scene simulated for each row of a table of parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import compiled
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.layout import PARAMETERS
from simulator.kernel.limits import FINEST_TOLERANCE, TOLERANCE
from simulator.kernel.rows import COLUMN
from simulator.kernel.run import make_run
from simulator.kernel.working_row import address_of

Row = NDArray[np.float64]
Counts = NDArray[np.int64]
GROWTH_LET_PASS = 3.0
"""Growth of an error that is within what the tolerance has to spare."""
MOST_REPEATS = 5
GROWTH_LOST = 1e15
"""Growth by which rounding alone decides the jump: no step is fine enough."""


def make_batch(composition: Composition) -> Function:
    """Compose `(table, limits, rows, counts, changes, trace)`.

    `table`, shape (n, declared parameters); `rows`, shape (n, jumps, columns) and `counts`, shape (n,), receive the
    results and how many jumps there are. `changes` and `trace` (see `make_run`) are those of the last scene.

    Where the sampled control lets errors grow (`make_growth`), the scene is simulated again with steps as much finer,
    and again where the finer jump turns out to let them grow more.
    """
    run = make_run(composition)
    declared, places = len(composition.parameters), composition.row_size
    grown, evaluations = COLUMN["error_growth"], COLUMN["rhs_evaluations"]

    @compiled
    def batch(table: Row, limits: Row, rows: Row, counts: Counts, changes: Row, trace: Row) -> None:
        kept, finer = np.zeros(places), limits.copy()
        work = address_of(kept)
        for scene in range(table.shape[0]):
            for i in range(declared):
                work[PARAMETERS + i] = table[scene, i]
            result = rows[scene]
            finer[TOLERANCE] = limits[TOLERANCE]
            counts[scene] = run(work, address_of(finer), result, changes, trace)
            for _ in range(MOST_REPEATS):
                growth, spent = 1.0, result[0, evaluations]
                for jump in range(counts[scene]):
                    growth = max(growth, result[jump, grown])
                let_pass = GROWTH_LET_PASS * limits[TOLERANCE] / finer[TOLERANCE]
                if growth <= let_pass or growth > GROWTH_LOST or finer[TOLERANCE] <= FINEST_TOLERANCE:
                    break
                finer[TOLERANCE] = max(limits[TOLERANCE] / growth, FINEST_TOLERANCE)
                changes[:, :] = -1.0
                trace[:, 1] = 0.0
                counts[scene] = run(work, address_of(finer), result, changes, trace)
                result[0, evaluations] += spent
        kept[0] = 0.0  # until here: compiled code frees an array after its last use

    return batch
