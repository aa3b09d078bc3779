"""The automaton's table says where the kernel goes at events, and no event goes elsewhere."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest

import simulator.jump
from simulator.jump import simulate
from simulator.kernel import build, layout, run
from simulator.kernel.automaton import EVENTS, OTHERS
from simulator.kernel.layout import MODE, MODES, OUTCOMES
from simulator.kernel.steps.stride import TIMED
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted
from tests.helpers.random_scenes import bases, drawn

Edges = Counter[tuple[str, str, str]]
MOST_STEPS = 20_000


def name_of(event: int) -> str:
    if event >= layout.SWITCHES:
        return "switches"
    return "timer" if event == TIMED else "inertia" if event < 0 else EVENTS[event].name


def watch(found: Edges, name: str, event: str = "") -> None:
    """Have a part of the jump loop tell which modes or outcomes it leads to."""
    make = getattr(run, name)

    def watched(*parts: Any) -> Any:
        function = make(*parts)

        def act(*arguments: Any) -> Any:
            work = arguments[0] if event else arguments[1]
            before = MODES[int(work[MODE])]
            outcome = function(*arguments)
            happened = event or name_of(int(arguments[0]))
            ends = outcome is not None and outcome >= 0
            after = OUTCOMES[int(outcome)].upper() if ends else MODES[int(work[MODE])]
            if after != before or happened not in ("inertia", "lasts"):
                found[before, happened, after] += 1
            return outcome

        return act

    setattr(run, name, watched)


def edges(scenes: list[Scene]) -> Edges:
    """From where, by which event, to where the kernel went in these scenes."""
    found: Edges = Counter()
    parts = {
        "make_finish_step": "",
        "make_control": "tick",
        "make_touch_down": "touches",
        "make_begin_jump": "touches",
        "make_given_up": "lasts",
    }
    kept = {name: getattr(run, name) for name in parts}
    simulator.jump.MOST_STEPS_A_JUMP, most = MOST_STEPS, simulator.jump.MOST_STEPS_A_JUMP
    try:
        for name, event in parts.items():
            watch(found, name, event)
        build.composed.cache_clear()
        build._kernel.cache_clear()
        for scene in scenes:
            simulate(scene, 1e-4)
    finally:
        simulator.jump.MOST_STEPS_A_JUMP = most
        for name, make in kept.items():
            setattr(run, name, make)
        build.composed.cache_clear()
        build._kernel.cache_clear()
    return found


def many(sets: int, each: int, seed: int) -> list[Scene]:
    """The shipped scenes and so many drawn sets of effects, each with so many drawn scenes beside it."""
    random = np.random.default_rng(seed)
    return [scene for base in bases(sets, seed) for scene in (base, *drawn(base, each, random)[0])]


def told() -> set[tuple[str, str, str]]:
    """Every way of the table; an outcome is written in capitals."""
    return {
        (before, event.name, after)
        for event in (*EVENTS, *OTHERS)
        for before, leads in event.leads.items()
        for after in (*leads, *map(str.upper, event.ends))
    }


def test_events_stand_in_the_order_of_their_guards() -> None:
    names = [event.name for event in (*EVENTS, *OTHERS)]
    assert len(set(names)) == len(names)
    of_effects = {guard.name.upper(): layout.OF_EFFECTS + place for place, guard in enumerate(layout.EFFECT_GUARDS)}
    assert layout.OF_EFFECTS + len(of_effects) <= layout.SWITCHES
    for place, event in enumerate(EVENTS):
        assert (vars(layout) | of_effects)[event.name.upper()] == place
        assert set(event.leads) <= set(MODES)


BESIDE: dict[str, tuple[str, dict[str, float], tuple[str, ...]]] = {
    "a platform that comes back late": ("emulator", {"reset_time": 0.35, "k_extension": 323.36}, ()),
    "a platform at its end": ("emulator", {"platform_travel": 0.01}, ()),
    "a platform that slides on": ("emulator", {"platform_mass": 0.8, "initial_height": 0.1}, ("platform_mass",)),
    "a foot that leaves a moving platform": (
        "emulator",
        {"shortest_hold": 2.0, "k_extension": 1400.0, "b_extension": 20.0, "b_ad": 60.0, "initial_height": 0.05}
        | {"platform_mass": 5.0, "platform_stiffness": 150.0, "platform_damping": 15.0, "platform_drag": 0.0}
        | {"platform_travel": 0.2},
        ("platform_mass",),
    ),
    "a light foot": ("emulator", {"foot_mass": 1e-4}, ()),
    "a light foot on a platform at its end": ("emulator", {"foot_mass": 1e-4, "platform_travel": 0.01}, ()),
    "a light foot and weak motors": ("emulator", {"foot_mass": 1e-4, "stall_torque": 1.5}, ()),
    "stiff ground": ("sim2", {"kg_scale": 1e8}, ()),
    "stiff ground without a clock": ("bed", {"kg_scale": 1e8}, ("rail_friction",)),
}
NEVER_SEEN = {("creeping", "releases")}
"""Ways that change the mode and are not tried here."""


def beside() -> list[Scene]:
    found = []
    for name, values, on in BESIDE.values():
        scene = load_scene(name)
        found.append(scene.changed(values, on, jumps=min(scene.jumps, 3)))
    return found


def test_the_kernel_goes_where_the_table_says() -> None:
    found = interpreted(edges, [*beside(), *many(1, 1, 1)])
    assert found.keys() - told() == set()
    changing = {
        (before, event.name)
        for event in (*EVENTS, *OTHERS)
        for before, leads in event.leads.items()
        if leads and leads != (before,)
    }
    assert changing - {(before, event) for before, event, _ in found} == NEVER_SEEN


@pytest.mark.soak
def test_so_it_does_in_many_scenes() -> None:
    assert interpreted(edges, many(60, 3, 2)).keys() - told() == set()
