"""Many scenes in the lanes of two blocks, one of feet in the ground and one of feet in the air.

A lane's working row is copied into a block, steps there beside the others, and goes back where something may happen:
the scalar kernel takes that step, and goes on until the lane can be taken into a block again or its jumps are done. The
next scene then takes its place. No lane sees its neighbours: neither their number nor their order changes a bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Function, Row, compiled, inner
from simulator.kernel.batch import make_repeat_finer
from simulator.kernel.composition import Composition
from simulator.kernel.events.contact import GOES_ON
from simulator.kernel.events.guards import make_guards
from simulator.kernel.lanes.numbers import make_lanes_of
from simulator.kernel.lanes.step import make_step
from simulator.kernel.layout import (
    FLIGHT,
    GUARDS_BEFORE,
    INTRUDING,
    K1,
    MODE,
    NEAR,
    NOW,
    PARAMETERS,
    PERSISTENT,
    STALE,
    TIME,
)
from simulator.kernel.run import make_begin_scene, make_jump_loop
from simulator.kernel.working_row import address_of

Counts = NDArray[np.int64]
LANES = 8
"""Lanes of a block: two registers of four numbers each hide one another's latency."""


def make_batch_in_lanes(composition: Composition, lanes: int = LANES) -> Function:
    """Compose `(table, limits, rows, counts, changes, trace)`: what `make_batch` composes, to the same bits.

    There is no place for `changes` and `trace`: their shape is (0, 4).
    """
    begin_scene, jump_loop = make_begin_scene(composition), make_jump_loop(composition)
    repeat_finer, guards = make_repeat_finer(composition), make_guards(composition)
    in_ground, in_air = make_step(composition, INTRUDING), make_step(composition, FLIGHT)
    lanes_of: Any = make_lanes_of(lanes)
    declared, places, size = len(composition.parameters), composition.row_size, composition.state_size
    slots = 3 * lanes

    @inner
    def enter(row: Row, block: Row, lane: int) -> None:
        for i in range(PERSISTENT):
            block[i, lane] = row[i]
        for i in range(size):
            block[NOW + i, lane] = row[NOW + i]
        for i in range(NEAR, places):
            block[i, lane] = row[i]

    @inner
    def leave(row: Row, block: Row, lane: int) -> None:
        for i in range(PERSISTENT):
            row[i] = block[i, lane]
        for i in range(size):
            row[NOW + i] = block[NOW + i, lane]
        if row[STALE] == 0.0:  # what the scalar kernel would know of the start of its step
            for i in range(size):
                row[K1 + i] = block[K1 + i, lane]
            guards(row[TIME], row, NOW, GUARDS_BEFORE)

    @compiled
    def batch(table: Row, limits: Row, rows: Row, counts: Counts, changes: Row, trace: Row) -> None:
        work, finer = np.zeros((slots, places)), limits.copy()
        scene_in, jump_in = np.zeros(slots, np.int64), np.zeros(slots, np.int64)
        free, frees, scene = np.arange(slots), slots, 0
        # by block, 0 in the ground, 1 in the air: lanes, whether and by which slot each is occupied, who waits
        blocks, occupied, slot_in = np.zeros((2, places, lanes)), np.zeros((2, lanes)), np.zeros((2, lanes), np.int64)
        used, waiting, waits = np.zeros(2, np.int64), np.zeros((2, slots), np.int64), np.zeros(2, np.int64)
        ground, air, occupied_by = lanes_of(blocks[0]), lanes_of(blocks[1]), lanes_of(occupied)
        while True:
            while waits[0] + used[0] < lanes and scene < table.shape[0] and frees > 0:
                frees -= 1
                slot, row = free[frees], address_of(work[free[frees]])
                for i in range(declared):
                    row[PARAMETERS + i] = table[scene, i]
                outcome = begin_scene(row, address_of(limits))
                found = jump_loop(row, address_of(limits), rows[scene], changes, trace, 0, False, outcome, True)
                if found < 0:
                    scene_in[slot], jump_in[slot], block = scene, -1 - found, int(row[MODE] == FLIGHT)
                    waiting[block, waits[block]] = slot
                    waits[block] += 1
                else:
                    counts[scene] = repeat_finer(row, limits, finer, rows[scene], found, changes, trace)
                    frees += 1
                scene += 1
            block = 1 if waits[1] + used[1] >= lanes or waits[0] + used[0] == 0 else 0
            if waits[block] + used[block] == 0:
                break
            for lane in range(lanes):
                if waits[block] > 0 and occupied[block, lane] == 0.0:
                    waits[block] -= 1
                    slot_in[block, lane] = waiting[block, waits[block]]
                    enter(address_of(work[slot_in[block, lane]]), blocks[block], lane)
                    occupied[block, lane] = 1.0
                    used[block] += 1
            leaving = in_ground(occupied_by[0], ground) if block == 0 else in_air(occupied_by[1], air)
            for lane in range(lanes if leaving != 0 else 0):
                if leaving >> lane & 1:
                    slot, row = slot_in[block, lane], address_of(work[slot_in[block, lane]])
                    result = rows[scene_in[slot]]
                    leave(row, blocks[block], lane)
                    found = jump_loop(
                        row, address_of(limits), result, changes, trace, jump_in[slot], True, GOES_ON, True
                    )
                    jump_in[slot], after = -1 - found, int(row[MODE] == FLIGHT)
                    if found < 0 and after == block:
                        enter(row, blocks[block], lane)
                        continue
                    occupied[block, lane] = 0.0
                    used[block] -= 1
                    if found < 0:
                        waiting[after, waits[after]] = slot
                        waits[after] += 1
                    else:
                        counts[scene_in[slot]] = repeat_finer(row, limits, finer, result, found, changes, trace)
                        free[frees] = slot
                        frees += 1
        work[0, 0], blocks[0, 0, 0], occupied[0, 0] = 0.0, 0.0, 0.0  # until here: arrays outlive their addresses

    return batch
