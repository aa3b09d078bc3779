"""The search, over effects whose worth is given, against all that there is; and the words for a tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import chain, combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UsageError
from simulator.ablation.outputs import Outputs
from simulator.ablation.smallest import MOST_CANDIDATES, LeavingOut, Smallest, refusal, smallest_set, tolerance_of
from simulator.ablation.study import sets_to_leave_out
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.scenes import is_sentence

PLATE = load_scene("force_plate").changed(jumps=1)
BED = load_scene("bed").changed(effects_on=["held_force", "short_leg_guard", "drag", "rail_friction"])
TOLERANCE = 0.01
REMOVABLE = sorted(name for name in PLATE.effects if refusal(PLATE, frozenset({name})) is None)
SUBSETS = [
    frozenset(item)
    for item in chain.from_iterable(combinations(REMOVABLE, size) for size in range(len(REMOVABLE) + 1))
    if refusal(PLATE, frozenset(item)) is None
]


def adding_up(scene: Scene, worths: Mapping[str, float], kept: frozenset[str] = frozenset()) -> LeavingOut:
    """The scene without some of its effects, each of which adds what it is worth to the cost."""

    def outputs(left_out: frozenset[str]) -> Outputs:
        return Outputs(
            "touchdown", 1, 1.0 + sum(worths.get(name, 0.0) for name in left_out), 0.3, 0.0, 1000, False, 100
        )

    return LeavingOut(scene, outputs, kept)


def searched(scene: LeavingOut) -> Smallest:
    return smallest_set(
        scene, [scene.measure(item) for item in sets_to_leave_out(scene.scene, scene.retained)], TOLERANCE
    )


def shares(lowest: float) -> st.SearchStrategy[dict[str, float]]:
    return st.fixed_dictionaries({name: st.floats(lowest, 0.02) for name in REMOVABLE})


@given(shares(0.0))
def test_of_effects_that_do_not_cancel_the_fewest_remain(worths: dict[str, float]) -> None:
    scene = adding_up(PLATE, worths)
    found = searched(scene)
    within = [item for item in SUBSETS if scene.measure(item).difference.within(TOLERANCE)]
    assert found.exhaustive
    assert len(found.left_out.effects) == max(map(len, within))
    least = min(sum(worths[name] for name in item) for item in within if len(item) == len(found.left_out.effects))
    assert found.left_out.difference.largest <= least + 1e-12


@given(shares(-0.02))
def test_what_is_found_stays_within_and_none_further_can_go(worths: dict[str, float]) -> None:
    scene = adding_up(PLATE, worths)
    found = searched(scene)
    gone = frozenset(found.left_out.effects)
    assert gone in SUBSETS
    assert set(found.effects) == PLATE.effects - gone
    assert scene.measure(gone) == found.left_out
    assert found.left_out.difference.within(TOLERANCE)
    assert not any(
        scene.measure(gone | {name}).difference.within(TOLERANCE)
        for name in set(REMOVABLE) - gone
        if gone | {name} in SUBSETS
    )


@given(shares(-0.02), st.sets(st.sampled_from(REMOVABLE)).map(frozenset))
def test_what_is_kept_stays(worths: dict[str, float], kept: frozenset[str]) -> None:
    found = searched(adding_up(PLATE, {**worths, **dict.fromkeys(kept, 0.0)}, kept))
    assert kept <= set(found.effects)
    assert not kept & {*found.candidates, *found.left_out.effects}


def test_two_that_cancel_are_found_though_neither_can_go_alone() -> None:
    worths = {**dict.fromkeys(REMOVABLE, 1.0), "drag": 0.5, "torque_cap": -0.5}
    found = searched(adding_up(PLATE, worths))
    assert found.left_out.effects == ("torque_cap", "drag")
    assert found.candidates == found.left_out.effects


def test_nothing_can_go() -> None:
    found = searched(adding_up(PLATE, dict.fromkeys(REMOVABLE, 1.0)))
    assert found.left_out.effects == ()
    assert set(found.effects) == PLATE.effects
    assert found.candidates == ()


def test_many_that_can_go_are_left_out_one_by_one_with_those_that_need_them() -> None:
    kept = {"inertial_drag": 1.0, "leg_damping": 1.0}
    found = searched(adding_up(BED, kept))
    assert len(found.candidates) > MOST_CANDIDATES
    assert not found.exhaustive
    assert set(found.effects) == {"hydrostatic_stiffness", *kept}
    assert {"held_force", "sampled_control"} <= set(found.left_out.effects), "held_force needs sampled_control"


@pytest.mark.parametrize("words", ["1%", " 1 % ", "0.01", "1e-2", "1.0%"])
def test_the_same_share_in_other_words(words: str) -> None:
    assert tolerance_of(words, 1e-6) == 0.01


@given(st.floats(1e-4, 0.999))
def test_shares_and_percentages(share: float) -> None:
    assert tolerance_of(repr(share), 1e-6) == share
    assert tolerance_of(f"{100.0 * share!r}%", 1e-6) == pytest.approx(share, rel=1e-15)


def test_all_may_pass() -> None:
    assert tolerance_of("100%", 1e-6) == 1.0


@pytest.mark.parametrize(
    ("words", "accuracy", "said"),
    [
        ("little", 1e-6, "--within little is not a share above 0: write for example --within 1%"),
        ("", 1e-6, "is not a share above 0"),
        ("%", 1e-6, "is not a share above 0"),
        ("0", 1e-6, "is not a share above 0"),
        ("-1%", 1e-6, "is not a share above 0"),
        ("nan", 1e-6, "is not a share above 0"),
        ("inf%", 1e-6, "is not a share above 0"),
        ("1", 1e-6, "--within 1 does not say of what: write --within 1%, or a number below 1."),
        ("101%", 1e-6, "lets everything pass: give at most 100%"),
        ("0.01%", 1e-4, "too fine to tell with results of accuracy 0.0001: give at least 0.1%, or --accuracy 1e-05."),
        ("1%", 0.0, "an accuracy of 0 cannot be had"),
        ("1%", float("nan"), "an accuracy of nan cannot be had"),
    ],
)
def test_refused_words(words: str, accuracy: float, said: str) -> None:
    with pytest.raises(UsageError) as refusal:
        tolerance_of(words, accuracy)
    assert said in str(refusal.value)
    assert is_sentence(str(refusal.value))
