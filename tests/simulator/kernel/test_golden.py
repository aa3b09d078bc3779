"""Golden values: the stored reference of at least thirty digits, and the numbers printed for each scene."""

from __future__ import annotations

from decimal import Decimal

import pytest

from simulator.jump import simulate
from simulator.scene_file import load_scene, shipped_scenes
from tests.helpers.kernels import CASES, errors, interpreted, reference, relative_error, scene_of, spent_j

GROWN = ("sim1", "b_AD = 650")
"""Here sampled damping lets rounding grow: no step is fine enough for more than four digits."""
EFFECTS_AS_SHIPPED = [key for key in CASES if scene_of(*key).effects == load_scene(key[0]).effects]
OTHER_EFFECTS = [key for key in CASES if key not in EFFECTS_AS_SHIPPED]
WELL_CONDITIONED = [key for key in EFFECTS_AS_SHIPPED if key != GROWN]


def worst_errors(keys: list[tuple[str, str]], accuracy: float) -> dict[tuple[str, str], dict[str, float]]:
    """Of each case the largest errors of its outputs over its jumps."""
    found: dict[tuple[str, str], dict[str, float]] = {}
    for key in keys:
        scene, wanted = scene_of(*key), reference(*key)
        jumps = simulate(scene, accuracy).jumps
        assert len(jumps) == len(wanted)
        each = [errors(scene, jump, stored) for jump, stored in zip(jumps, wanted, strict=True)]
        found[key] = {name: max(error[name] for error in each) for name in each[0]}
    return found


def golden_values(scene: str) -> set[Decimal]:
    """Different numbers, other than 0, that are stored for a shipped scene's own kernel and that it can meet."""
    found: set[Decimal | None] = set()
    for key in WELL_CONDITIONED:
        if key[0] == scene:
            for jump in reference(*key):
                found |= {jump.max_depth_m, jump.liftoff_time_s, jump.apex_height_m, jump.heat_j, jump.mechanical_j}
    return {value for value in found if value}


@pytest.mark.parametrize("scene", shipped_scenes())
def test_a_shipped_scene_has_three_golden_values_of_thirty_digits(scene: str) -> None:
    """That they are met, the next test says; the numbers printed below come from two further methods."""
    values = golden_values(scene)
    assert len(values) >= 3
    assert min(len(value.as_tuple().digits) for value in values) >= 30


@pytest.mark.parametrize(("accuracy", "goal"), [(1e-9, 1e-9), (1e-6, 1e-6), (1e-3, 1e-3)])
@pytest.mark.parametrize("key", WELL_CONDITIONED, ids=", ".join)
def test_a_stored_case_is_met_within_the_accuracy(key: tuple[str, str], accuracy: float, goal: float) -> None:
    for name, error in worst_errors([key], accuracy)[key].items():
        assert error < goal, name


def test_cases_with_other_effects_are_met_within_the_accuracy() -> None:
    for key, found in interpreted(worst_errors, OTHER_EFFECTS, 1e-9).items():
        assert max(found.values()) < 1e-9, (key, found)


def test_where_sampled_damping_lets_rounding_grow_the_jump_is_flagged_and_near() -> None:
    scene = scene_of(*GROWN)
    jump = simulate(scene, 1e-9).jump
    assert jump.ill_conditioned
    assert jump.error_growth > 1e9
    assert max(errors(scene, jump, reference(*GROWN)[0]).values()) < 1e-4
    assert not simulate(scene_of("sim1", "defaults"), 1e-9).jump.ill_conditioned


STANCES = [
    ("defaults", 0.313741307, 0.0707555506, 1.63822700, 26.8783689, 3.65279414),
    ("b_AD = 100", 0.331988850, 0.0603763384, 1.59269870, 23.4476187, 2.28182620),
    ("R = 0.038, k_e = 1091.36", 0.296083120, 0.0530234419, 2.25324765, 62.4098244, 9.80272336),
    ("kg_scale = 100", 0.277990680, 0.000575971162, 2.20984676, 22.6519848, 3.88196249),
]


@pytest.mark.parametrize(("case", "liftoff_s", "depth_m", "velocity_m_s", "heat_j", "mechanical_j"), STANCES)
def test_stance_of_the_second_set(
    case: str, liftoff_s: float, depth_m: float, velocity_m_s: float, heat_j: float, mechanical_j: float
) -> None:
    """Until lift-off it does not matter which gains flight has, so that the shipped scene's kernel serves."""
    jump = simulate(load_scene("sim2").changed(CASES["sim2", case].values), 1e-9).jump
    assert relative_error(jump.liftoff_time_s, liftoff_s) < 1e-7
    assert relative_error(jump.max_depth_m, depth_m) < 1e-7
    assert relative_error(jump.liftoff_body_velocity_m_s, velocity_m_s) < 1e-7
    assert relative_error(jump.stance_heat_J, heat_j) < 1e-7
    assert relative_error(jump.stance_mechanical_J, mechanical_j) < 1e-7


CONSISTENT = [
    ("consistent, defaults", 0.306508691, 0.0717279155, 1.66743433, 25.0233513, 3.59511143),
    ("consistent, R = 0.038, k_e = 1091.36", 0.271298671, 0.0583805708, 2.36539381, 33.3738941, 7.41233594),
]


def second_set_otherwise() -> tuple[list[tuple[float | None, ...]], list[float | None]]:
    """Stances with the consistent cap, and the defaults' apexes with compression gains and with held ones."""
    stances: list[tuple[float | None, ...]] = []
    for case, *_ in CONSISTENT:
        jump = simulate(scene_of("sim2", case), 1e-9).jump
        stances.append(
            (
                jump.liftoff_time_s,
                jump.max_depth_m,
                jump.liftoff_body_velocity_m_s,
                jump.stance_heat_J,
                jump.stance_mechanical_J,
            )
        )
    soft, held = (scene_of("sim2", case) for case in ("defaults", "defaults, held gains in flight"))
    return stances, [simulate(scene, 1e-9).jump.apex_height_m for scene in (soft, held)]


def test_consistent_cap_and_gains_of_flight_of_the_second_set() -> None:
    stances, apexes_m = interpreted(second_set_otherwise)
    for found, (_, *printed) in zip(stances, CONSISTENT, strict=True):
        for value, wanted in zip(found, printed, strict=True):
            assert relative_error(value, wanted) < 1e-7
    assert relative_error(apexes_m[0], 0.302433481) < 1e-7
    assert relative_error(apexes_m[1], 0.303334225) < 1e-7
    assert relative_error(simulate(load_scene("sim2"), 1e-9).jump.apex_height_m, 0.303334225) < 1e-7


BED = [
    ("small foot, gain 300", 0.24764332, 0.02825756, 0.28553619, 40.391692),
    ("small foot, gain 400", 0.23954287, 0.03219244, 0.31408899, 46.233119),
    ("small foot, gain 400, active gain 150", 0.26051202, 0.02331402, 0.31567884, 41.639542),
    ("large foot, gain 300", 0.24196748, 0.01629306, 0.30808764, 41.620428),
]


@pytest.mark.parametrize(("case", "liftoff_s", "depth_m", "apex_m", "cost_j"), BED)
def test_jump_on_the_bed(case: str, liftoff_s: float, depth_m: float, apex_m: float, cost_j: float) -> None:
    """Depth is printed with seven digits."""
    jump = simulate(scene_of("bed", case), 1e-9).jump
    assert relative_error(jump.liftoff_time_s, liftoff_s) < 1e-7
    assert abs(jump.max_depth_m - depth_m) < 0.5e-8
    assert relative_error(jump.apex_height_m, apex_m) < 1e-7
    assert relative_error(jump.cost_J, cost_j) < 1e-7


FOURTH_JUMPS = [
    ("emulator", "gain 100", 0.726490201, 0.258145961, 14.1996282, 0.65191316, 0.023985675),
    ("emulator", "gain 200", 0.831528299, 0.347091909, 22.0381540, 2.12143575, 0.037842588),
    ("emulator", "gain 400", 0.933932865, 0.460781773, 38.1821089, 4.93295745, 0.051056828),
    ("emulator", "gain 300, b_AD = 166", 0.870560007, 0.398980694, 27.4499017, 2.19351310, 0.039355287),
    ("emulator", "gain 400, b_AD = 664/3", 0.895325294, 0.444057267, 33.0617621, 2.83681263, 0.043810934),
    ("force_plate", "gain 300", 0.587411086, 0.333169206, 43.3133127, 0.16930677, 0.0),
    ("force_plate", "gain 600", 0.672458602, 0.453726082, 63.1469520, 0.58872675, 0.0),
]


@pytest.mark.parametrize(("scene", "case", "touchdown_s", "apex_m", "heat_j", "mechanical_j", "sink_m"), FOURTH_JUMPS)
def test_first_touchdown_and_fourth_jump(
    scene: str, case: str, touchdown_s: float, apex_m: float, heat_j: float, mechanical_j: float, sink_m: float
) -> None:
    first, second, _, fourth = simulate(scene_of(scene, case), 1e-9).jumps
    assert relative_error(first.next_touchdown_time_s, touchdown_s) < 1e-7
    assert relative_error(second.touchdown_time_s, touchdown_s) < 1e-7
    assert relative_error(fourth.apex_height_m, apex_m) < 1e-7
    found_heat_j, found_mechanical_j = spent_j(fourth, whole_jump=True)
    assert relative_error(found_heat_j, heat_j) < 1e-7
    assert relative_error(found_mechanical_j, mechanical_j) < 1e-7
    assert relative_error(fourth.max_depth_m, sink_m) < 1e-7
