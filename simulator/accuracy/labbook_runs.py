"""The kernel called as bare as it can be: arrays allocated once, one row read afterwards."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from simulator.jump import limits_for, parameter_row
from simulator.kernel.build import kernel_for
from simulator.kernel.limits import JUMPS_WANTED, STOP_AFTER_TOUCHDOWN
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.scene import Scene

Row = NDArray[np.float64]


class KernelRun:
    """A scene's kernel with everything it needs; `run()` simulates, `row()` is that of the last jump made."""

    def __init__(
        self,
        scene: Scene,
        accuracy: float,
        stop_after: int = STOP_AFTER_TOUCHDOWN,
        *,
        fixed_step_s: float = 0.0,
        parameters: Row | None = None,
    ) -> None:
        """Prepare `scene.jumps` jumps; `parameters`, in the order that the kernel reads, stand in for the scene's."""
        self.kernel = kernel = kernel_for(scene.effects)
        table = (parameter_row(kernel, scene) if parameters is None else parameters)[np.newaxis, :]
        limits = limits_for(accuracy, stop_after, fixed_step_s)
        limits[JUMPS_WANTED] = scene.jumps
        self._rows = np.zeros((1, scene.jumps, len(COLUMNS)))
        self._counts = np.zeros(1, np.int64)
        changes, trace = np.zeros((0, 4)), np.zeros((0, 0))
        arguments = (table, limits, self._rows, self._counts, changes, trace)
        self.run: Callable[[], None] = lambda: kernel.batch(*arguments)

    @property
    def jumps_made(self) -> int:
        """How many jumps were made."""
        return int(self._counts[0])

    def row(self) -> Row:
        """Return the row of the last jump that was made, shape (columns,)."""
        last: Row = self._rows[0, self.jumps_made - 1]
        return last

    def evaluations(self) -> int:
        """Return how often the forces were evaluated, over all jumps."""
        return int(self._rows[0, : self.jumps_made, COLUMN["rhs_evaluations"]].sum())

    def steps(self) -> int:
        """Return how many steps were taken, over all jumps."""
        return int(self._rows[0, : self.jumps_made, COLUMN["steps"]].sum())

    def time_s(self) -> float:
        """Return how long all jumps took the robot, s."""
        return float(self._rows[0, : self.jumps_made, COLUMN["jump_time_s"]].sum())
