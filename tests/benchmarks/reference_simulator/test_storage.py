"""Stored reference results: certified digits, a closed energy book, and the values published for each scene."""

from decimal import Decimal
from pathlib import Path

import pytest

from benchmarks.reference_simulator.cases import CASES
from benchmarks.reference_simulator.hopping import reference_jumps
from benchmarks.reference_simulator.leg import HoppingParameters
from benchmarks.reference_simulator.storage import DATA, StoredCase, agreeing_digits, document, regenerate, stored
from data_schema.errors import UnknownName


def case(scene: str, name: str) -> StoredCase:
    return next(found for found in stored(scene) if found.name == name)


def assert_printed(value: Decimal | None, printed: str) -> None:
    """The value rounds to what was printed."""
    assert value is not None
    assert value.quantize(Decimal(printed)) == Decimal(printed)


@pytest.mark.parametrize("scene", CASES)
def test_every_case_is_stored_with_its_parameters_and_thirty_digits(scene: str) -> None:
    found = stored(scene)
    assert [(one.name, one.parameters) for one in found] == [(one.name, one.parameters) for one in CASES[scene]]
    for one in found:
        assert one.agreeing_digits >= 30
        for jump in one.jumps:
            assert abs(jump.energy_residual_j) < Decimal("1e-35")
            assert abs(jump.cost_j - jump.heat_j - jump.mechanical_j) < Decimal("1e-26")


@pytest.mark.parametrize("scene", CASES)
def test_files_are_what_is_written_of_their_cases(scene: str) -> None:
    """With each case in the scenes' words, by which the simulator finds it."""
    assert document(scene, stored(scene)) == (DATA / f"{scene}.toml").read_text(encoding="utf-8")


def test_a_scene_without_a_reference_is_refused() -> None:
    with pytest.raises(UnknownName, match="bed"):
        stored("bad")


SECOND_SET = [
    ("defaults", "0.313741307", "0.0707555506", "1.63822700", "26.8783689", "3.65279414"),
    ("b_AD = 100", "0.331988850", "0.0603763384", "1.59269870", "23.4476187", "2.28182620"),
    ("R = 0.038, k_e = 1091.36", "0.296083120", "0.0530234419", "2.25324765", "62.4098244", "9.80272336"),
    ("kg_scale = 100", "0.277990680", "0.000575971162", "2.20984676", "22.6519848", "3.88196249"),
    ("consistent, defaults", "0.306508691", "0.0717279155", "1.66743433", "25.0233513", "3.59511143"),
    (
        "consistent, R = 0.038, k_e = 1091.36",
        "0.271298671",
        "0.0583805708",
        "2.36539381",
        "33.3738941",
        "7.41233594",
    ),
]


@pytest.mark.parametrize(("name", "liftoff", "depth", "velocity", "heat", "mechanical"), SECOND_SET)
def test_stances_of_the_second_set(
    name: str, liftoff: str, depth: str, velocity: str, heat: str, mechanical: str
) -> None:
    jump = case("sim2", name).jumps[0]
    assert jump.outcome == "apex"
    assert_printed(jump.liftoff_time_s, liftoff)
    assert_printed(jump.max_depth_m, depth)
    assert_printed(jump.liftoff_body_velocity_m_s, velocity)
    assert_printed(jump.heat_j, heat)
    assert_printed(jump.mechanical_j, mechanical)


def test_apexes_of_the_second_set_by_the_gains_of_flight() -> None:
    assert_printed(case("sim2", "defaults").jumps[0].apex_height_m, "0.302433481")
    assert_printed(case("sim2", "defaults, held gains in flight").jumps[0].apex_height_m, "0.303334225")


def test_with_immediate_contact_soft_gains_prolong_the_stance() -> None:
    """The other reading of contact: the foot jams again at lift-off, until a later tick lets it go for good."""
    jump = case("sim2", "defaults, immediate contact").jumps[0]
    modes = [change.mode for change in jump.mode_changes]
    assert modes.count("flight") > 5
    assert_printed(jump.liftoff_time_s, "0.322330346")


def test_without_a_cap_the_first_set_jumps_as_the_consistent_one() -> None:
    """At the defaults the stall torque never binds, so that cap and cost rule make no difference."""
    first, second = case("sim1", "defaults").jumps[0], case("sim2", "consistent, defaults").jumps[0]
    assert first.cost_j == second.cost_j
    assert first.apex_height_m == second.apex_height_m
    assert case("sim1", "b_AD = 650").jumps[0].cost_j < Decimal("0.9") * first.cost_j


BED = [
    ("small foot, gain 300", "0.24764332", "0.02825756", "0.28553619", "40.391692"),
    ("small foot, gain 400", "0.23954287", "0.03219244", "0.31408899", "46.233119"),
    ("small foot, gain 400, active gain 150", "0.26051202", "0.02331402", "0.31567884", "41.639542"),
    ("large foot, gain 300", "0.24196748", "0.01629306", "0.30808764", "41.620428"),
]


@pytest.mark.parametrize(("name", "liftoff", "depth", "apex", "cost"), BED)
def test_jumps_on_the_bed(name: str, liftoff: str, depth: str, apex: str, cost: str) -> None:
    jump = case("bed", name).jumps[0]
    assert_printed(jump.liftoff_time_s, liftoff)
    assert_printed(jump.max_depth_m, depth)
    assert_printed(jump.apex_height_m, apex)
    assert_printed(jump.cost_j, cost)


FOURTH_JUMPS = [
    ("emulator", "gain 100", "0.726490201", "0.258145961", "14.1996282", "0.65191316", "0.023985675"),
    ("emulator", "gain 200", "0.831528299", "0.347091909", "22.0381540", "2.12143575", "0.037842588"),
    ("emulator", "gain 400", "0.933932865", "0.460781773", "38.1821089", "4.93295745", "0.051056828"),
    ("emulator", "gain 300, b_AD = 166", "0.870560007", "0.398980694", "27.4499017", "2.19351310", "0.039355287"),
    ("emulator", "gain 400, b_AD = 664/3", "0.895325294", "0.444057267", "33.0617621", "2.83681263", "0.043810934"),
    ("force_plate", "gain 300", "0.587411086", "0.333169206", "43.3133127", "0.16930677", "0"),
    ("force_plate", "gain 600", "0.672458602", "0.453726082", "63.1469520", "0.58872675", "0"),
]


@pytest.mark.parametrize(("scene", "name", "touchdown", "apex", "heat", "mechanical", "sink"), FOURTH_JUMPS)
def test_first_touchdown_and_fourth_jump(
    scene: str, name: str, touchdown: str, apex: str, heat: str, mechanical: str, sink: str
) -> None:
    first, *_, fourth = case(scene, name).jumps
    assert_printed(first.duration_s, touchdown)
    assert_printed(fourth.apex_height_m, apex)
    assert_printed(fourth.heat_j, heat)
    assert_printed(fourth.mechanical_j, mechanical)
    assert_printed(fourth.max_depth_m, sink)


def test_a_jump_is_the_stored_one_at_another_precision_and_order() -> None:
    """The cheapest of them, on rigid ground."""
    parameters = CASES["force_plate"][0].parameters
    assert isinstance(parameters, HoppingParameters)
    computed = reference_jumps(parameters, 1, digits=32, order=40)
    assert agreeing_digits(computed, stored("force_plate")[0].jumps[:1]) >= 30


@pytest.mark.soak
@pytest.mark.parametrize("scene", CASES)
def test_computed_anew_the_stored_files_come_out_the_same(scene: str, tmp_path: Path) -> None:
    regenerate([scene], tmp_path)
    assert (tmp_path / f"{scene}.toml").read_bytes() == (DATA / f"{scene}.toml").read_bytes()
