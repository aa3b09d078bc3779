"""Predictions of a book's conditions: simulated as they were run, with their error, traced, and reused."""

from __future__ import annotations

import functools
import hashlib
import itertools
import math
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from data_schema.errors import UsageError
from data_schema.queries.runs import list_runs
from data_schema.queries.study import LevelRow
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.actions.runs.correcting import correct
from labbook.actions.upkeep.tracing import find_number, trace, trace_lines
from labbook.analysis.prediction import predicting
from labbook.analysis.prediction.condition_scenes import level_parameters
from labbook.analysis.prediction.predicting import PredictionResult
from labbook.analysis.study import Analysis
from labbook.book.report_numbers import outdated_reports
from labbook.config.parsing import parse_configuration
from reports.display import SAVINGS
from reports.numbers import Number
from reports.results import ACCURACY, PredictedQuantity, Prediction, PredictionCheck
from simulator.jump import grown_rounding, simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene, parse_scene, write_scene
from stats.tails import t_quantile
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import ADA, SmallBook, small_book, small_toml
from tests.helpers.decided import reports
from tests.helpers.known_campaign import EQUIPMENT
from tests.helpers.wording import says

SIMULATION = """
[simulation]
scene = "bed"
assumed = ["foot_mass"]
varied = { kg_scale = 0.05 }
factors = { foot = "foot_radius", k_gain = "k_extension", b_ad_gain = "b_ad" }
"""
VARIED = {"kg_scale": 0.05, "foot_mass": 0.1}
RADIUS_M = {"small": 0.038, "large": 0.051}
K_N_M, B_AD = 2.56 * 400 + 67.36, {"0": 0.0, "100": 3.32 * 100 + 19.67}


def predicted_of(made: Analysis, quantity: PredictedQuantity, foot: str, level: str) -> Prediction:
    items = made.results.predictions.of(quantity)
    (found,) = [item for item in items if (item.group["foot"], item.level) == (foot, level)]
    return found


@dataclass(frozen=True)
class Reported:
    book: SmallBook
    made: Analysis


def predicted_book(folder: Path, simulation: str = SIMULATION) -> SmallBook:
    book = small_book(folder)
    book.toml.write_text(book.toml.read_text(encoding="utf-8") + simulation, encoding="utf-8")
    return book


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> Reported:
    book = predicted_book(tmp_path_factory.mktemp("predicted"))
    return Reported(book, reports(book))


def scene_of(foot: str, level: str, **more: float) -> Scene:
    """The condition's scene by hand: that of the bed with what the small book's labbook.toml says."""
    values = {"foot_radius": RADIUS_M[foot], "k_extension": K_N_M, "b_ad": B_AD[level]}
    return load_scene("bed").changed({**values, **more})


def simulated_to(accuracy: float, foot: str, level: str, **more: float) -> tuple[float, float]:
    jump = simulate(scene_of(foot, level, **more), accuracy).jump
    assert jump.apex_height_m is not None
    return jump.cost_J, jump.apex_height_m


simulated = functools.partial(simulated_to, 1e-6)


def error_by_hand(nominal: float, varied: list[tuple[float, float]], accuracy_part: float) -> float:
    return math.hypot(accuracy_part, *(max(abs(low - nominal), abs(high - nominal)) for low, high in varied))


def value_of(number: Number) -> float:
    assert isinstance(number.value, float)
    return number.value


@pytest.mark.parametrize("foot", RADIUS_M)
@pytest.mark.parametrize("level", B_AD)
def test_each_condition_is_simulated_as_it_was_run(reported: Reported, foot: str, level: str) -> None:
    nominal = simulated(foot, level)
    start = load_scene("bed")
    around = [
        [simulated(foot, level, **{name: start[name] * (1 + sign * part)}) for sign in (-1, 1)]
        for name, part in VARIED.items()
    ]
    for place, quantity in enumerate((PredictedQuantity.JOULES, PredictedQuantity.APEX)):
        found = predicted_of(reported.made, quantity, foot, level)
        assert found.check.predicted.value == nominal[place]
        pairs = [(low[place], high[place]) for low, high in around]
        assert found.check.predicted.se == pytest.approx(error_by_hand(nominal[place], pairs, 1e-6 * nominal[place]))
        assert value_of(found.check.difference) == nominal[place] - value_of(found.measured)


@pytest.mark.parametrize("foot", RADIUS_M)
def test_savings_are_predicted_as_they_are_measured_and_shared_assumptions_cancel(
    reported: Reported, foot: str
) -> None:
    def percent(**more: float) -> float:
        return 100 * (1 - simulated(foot, "100", **more)[0] / simulated(foot, "0", **more)[0])

    start = load_scene("bed")
    pairs = [
        (percent(**{name: start[name] * (1 - part)}), percent(**{name: start[name] * (1 + part)}))
        for name, part in VARIED.items()
    ]
    for level in ("100", "pooled"):
        found = predicted_of(reported.made, PredictedQuantity.SAVINGS, foot, level)
        assert found.check.predicted.value == pytest.approx(percent())
        assert found.check.predicted.se == pytest.approx(
            error_by_hand(percent(), pairs, 1e-4 * math.sqrt(2.0)), rel=1e-3
        )


def test_a_prediction_says_how_far_a_finer_simulation_moves_it(reported: Reported) -> None:
    for foot, level in itertools.product(RADIUS_M, B_AD):
        both = zip(*(simulated_to(accuracy, foot, level) for accuracy in (1e-6, 1e-8)), strict=True)
        for quantity, (value, finer) in zip((PredictedQuantity.JOULES, PredictedQuantity.APEX), both, strict=True):
            found = predicted_of(reported.made, quantity, foot, level).check.numerical_error
            assert found == pytest.approx(abs(value - finer), abs=1e-14 * value)
    for item in reported.made.results.predictions.items:
        assert item.check.numerical_error is not None
        assert isinstance(item.check.predicted.se, float)
        assert 0.0 < item.check.numerical_error < 1e-4 * item.check.predicted.se
        assert not item.check.imprecise
    assert reported.made.results.predictions.ends_otherwise == 0


@pytest.mark.parametrize(
    ("numerical", "se", "imprecise"),
    [(0.05, 1.0, False), (0.11, 1.0, True), (0.5, None, True), (0.0005, 0.001, False), (None, 1.0, True)],
)
def test_a_prediction_is_imprecise_where_the_simulation_errs_by_more_than_its_error_has_for_it(
    numerical: float | None, se: float | None, imprecise: bool
) -> None:
    ratio, accuracy = Number(0.5, "1"), Number(0.001, "J")
    found = PredictionCheck(Number(30.0, "J", se=se), Number(1.0, "J"), ratio, {"accuracy": accuracy}, numerical)
    assert found.imprecise is imprecise
    nothing = Number(Undefined(Reason.SIMULATED_CONTROL_FREE), "J")
    assert not PredictionCheck(nothing, nothing, nothing, {}, None).imprecise


@pytest.mark.parametrize(
    ("quantity", "se", "ratio", "agrees"),
    [
        (PredictedQuantity.APEX, 0.09, 0.5, True),
        (PredictedQuantity.APEX, 0.1, 0.5, None),
        (PredictedQuantity.APEX, 0.1, 1.5, False),
        (PredictedQuantity.SAVINGS, 0.1, 0.5, True),
    ],
)
def test_a_prediction_as_uncertain_as_itself_agrees_with_nothing(
    quantity: PredictedQuantity, se: float, ratio: float, agrees: bool | None
) -> None:
    check = PredictionCheck(Number(0.2, "m", se=se), Number(0.01, "m"), Number(ratio, "1"), {}, None)
    assert Prediction(quantity, {}, "", False, 4, Number(0.19, "m"), check).agrees is agrees


def check_ratios(items: Sequence[Prediction]) -> int:
    """The ratio is the difference over both expanded uncertainties, at 95 %; returns how many have none."""
    without = 0
    for item in items:
        difference = value_of(item.check.difference)
        end = item.measured.ci_high if difference > 0 else item.measured.ci_low
        if isinstance(end, Undefined) or isinstance(item.measured.df, Undefined):  # of Fieller's on two days
            assert item.quantity is PredictedQuantity.SAVINGS
            assert (isinstance(item.check.error_ratio.value, Undefined), item.agrees) == (True, None)
            without += 1
            continue
        assert isinstance(end, float)
        assert isinstance(item.check.predicted.se, float)
        level, df = item.measured.ci_level, item.measured.df
        narrower = 1.0 if level == 0.95 else t_quantile(0.95, df or 0.0) / t_quantile(level or 0.0, df or 0.0)
        expanded = math.hypot(narrower * (end - value_of(item.measured)), 2 * item.check.predicted.se)
        ratio = value_of(item.check.error_ratio)
        assert ratio == pytest.approx(difference / expanded)
        assert item.agrees is (abs(ratio) <= 1)
    return without


def test_the_ratio_is_the_difference_over_both_expanded_uncertainties(reported: Reported) -> None:
    items = reported.made.results.predictions.items
    assert len(items) == 12
    assert check_ratios(items) < 4


@pytest.mark.soak
def test_at_another_alpha_the_ratio_still_rests_on_95_percent(reported: Reported, tmp_path: Path) -> None:
    shutil.copytree(reported.book.folder, tmp_path / "book")
    book = SmallBook(tmp_path / "book", reported.book.instruments)
    book.toml.write_text(f"{book.toml.read_text(encoding='utf-8')}\n[analysis]\nalpha = 0.01\n", encoding="utf-8")
    items = reports(book).results.predictions.of(PredictedQuantity.SAVINGS)
    assert {item.measured.ci_level for item in items} == {0.99}
    assert (len(items), check_ratios(items)) == (4, 2)  # the large foot's days do not tell


def test_what_is_assumed_is_listed_with_its_reason_and_what_it_changes(reported: Reported) -> None:
    about = reported.made.results.predictions
    assert {one.name: one.parameter.varied_by for one in about.assumed} == VARIED
    checked = [item.check for item in reported.made.results.predictions.of(PredictedQuantity.JOULES)]
    assert len(checked) == 4
    for one in about.assumed:
        assert one.parameter.why
        parts = [check.errors[one.name].value for check in checked]
        assert one.changes[PredictedQuantity.JOULES] == max(value for value in parts if isinstance(value, float))


def traced(book: SmallBook, number: Number) -> str:
    with book.open() as standing, standing.reading() as connection:
        return "\n".join(trace_lines(trace(connection, find_number(standing, connection, number.provenance))))


def test_every_shown_number_is_traced_to_the_condition_the_robot_and_the_scene(reported: Reported) -> None:
    item = predicted_of(reported.made, PredictedQuantity.SAVINGS, "small", "100")
    told = traced(reported.book, item.check.predicted)
    assert f"predicted = {item.check.predicted.value!r} %" in told
    for words in ("prediction_check", "scene bed", "robot hopper, body_mass_kg 1.8", "condition foot=small", "sha256"):
        assert words in told
    assert "difference = " in traced(reported.book, item.check.difference)


def simulations(made: Analysis) -> list[PredictionResult]:
    """All predictions that were made for a report."""
    return [one for one in made.computed.made.values() if isinstance(one, PredictionResult)]


def test_the_simulated_scene_is_told_and_gives_the_number_again(reported: Reported) -> None:
    found = simulations(reported.made)
    with reported.book.open() as book, book.reading() as connection:
        keys = {run.condition_key for run in list_runs(connection) if run.levels}
    assert {one.origin.scope["condition"] for one in found} == keys
    for one in found:
        scene = parse_scene(one.scene_toml, "stored")
        assert one.effects == tuple(sorted(scene.effects))
        assert set(one.assumed) == set(scene.assumed) == set(VARIED)
        jump = simulate(scene, one.accuracy).jump
        assert jump.outcome == one.outcome
        assert one.predicted["joules_per_jump"].value == jump.cost_J
        assert one.predicted["apex_height"].value == jump.apex_height_m
        assert scene.values["body_mass"].source == "robot hopper"
        assert "foot" in scene.values["foot_radius"].source
        says(scene.title, "but with foot=")
        assert scene.title.endswith(", robot hopper")


def test_a_second_report_simulates_nothing_and_predicts_the_same_after_a_rebuild_too(
    reported: Reported, monkeypatch: pytest.MonkeyPatch
) -> None:
    def simulated_again(*_given: object) -> None:
        raise AssertionError("simulated again")

    monkeypatch.setattr(predicting, "simulate_means", simulated_again)
    done = good(labbook("rebuild", "--json", at=reported.book.folder)).json
    assert not any(done["differences"].values())
    again = reports(reported.book)
    assert again.results.predictions == reported.made.results.predictions
    assert simulations(again) == simulations(reported.made)


def test_compare_prints_the_tables_and_says_whether_all_is_met(reported: Reported) -> None:
    told = good(labbook("compare", "--foot", "small", at=reported.book.folder)).out
    tables = ("Energy of a jump", "Apex height", SAVINGS.capitalize())
    for words in (*tables, "small foot", "CE", "pooled", "kg_scale", "joint p"):
        assert words in told
    assert "large foot" not in told
    found = good(labbook("compare", "--json", at=reported.book.folder)).json
    assert len(found["predictions"]) == 12
    assert {one["name"] for one in found["assumed"]} == set(VARIED)
    says(told, "active damping saves", "equal height", "1 condition")
    says(found["ground"], "active damping saves", "equal height", "2 conditions")
    assert found["met"] is all(item["agrees"] is not False for item in found["predictions"])
    assert not found["met"]  # the small book's jumps cost ten times what any jump does
    says(told, "hundred times finer", "standard error")
    for item in found["predictions"]:
        assert not item["imprecise"]
        assert 0.0 < item["numerical_error"] < item["predicted"]["se"]
        assert item["difference"] == item["predicted"]["value"] - item["measured"]["value"]
    assert {one["quantity"] for one in found["bias"]} == {"joules a jump", "apex height"}
    for one in found["bias"]:
        differences = [item["difference"] for item in found["predictions"] if item["quantity"] == one["quantity"]]
        assert min(differences) <= one["bias"]["value"] <= max(differences)
        assert one["bias"]["ci_low"] < one["bias"]["value"] < one["by_measurement_alone"]["ci_high"]
    answer = labbook("compare", "--check", at=reported.book.folder)
    assert (answer.code, answer.err) == (1, "")
    assert answer.out == good(labbook("compare", at=reported.book.folder)).out


@pytest.mark.soak
def test_what_was_published_of_a_condition_stands_beside_it(reported: Reported, tmp_path: Path) -> None:
    told = good(labbook("compare", "--foot", "small", at=reported.book.folder)).out
    tables = [block for block in told.split("\n\n") if block.startswith("condition ")]
    assert ["published (thesis)" in table.splitlines()[0] for table in tables] == [False, False, True]
    assert all(line.endswith("p = .006 (5.2.1)") for line in tables[2].splitlines()[2:])
    found = good(labbook("compare", "--json", at=reported.book.folder)).json["predictions"]
    published = {(one["quantity"], one["group"]["foot"]): one["published"] for one in found}
    assert published["savings", "large"] == {
        "id": "bed.p.l.stiff.2", "where": "5.2.1", "published": 0.028, "unit": "p", "relation": ""
    }  # fmt: skip
    assert published["joules a jump", "large"] is None
    book = predicted_book(tmp_path, SIMULATION.replace('foot = "foot_radius", ', ""))
    assert "published" not in good(labbook("compare", at=book.folder)).out  # a foot that nobody says is another study's


def test_a_factor_that_is_not_simulated_is_said_before_any_table(reported: Reported, tmp_path: Path) -> None:
    book = predicted_book(tmp_path, SIMULATION.replace(', b_ad_gain = "b_ad"', ""))
    told = good(labbook("compare", "--foot", "small", at=book.folder)).out
    sentence, *_tables = told.split("\n\n")
    assert sentence.startswith("Not simulated: ")
    says(sentence, "names no parameter")
    found = good(labbook("compare", "--foot", "small", "--json", at=book.folder)).json
    (factor,) = found["not_in_scene"]
    assert factor in sentence
    savings = [item for item in found["predictions"] if item["quantity"] == "savings"]
    assert {item["predicted"]["value"] for item in savings} == {0.0}
    assert "Not simulated" not in good(labbook("compare", at=reported.book.folder)).out


def test_a_corrected_robot_is_simulated_anew_and_names_the_report(tmp_path: Path) -> None:
    book = predicted_book(tmp_path)
    reports(book, "foot=small")
    with book.open() as standing, standing.session(ADA) as session:
        correct(standing, session, "robot:hopper", ["foot_mass_kg=0.21"], "weighed again")
        (named,) = outdated_reports(session)
    says(named, "foot=small")
    found = predicted_of(reports(book, "foot=small"), PredictedQuantity.JOULES, "small", "0")
    assert found.check.predicted.value == simulated("small", "0", foot_mass=0.21)[0]


SMALL_CONTROL = "foot=small and b_ad_gain=0"


def test_a_condition_that_two_robots_ran_is_predicted_as_the_mean_over_its_runs(tmp_path: Path) -> None:
    cricket = EQUIPMENT.partition("[batteries")[0].replace("hopper", "cricket").replace("1.8", "1.6")
    book = predicted_book(tmp_path, SIMULATION + cricket)
    with book.open() as standing, standing.session(ADA) as session:
        correct(standing, session, "r001", ["robot=cricket"], "the other one hung there")
    about = reports(book, SMALL_CONTROL).results.predictions
    ((joules,), (apex,)) = about.of(PredictedQuantity.JOULES), about.of(PredictedQuantity.APEX)
    light = simulated("small", "0", body_mass=1.6)
    heavy = simulated("small", "0")
    assert (joules.n, apex.n) == (3, 4)  # no idle run says what the cricket draws
    assert joules.check.predicted.value == pytest.approx(heavy[0], rel=1e-12)
    assert apex.check.predicted.value == pytest.approx((light[1] + 3 * heavy[1]) / 4, rel=1e-12)


def test_an_assumed_mass_is_listed_of_each_robot(tmp_path: Path) -> None:
    cricket = EQUIPMENT.partition("[batteries")[0].replace("hopper", "cricket").replace("= 0.2", "= 0.3", 1)
    book = predicted_book(tmp_path, SIMULATION + cricket)
    with book.open() as standing, standing.session(ADA) as session:
        correct(standing, session, "r001", ["robot=cricket"], "the other one hung there")
    assumed = reports(book, SMALL_CONTROL).results.predictions.assumed
    assert sorted(one.parameter.value for one in assumed if one.name == "foot_mass") == [0.2, 0.3]


CHATTERING = """
[simulation]
scene = "sim1"
factors = { foot = "foot_radius", k_gain = "k_extension" }
"""


@pytest.mark.soak
def test_where_rounding_grows_beyond_the_accuracy_the_error_is_what_it_grows_to(tmp_path: Path) -> None:
    book = predicted_book(tmp_path, CHATTERING)
    about = reports(book, "b_ad_gain=0").results.predictions
    masses = {"body_mass": 1.8, "foot_mass": 0.2}
    grown = 0
    for item in about.of(PredictedQuantity.JOULES):
        radius_m = RADIUS_M[item.group["foot"]]
        scene = load_scene("sim1").changed({"foot_radius": radius_m, "k_extension": K_N_M, **masses})
        jump = simulate(scene, about.accuracy).jump
        rounding = grown_rounding(jump, about.accuracy)
        grown += rounding > 0.0
        assert item.check.predicted.value == pytest.approx(jump.cost_J, rel=1e-12)
        assert item.check.errors[ACCURACY].value == pytest.approx(max(about.accuracy, rounding) * jump.cost_J)
    assert (about.branched, about.on_edge, about.grown) == (0, 0, grown)
    assert grown == 1


def test_a_jump_that_ends_otherwise_is_no_number(tmp_path: Path) -> None:
    stiff = SIMULATION.replace('scene = "bed"', 'scene = "bed"\nparameters = { b_compression = 0.5 }')
    book = predicted_book(tmp_path, stiff)
    items = reports(book, "foot=small").results.predictions.items
    assert len(items) == 6
    for item in items:
        assert isinstance(item.check.predicted.value, Undefined)
        assert "leg_folded" in item.check.predicted.value.reason
        assert (item.agrees, isinstance(item.check.error_ratio.value, Undefined)) == (None, True)
    answer = labbook("compare", "--foot", "small", "--check", at=book.folder)
    assert answer.code == 1  # where nothing can be compared, nothing is met
    assert "leg_folded" in answer.out


def test_a_scene_of_one_s_own_is_traced_to_its_bytes_and_predicted_again_from_the_journal(tmp_path: Path) -> None:
    book = predicted_book(tmp_path, SIMULATION.replace('"bed"', '"own.toml"'))
    own = write_scene(load_scene("bed").changed({"b_compression": 20.0})) + "# the floor of the laboratory\n"
    (book.folder / "own.toml").write_text(own, encoding="utf-8")
    about = reports(book, SMALL_CONTROL).results.predictions
    (joules,) = about.of(PredictedQuantity.JOULES)
    assert joules.check.predicted.value == simulated("small", "0", b_compression=20.0)[0]
    assert about.scene == "own.toml"
    assert {one.name for one in about.assumed} == {*VARIED, "b_compression"}, "set, not sourced"
    told = traced(book, joules.check.predicted)
    says(told, "own.toml", "sha256", hashlib.sha256(own.encode()).hexdigest())
    (book.folder / "own.toml").write_text(
        own.replace("b_compression = { value = 20.0", "b_compression = { value = 30.0")
    )
    done = good(labbook("rebuild", "--json", at=book.folder)).json
    assert not any(done["differences"].values())
    good(labbook("why", joules.check.predicted.provenance, "--check", at=book.folder))
    (anew,) = reports(book, SMALL_CONTROL).results.predictions.of(PredictedQuantity.JOULES)
    assert anew.check.predicted.value == simulated("small", "0", b_compression=30.0)[0]


def test_without_a_scene_that_can_be_read_compare_says_what_to_write(tmp_path: Path) -> None:
    refused(labbook("compare", at=small_book(tmp_path / "none").folder), 2, "[simulation]")
    book = predicted_book(tmp_path / "own", SIMULATION.replace('"bed"', '"own.toml"'))
    refused(labbook("compare", at=book.folder), 2, "own.toml", "No such file")
    (book.folder / "own.toml").write_text(write_scene(load_scene("bed")).replace("[robot]", "[robots]"))
    refused(labbook("compare", at=book.folder), 2, "own.toml: 'robots' is not a known key of a scene file")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('foot = "foot_radius"', 'foot = "foot_radus"', "foot_radius"),
        ('foot = "foot_radius"', 'foot = "stall_torque_"', "stall_torque"),
        ('"foot_mass"]', '"footmass"]', "foot_mass"),
        ("kg_scale = 0.05", "kg_scal = 0.05", "kg_scale"),
        ('scene = "bed"', 'scene = "bed"\neffects = "+drg"', "drag"),
        ('scene = "bed"', 'scene = "bed"\nparameters = { kg_scale = -1.0 }', "kg_scale"),
    ],
)
def test_what_the_scene_does_not_know_is_refused_with_the_nearest_name(
    old: str, new: str, said: str, tmp_path: Path
) -> None:
    book = predicted_book(tmp_path, SIMULATION.replace(old, new))
    refused(labbook("compare", at=book.folder), 2, said)


def test_a_level_without_a_number_is_refused_with_what_to_write() -> None:
    settings = parse_configuration(small_toml() + SIMULATION, "labbook.toml").simulation
    assert settings is not None
    with pytest.raises(UsageError, match=r"\[simulation.levels.foot\]"):
        level_parameters(settings, None, "foot", LevelRow("uid", "huge", None, "{}"))


SUNK = """
[simulation]
scene = "sim2"
parameters = { foot_radius = 0.0073, kg_scale = %g }
"""


@pytest.mark.soak
@pytest.mark.parametrize(("kg_scale", "conditions"), [(1.0, 1), (3.0, 0)])
def test_a_body_that_gets_under_the_grains_is_told_of(tmp_path: Path, kg_scale: float, conditions: int) -> None:
    book = predicted_book(tmp_path, SUNK % kg_scale)
    about = reports(book, SMALL_CONTROL).results.predictions
    scene = load_scene("sim2").changed(
        {"foot_radius": 0.0073, "kg_scale": kg_scale, "body_mass": 1.8, "foot_mass": 0.2}
    )
    assert simulate(scene, about.accuracy).jump.under_surface == bool(conditions)
    assert (about.under_surface, about.open_book) == (conditions, 0)
