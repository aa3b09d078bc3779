"""The kernel's one entry from Python: a scene simulated for each row of a table of parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Function, Row, compiled, inner
from simulator.kernel.composition import Composition
from simulator.kernel.layout import PARAMETERS, STEP_LIMIT
from simulator.kernel.limits import FINEST_TOLERANCE, FIXED_STEP_S, REPEATS, TOLERANCE, TOLERANCE_SHARE
from simulator.kernel.rows import COLUMN
from simulator.kernel.run import make_run
from simulator.kernel.working_row import address_of

Counts = NDArray[np.int64]
GROWTH_LET_PASS = 3.0
"""Growth of an error that is within what the tolerance has to spare."""
SPARED = 3.0
"""Where a book does not close, steps are made finer by this much more than it takes if errors follow the tolerance; by
its square where it does not close again, and so on: steps that something else limits change at a far finer one only."""
GROWTH_LOST = 1e15
"""Growth by which rounding alone decides the jump: no step is fine enough."""


def make_tolerance_called_for(composition: Composition) -> Function:
    """Compose `(limits, finer, result, count, repeat)`: the local error that a scene is to be simulated with again.

    `finer` are the limits of the last time, whose `count` jumps `result` holds; their tolerance where that was enough.
    """
    grown, ended = COLUMN["error_growth"], COLUMN["outcome"]
    residual, at_play = COLUMN["energy_residual_J"], COLUMN["energy_at_play_J"]

    @inner
    def tolerance_called_for(limits: Row, finer: Row, result: Row, count: int, repeat: int) -> float:
        growth, excess = 1.0, 0.0
        for jump in range(count):
            growth = max(growth, result[jump, grown])
            if result[jump, ended] != STEP_LIMIT:
                excess = max(excess, abs(result[jump, residual]) / result[jump, at_play])
        excess *= TOLERANCE_SHARE / limits[TOLERANCE]
        called_for = finer[TOLERANCE]
        if limits[FIXED_STEP_S] > 0.0:
            return called_for
        if growth < GROWTH_LOST and growth * finer[TOLERANCE] > GROWTH_LET_PASS * limits[TOLERANCE]:
            called_for = limits[TOLERANCE] / growth
        if excess > 1.0:
            called_for = min(called_for, finer[TOLERANCE] / (SPARED ** (repeat + 1) * excess))
        return max(called_for, min(FINEST_TOLERANCE, finer[TOLERANCE]))

    return tolerance_called_for


def make_repeat_finer(composition: Composition) -> Function:
    """Compose `(work, limits, finer, result, count, changes, trace)`: simulate a scene again where that is called for.

    `finer` is where its limits are put together, `result` holds its `count` jumps. Returns how many there are at last.
    """
    run, tolerance_called_for = make_run(composition), make_tolerance_called_for(composition)
    evaluations, repeats = COLUMN["rhs_evaluations"], COLUMN["repeats"]

    @inner
    def repeat_finer(work: Row, limits: Row, finer: Row, result: Row, count: int, changes: Row, trace: Row) -> int:
        finer[TOLERANCE] = limits[TOLERANCE]
        result[:count, repeats] = 0.0
        for repeat in range(int(limits[REPEATS])):
            called_for = tolerance_called_for(limits, finer, result, count, repeat)
            if called_for == finer[TOLERANCE]:
                break
            finer[TOLERANCE], spent = called_for, result[0, evaluations]
            changes[:, :] = -1.0
            if trace.shape[0] > 0:
                trace[:, 1] = 0.0
            result[:, :] = np.nan
            count = run(work, address_of(finer), result, changes, trace)
            result[0, evaluations] += spent
            result[:count, repeats] = repeat + 1.0
        return count

    return repeat_finer


def make_batch(composition: Composition) -> Function:
    """Compose `(table, limits, rows, counts, changes, trace)`.

    `table`, shape (n, declared parameters); `rows`, shape (n, jumps, columns) and `counts`, shape (n,), receive the
    results and how many jumps there are. `changes` and `trace` (see `make_run`) are those of the last scene.

    A scene is simulated again with finer steps where errors grow (`make_growth`, `make_begin_jump`), and where
    the energy book of a jump does not close within the accuracy; and again, where the finer one turns out no better.
    The rows are those of the last time, and say how often it was.
    """
    run, repeat_finer = make_run(composition), make_repeat_finer(composition)
    declared, places = len(composition.parameters), composition.row_size

    @compiled
    def batch(table: Row, limits: Row, rows: Row, counts: Counts, changes: Row, trace: Row) -> None:
        storage, finer = np.zeros(places), limits.copy()
        work = address_of(storage)
        for scene in range(table.shape[0]):
            for i in range(declared):
                work[PARAMETERS + i] = table[scene, i]
            result = rows[scene]
            counts[scene] = run(work, address_of(limits), result, changes, trace)
            counts[scene] = repeat_finer(work, limits, finer, result, counts[scene], changes, trace)
        storage[0] = 0.0  # until here: compiled code frees an array after its last use

    return batch
