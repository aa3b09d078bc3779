"""The compiled program that a stance is timed beside comes to the same jump by forces of its own."""

from __future__ import annotations

import pytest

from benchmarks.compiled_peer import PEER
from simulator.accuracy.methods import relative_errors
from simulator.accuracy.reference_of import stored_reference
from simulator.kernel.limits import STOP_AFTER_LIFTOFF
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

SCENE = load_scene("sim2")


def largest_error(rtol: float) -> float:
    attempt, reference = PEER.prepare(SCENE, rtol, STOP_AFTER_LIFTOFF), stored_reference(SCENE)
    attempt.run()
    assert reference is not None
    errors = relative_errors(attempt.found(), reference.values)
    return max(errors[name] or 0.0 for name in ("max_depth_m", "liftoff_time_s", "cost_J"))


def test_it_meets_the_stored_stance_the_better_the_finer_its_steps() -> None:
    coarse, fine = (interpreted(largest_error, rtol) for rtol in (1e-5, 1e-10))
    assert fine < 1e-9 < coarse < 1e-4


def test_what_it_knows_nothing_of_is_refused() -> None:
    with pytest.raises(ValueError, match="active damping"):
        PEER.prepare(SCENE.changed({"b_ad": 100.0}), 1e-6, STOP_AFTER_LIFTOFF)
