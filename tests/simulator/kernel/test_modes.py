"""The graph of contact modes: only its edges are taken, in order, whatever the scene."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.declared import all_parameters
from simulator.jump import simulate
from simulator.kernel.layout import MODES
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.scenes import scene_or_sentence

GRAINS = {
    ("flight", "intruding"),
    ("flight", "jammed"),
    ("intruding", "jammed"),
    ("intruding", "creeping"),
    ("intruding", "flight"),
    ("jammed", "intruding"),
    ("jammed", "creeping"),
    ("jammed", "flight"),
    ("creeping", "jammed"),
    ("creeping", "intruding"),
    ("creeping", "flight"),
}
"""A foot that stops may be lifted at once; one that creeps may be left alone by a tick, or let go."""
PLATE = {("flight", "jammed"), ("jammed", "flight")}
PLATFORM = {
    ("flight", "intruding"),
    ("flight", "jammed"),
    ("flight", "carried"),
    ("intruding", "jammed"),
    ("intruding", "flight"),
    ("jammed", "intruding"),
    ("jammed", "flight"),
    ("jammed", "carried"),
    ("carried", "jammed"),
    ("carried", "flight"),
    ("carried", "intruding"),
}
EDGES = {"bed": GRAINS, "sim1": GRAINS, "sim2": GRAINS, "emulator": PLATFORM, "force_plate": PLATE}
VARIED = {
    "bed": ("k_extension", "foot_radius", "kg_scale", "b_ad", "initial_height", "b_extension"),
    "sim1": ("k_extension", "foot_radius", "kg_scale", "initial_velocity", "rho"),
    "sim2": ("k_extension", "foot_radius", "kg_scale", "b_ad", "initial_velocity", "foot_mass"),
    "emulator": ("k_extension", "k_compression", "b_ad", "platform_stiffness", "platform_damping", "reset_time"),
    "force_plate": ("k_extension", "k_compression", "b_compression", "b_extension", "foot_mass"),
}
CASES = {name: load_scene(name).changed({"b_ad": 0.0} if name == "sim1" else {}) for name in EDGES}


def near(name: str) -> st.SearchStrategy[dict[str, float]]:
    """A scene's varied values from a quarter of the shipped ones to four times, in their boxes."""
    scene = CASES[name]
    found: dict[str, st.SearchStrategy[float]] = {}
    for parameter in VARIED[name]:
        box, shipped = all_parameters()[parameter], scene[parameter]
        if parameter == "b_ad":
            found[parameter] = st.floats(0.0, 150.0)
        else:
            low, high = sorted((max(0.25 * shipped, -3.0), min(4.0 * shipped, box.high)))
            found[parameter] = st.floats(max(low, box.low), min(high, box.high))
    return st.fixed_dictionaries(found)


def assert_walks_the_graph(scene: Scene, jump: JumpResult, edges: set[tuple[str, str]]) -> None:
    changes = jump.mode_changes
    assert changes
    assert {(change.before, change.after) for change in changes} <= edges
    assert (changes[0].time_s, changes[0].before) == (0.0, "flight")
    for earlier, later in itertools.pairwise(changes):
        assert later.before == earlier.after
        assert later.time_s >= earlier.time_s
    lifts_s = [change.time_s for change in changes if change.after == "flight"]
    assert jump.liftoff_time_s == (lifts_s[-1] if lifts_s else None)
    if jump.outcome == "touchdown":
        assert changes[-1].after == "flight"
    if jump.outcome in ("no_liftoff", "no_trigger"):
        assert changes[-1].after != "flight"


@pytest.mark.parametrize("name", EDGES)
def test_only_edges_of_the_graph_are_taken(name: str) -> None:
    @given(near(name))
    def walks(values: dict[str, float]) -> None:
        scene = scene_or_sentence(CASES[name].changed, values, jumps=min(CASES[name].jumps, 3))
        if isinstance(scene, str):
            return
        for jump in simulate(scene, 1e-5).jumps:
            assert_walks_the_graph(scene, jump, EDGES[name])

    walks()


@pytest.mark.parametrize("name", EDGES)
def test_each_mode_keeps_its_promise(name: str) -> None:
    """Jammed, the foot rests; intruding, it moves down; on the ground it never rises; in flight the ground is below."""
    scene = CASES[name].changed(jumps=min(CASES[name].jumps, 3))
    result = simulate(scene, 1e-8, trajectory=True)
    assert result.trajectory is not None
    motion: dict[str, Any] = {str(key): values.values for key, values in result.trajectory.variables.items()}
    mode = motion["mode"]
    jammed, intruding, flight, carried = (
        mode == MODES.index(one) for one in ("jammed", "intruding", "flight", "carried")
    )
    assert np.all(motion["foot_velocity"][jammed] == 0.0)
    assert np.all(motion["foot_velocity"][intruding] < 1e-6)
    for jump in range(len(result.jumps)):
        stance = (motion["jump"] == jump) & ~flight & ~carried
        assert np.all(np.diff(motion["foot_height"][stance]) < 1e-9)
        assert np.max(-motion["foot_height"][stance]) == pytest.approx(result.jumps[jump].max_depth_m, abs=1e-9)
    if name == "force_plate":
        assert np.all(motion["foot_height"][flight] > -1e-9)
        assert np.all(motion["foot_height"][~flight] == 0.0)
