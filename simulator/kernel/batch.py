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

Row = NDArray[np.float64]
Counts = NDArray[np.int64]
GROWTH_LET_PASS = 3.0
"""Growth of an error that is within what the tolerance has to spare."""


def make_batch(composition: Composition) -> Function:
    """Compose `(table, limits, rows, counts, changes, trace)`.

    `table`, shape (n, declared parameters); `rows`, shape (n, jumps, columns) and `counts`, shape (n,), receive the
    results and how many jumps there are. `changes` and `trace` (see `make_run`) are those of the last scene.

    Where the sampled control lets errors grow (`make_growth`), the scene is simulated again with steps as much finer.
    """
    run = make_run(composition)
    declared, places = len(composition.parameters), composition.row_size
    grown, evaluations = COLUMN["error_growth"], COLUMN["rhs_evaluations"]

    @compiled
    def batch(table: Row, limits: Row, rows: Row, counts: Counts, changes: Row, trace: Row) -> None:
        work, finer = np.zeros(places), limits.copy()
        for scene in range(table.shape[0]):
            for i in range(declared):
                work[PARAMETERS + i] = table[scene, i]
            result = rows[scene]
            counts[scene] = run(work, limits, result, changes, trace)
            growth = result[0, grown]
            if growth > GROWTH_LET_PASS and limits[TOLERANCE] > FINEST_TOLERANCE:
                spent = result[0, evaluations]
                finer[TOLERANCE] = max(limits[TOLERANCE] / growth, FINEST_TOLERANCE)
                changes[:, :] = -1.0
                trace[:, 1] = 0.0
                counts[scene] = run(work, finer, result, changes, trace)
                result[0, evaluations] += spent

    return batch
