"""Shares of a prediction's variance by assumed input, against integrals over all inputs by Gauss's rule."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from simulator.jump import simulate
from simulator.scene_file import load_scene
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import SmallBook, small_book
from tests.helpers.wording import says

SIMULATION = """
[simulation]
scene = "bed"
assumed = ["foot_mass"]
varied = { kg_scale = 0.3 }
factors = { foot = "foot_radius", k_gain = "k_extension", b_ad_gain = "b_ad" }
"""
VARIED = {"kg_scale": 0.3, "foot_mass": 0.1}


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    made = small_book(tmp_path_factory.mktemp("shares"))
    made.toml.write_text(made.toml.read_text(encoding="utf-8") + SIMULATION, encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def shares(book: SmallBook) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = good(labbook("compare", "--shares", "512", "--json", at=book.folder)).json["shares"]
    return found


def by_integrals(book: SmallBook, b_ad: float, output: str) -> dict[str, tuple[float, float]]:
    """First-order and total index of both inputs, for the small foot."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    weights = weights / 2.0
    scene = load_scene("bed").changed({"foot_radius": 0.038, "k_extension": 2.56 * 400 + 67.36, "b_ad": b_ad})
    values = np.array(
        [
            [
                getattr(
                    simulate(
                        scene.changed({"kg_scale": 1.4 * (1.0 + 0.3 * kg), "foot_mass": 0.2 * (1.0 + 0.1 * foot)})
                    ).jump,
                    output,
                )
                for foot in nodes
            ]
            for kg in nodes
        ]
    )
    whole = np.outer(weights, weights)
    mean = np.sum(whole * values)
    variance = np.sum(whole * (values - mean) ** 2)
    of_kg = np.sum(weights * (values @ weights - mean) ** 2) / variance
    of_foot = np.sum(weights * (weights @ values - mean) ** 2) / variance
    return {"kg_scale": (of_kg, 1.0 - of_foot), "foot_mass": (of_foot, 1.0 - of_kg)}


@pytest.mark.parametrize(
    ("quantity", "output"), [("joules a jump", "cost_J"), ("apex height", "apex_height_m")]
)  # fmt: skip
def test_they_are_those_of_integrals(book: SmallBook, shares: list[dict[str, Any]], quantity: str, output: str) -> None:
    expected = by_integrals(book, 0.0, output)
    own = [one for one in shares if one["quantity"] == quantity]
    controls = [one for one in own if one["condition"] == "foot=small k_gain=400 b_ad_gain=0"]
    assert {one["input"] for one in controls} == set(VARIED)
    for one in controls:
        assert (one["first_order"], one["total"]) == pytest.approx(expected[one["input"]], abs=0.06)
        assert abs(one["total"] - expected[one["input"]][1]) < 4.0 * one["total_se"] < 0.4


def test_each_quantity_has_them_and_a_first_share_is_no_more_than_the_whole(shares: list[dict[str, Any]]) -> None:
    assert {one["quantity"] for one in shares} == {"joules a jump", "apex height", "savings"}
    for one in shares:
        assert -0.1 < one["first_order"] < one["total"] + 0.1


def test_they_are_said_on_request_and_a_sample_is_a_power_of_two(book: SmallBook) -> None:
    told = [good(labbook("compare", "--shares", "32", at=book.folder)).out for _ in range(2)]
    says(told[0], "Sobol")
    assert told[0] == told[1]  # the same sample is drawn again
    assert "Sobol" not in good(labbook("compare", at=book.folder)).out
    refused(labbook("compare", "--shares", "100", at=book.folder), 2, "power of two", "100")
