"""Stored reference results: certified digits, a closed energy book, and the values published for each scene."""

from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path

import pytest

from benchmarks.reference_simulator.cases import CASES
from benchmarks.reference_simulator.hopping import reference_jumps
from benchmarks.reference_simulator.storage import DATA, StoredCase, agreeing_digits, document, regenerate, stored
from data_schema.errors import UnknownName


def case(scene: str, name: str) -> StoredCase:
    return next(found for found in stored(scene) if found.name == name)


def assert_printed(values: Sequence[Decimal | None], printed: Sequence[str]) -> None:
    """The values round to what was printed."""
    for value, text in zip(values, printed, strict=True):
        assert value is not None
        assert value.quantize(Decimal(text)) == Decimal(text)


@pytest.mark.parametrize("scene", CASES)
def test_every_case_is_stored_with_its_parameters_and_thirty_digits(scene: str) -> None:
    """The file is what is written of the cases, each in the scenes' words, by which the simulator finds it."""
    found = stored(scene)
    assert document(scene, found) == (DATA / f"{scene}.toml").read_text(encoding="utf-8")
    for one in found:
        assert one.agreeing_digits >= 30
        for jump in one.jumps:
            assert abs(jump.energy_residual_j) < Decimal("1e-35")
            assert abs(jump.cost_j - jump.heat_j - jump.mechanical_j) < Decimal("1e-26")


def test_a_scene_without_a_reference_is_refused() -> None:
    with pytest.raises(UnknownName, match="bed"):
        stored("bad")


SECOND_SET = [
    ("defaults", "0.313741307", "0.0707555506", "1.63822700", "26.8783689", "3.65279414"),
    ("b_AD = 100", "0.331988850", "0.0603763384", "1.59269870", "23.4476187", "2.28182620"),
    ("R = 0.038, k_e = 1091.36", "0.296083120", "0.0530234419", "2.25324765", "62.4098244", "9.80272336"),
    ("kg_scale = 100", "0.277990680", "0.000575971162", "2.20984676", "22.6519848", "3.88196249"),
    ("consistent, defaults", "0.306508691", "0.0717279155", "1.66743433", "25.0233513", "3.59511143"),
    ("consistent, R = 0.038, k_e = 1091.36", "0.271298671", "0.0583805708", "2.36539381", "33.3738941", "7.41233594"),
]


@pytest.mark.parametrize(("name", "liftoff", "depth", "velocity", "heat", "mechanical"), SECOND_SET)
def test_stances_of_the_second_set(
    name: str, liftoff: str, depth: str, velocity: str, heat: str, mechanical: str
) -> None:
    jump = case("sim2", name).jumps[0]
    assert jump.outcome == "apex"
    found = (jump.liftoff_time_s, jump.max_depth_m, jump.liftoff_body_velocity_m_s, jump.heat_j, jump.mechanical_j)
    assert_printed(found, (liftoff, depth, velocity, heat, mechanical))


def test_apexes_of_the_second_set_by_the_gains_of_flight() -> None:
    names = ("defaults", "defaults, held gains in flight")
    assert_printed([case("sim2", name).jumps[0].apex_height_m for name in names], ("0.302433481", "0.303334225"))


def test_with_immediate_contact_soft_gains_prolong_the_stance() -> None:
    """The other reading of contact: the foot jams again at lift-off, until a later tick lets it go for good."""
    jump = case("sim2", "defaults, immediate contact").jumps[0]
    modes = [change.mode for change in jump.mode_changes]
    assert modes.count("flight") > 5
    assert_printed([jump.liftoff_time_s], ["0.322330346"])


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
    found = (jump.liftoff_time_s, jump.max_depth_m, jump.apex_height_m, jump.cost_j)
    assert_printed(found, (liftoff, depth, apex, cost))


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
    found = (first.duration_s, fourth.apex_height_m, fourth.heat_j, fourth.mechanical_j, fourth.max_depth_m)
    assert_printed(found, (touchdown, apex, heat, mechanical, sink))


def test_a_jump_is_the_stored_one_at_another_precision_and_order() -> None:
    """The cheapest of them, on rigid ground."""
    cheapest = CASES["force_plate"][0]
    computed = reference_jumps(cheapest.effects, cheapest.values, 1, digits=32, order=40)
    assert agreeing_digits(computed, stored("force_plate")[0].jumps[:1]) >= 30


@pytest.mark.soak
@pytest.mark.parametrize("scene", CASES)
def test_computed_anew_the_stored_numbers_come_out_the_same(scene: str, tmp_path: Path) -> None:
    """To the last digit, but for the energy residuals, which are rounding."""
    regenerate([scene], tmp_path)
    for one, kept in zip(stored(scene, tmp_path), stored(scene), strict=True):
        assert one.agreeing_digits == agreeing_digits(one.jumps, kept.jumps) == 36
        assert all(abs(jump.energy_residual_j) < Decimal("1e-35") for jump in one.jumps)
