from __future__ import annotations

import math
from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from simulator.ablation.outputs import Outputs, difference

FULL = Outputs("touchdown", 1, 30.0, 0.3, 0.07, 1000, False, 100)


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_changes_are_relative_and_signed(cost: float, apex: float, depth: float) -> None:
    found = replace(
        FULL,
        cost_J=FULL.cost_J * (1.0 + cost),
        apex_height_m=(FULL.apex_height_m or 0.0) * (1.0 + apex),
        max_depth_m=FULL.max_depth_m * (1.0 + depth),
    )
    changed = difference(found, FULL)
    for change, expected in zip(changed.changes, (cost, apex, depth), strict=True):
        assert not isinstance(change, Undefined)
        assert math.isclose(change, expected, rel_tol=1e-9, abs_tol=1e-15)
    assert changed.within(changed.largest)
    assert not changed.within(0.99 * changed.largest) or changed.largest == 0.0


def test_a_jump_that_ends_otherwise_is_not_compared() -> None:
    for found, reason in (
        (replace(FULL, outcome="leg_folded"), "leg_folded"),
        (replace(FULL, outcome="leg_straight", jumps=2), "leg_straight in jump 2"),
    ):
        changed = difference(found, FULL)
        assert changed.changes == (Undefined(Reason.SIMULATED_ENDED, ended=reason),) * 3
        assert not changed.within(1e300)


def test_what_neither_has_does_not_differ() -> None:
    still = replace(FULL, apex_height_m=None, max_depth_m=0.0)
    assert difference(still, still).changes == (0.0, 0.0, 0.0)
    changed = difference(replace(still, max_depth_m=0.01, apex_height_m=0.3), still)
    assert changed.apex == Undefined(Reason.NO_OUTPUT_WITH, output="apex")
    assert changed.depth == Undefined(Reason.FULL_SCENE_ZERO, output="depth")
    assert changed.cost == 0.0


def test_a_negative_cost_that_grows_more_negative_has_fallen() -> None:
    changed = difference(replace(FULL, cost_J=-3.0), replace(FULL, cost_J=-2.0))
    assert changed.cost == -0.5
