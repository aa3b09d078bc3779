"""Calibrating the ground: known truth comes back, with intervals that hold it; a book's scene cites the book."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.validation_calibration import TRUE, conditions, measured
from benchmarks.validation_document import STUDIES, covered, outside
from data_schema.errors import InputRefused, UsageError
from data_schema.outcomes import Outcome
from labbook.actions.simulate.calibrating import sentences
from labbook.analysis.prediction.calibrating import Calibration, calibrate
from simulator.scene_file import load_scene
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import SmallBook, small_book
from tests.helpers.wording import refuses, says

SCENES = [scene for _group, scene in conditions()]


def calibrated(names: Sequence[str], seed: int = 7) -> Calibration:
    return calibrate(SCENES, measured(np.random.default_rng(seed)), names)


def test_the_ground_that_the_runs_were_made_on_comes_back() -> None:
    found = calibrated(list(TRUE))
    for one in found.parameters:
        low, high = one.profile
        assert low is not None
        assert high is not None
        assert low < TRUE[one.name] < high
        assert isinstance(one.se, float)
    assert 0.2 < found.chi_squared / found.df < 3.0
    assert [(one.outcome, one.of) for one in found.held_out] == [(Outcome.JOULES, 8), (Outcome.APEX, 8)]
    assert all(one.within >= 6 for one in found.held_out)
    assert found.rms[Outcome.APEX] < 0.003


def test_what_runs_of_a_day_have_in_common_widens_the_interval() -> None:
    """A day that moves all conditions together is no scatter between them: means count as so many days, not as runs."""
    alone, together = (
        calibrate(SCENES, measured(np.random.default_rng(3), day_share=share), ["kg_scale"]).parameters[0]
        for share in (0.0, 3.0)
    )
    assert isinstance(alone.se, float)
    assert isinstance(together.se, float)
    assert together.se > 2.0 * alone.se


@pytest.mark.soak
def test_intervals_cover_the_ground_and_what_is_held_out() -> None:
    """Each count lies in the 99.9 % binomial band."""
    assert not outside(covered(STUDIES["calibrate"], 40))


@pytest.mark.soak
def test_days_in_common_hide_no_group_that_the_scene_does_not_describe() -> None:
    """They move what is held out and the fit to the rest alike, which makes the difference's error smaller."""
    drawn = measured(np.random.default_rng(3), day_share=3.0)
    group = drawn[0].group
    moved = [
        replace(one, values=tuple(value + 0.007 for value in one.values))
        if one.outcome is Outcome.APEX and one.group == group
        else one
        for one in drawn
    ]
    of_apex = [calibrate(SCENES, runs, list(TRUE)).held_out[1] for runs in (drawn, moved)]
    assert [one.outcome for one in of_apex] == [Outcome.APEX] * 2
    assert of_apex[0].within == of_apex[0].of
    assert of_apex[1].within < 6


@pytest.mark.soak
def test_what_no_runs_tell_is_not_identified() -> None:
    found = calibrated(["phi", "rho"])  # the grains' mass by volume is their product
    assert [one.profile for one in found.parameters] == [(None, None)] * 2
    assert found.condition > 1e7
    three = calibrated(["kg_scale", "k_sh", "sigma"])  # count by two products
    assert not any(one.identified for one in (*found.parameters, *three.parameters))


@pytest.mark.parametrize(
    ("names", "facts"),
    [
        (["kg_scal"], ("kg_scal", "kg_scale")),
        (["foot_radius"], ("foot_radius", "differs")),
        (["initial_velocity"], ("initial_velocity", "above 0")),
        (["kg_scale", "kg_scale"], ("kg_scale", "twice")),
    ],
)
def test_what_cannot_be_fitted_is_refused(names: list[str], facts: tuple[str, ...]) -> None:
    with refuses(UsageError, *facts):
        calibrated(names)


def test_a_value_at_the_bound_of_what_a_scene_can_have_is_named() -> None:
    drawn = [one for one in measured(np.random.default_rng(7)) if one.outcome is Outcome.APEX]
    shallow = [replace(one, values=tuple(1.2 * value for value in one.values)) for one in drawn]
    found = calibrate(SCENES, shallow, ["phi"])
    assert found.parameters[0].at_bound
    says(" ".join(sentences(found)), "phi is at", "bound")


def test_one_run_a_condition_tells_no_scatter() -> None:
    with refuses(InputRefused, "two runs"):
        calibrate(SCENES, measured(np.random.default_rng(1), n=1), ["kg_scale"])


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    made = small_book(tmp_path_factory.mktemp("calibrated"))
    simulation = '\n[simulation]\nscene = "bed"\nfactors = { foot = "foot_radius", b_ad_gain = "b_ad" }\n'
    made.toml.write_text(made.toml.read_text(encoding="utf-8") + simulation, encoding="utf-8")
    return made


def test_a_books_ground_is_a_scene_that_cites_it_and_predicts(book: SmallBook) -> None:
    told = good(labbook("calibrate", "--fit", "kg_scale", "--out", "own.toml", at=book.folder)).out
    says(told, "F(")
    scene = load_scene(book.folder / "own.toml")
    last = (book.folder / "journal.jsonl").read_text(encoding="utf-8").splitlines()[-1]
    assert f"to {json.loads(last)['hash'][:12]}" in scene.values["kg_scale"].why
    says(told, "own.toml", "varied", "kg_scale")
    data = good(labbook("calibrate", "--fit", "kg_scale", "--json", at=book.folder)).json
    assert data["parameters"][0]["value"] == pytest.approx(scene["kg_scale"], rel=1e-12)
    refused(labbook("calibrate", "--out", "own.toml", at=book.folder), 2, "own.toml")
    text = book.toml.read_text(encoding="utf-8").replace('scene = "bed"', 'scene = "own.toml"')
    book.toml.write_text(text, encoding="utf-8")
    found = good(labbook("compare", "--json", at=book.folder)).json
    (fitted,) = (one for one in found["assumed"] if one["name"] == "kg_scale")  # its error is in what is predicted
    assert "fitted to" in fitted["why"]
    assert "Fitted to this study: kg_scale; agreement" in good(labbook("compare", at=book.folder)).out


@pytest.mark.soak
def test_the_line_for_labbook_toml_holds_wherever_the_scene_was_written(book: SmallBook) -> None:
    """It named the file alone, and labbook.toml looks for that in the folder of the book."""
    beside = book.folder.parent / "scenes"
    beside.mkdir()
    told = labbook("calibrate", "--fit", "kg_scale", "--out", "../scenes/sand.toml", at=book.folder)
    says(good(told).out, "[simulation]", "../scenes/sand.toml")
    (named,) = re.findall('scene = "(.*?)"', told.out)
    text = book.toml.read_text(encoding="utf-8")
    book.toml.write_text(re.sub('scene = ".*?"', f'scene = "{named}"', text), encoding="utf-8")
    assert good(labbook("compare", "--json", at=book.folder)).json["assumed"]


def test_without_a_scene_there_is_nothing_to_fit(tmp_path: Path) -> None:
    refused(labbook("calibrate", at=small_book(tmp_path).folder), 2, "[simulation]", "scene")
    refused(labbook("calibrate", "--level", "95", at=small_book(tmp_path / "b").folder), 2, "level")
