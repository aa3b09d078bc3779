from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.thesis.claims import VALUES, Claim, claims, finding, findings, judge_claim
from simulator.thesis.figures import ThesisFigures
from tests.helpers.thesis import thesis_figures

CLAIM = Claim("own", "3.2.3", ("3.8",), "a claim", "a number", "1", at_least=0.15, at_most=0.25)
PUBLISHED = {"sim1.saving": 0.20, "sim1.mech_ratio": 2.0, "sim2.foot_ce": 5.0, "sim2.pred1": None, "sim2.pred2": None}
"""The claims of ch. 3 in the collection of published results."""


def test_every_claim_is_computed_and_every_number_is_a_claim() -> None:
    assert [claim.id for claim in claims()] == list(VALUES)
    assert len(VALUES) == len(set(VALUES))


def test_the_published_results_are_carried() -> None:
    by_id = {claim.id: claim for claim in claims()}
    assert {name: by_id[name].published for name in PUBLISHED} == PUBLISHED


def test_every_claim_says_where_it_is_from_and_when_it_holds() -> None:
    for claim in claims():
        assert claim.where.startswith(("3.", "caption of 3."))
        assert set(claim.figures) <= {"3.2", "3.4", "3.5", "3.6", "3.8", "3.9", "3.11", "3.12", "3.13"}
        assert claim.statement
        assert claim.measure
        assert claim.at_least is not None or claim.at_most is not None


@given(st.lists(st.floats(-10.0, 10.0), min_size=1), st.floats(-10.0, 10.0), st.floats(-10.0, 10.0))
def test_a_claim_holds_where_every_value_lies_within(values: list[float], one: float, other: float) -> None:
    low, high = min(one, other), max(one, other)
    found = judge_claim(replace(CLAIM, at_least=low, at_most=high), np.array(values))
    inside = [low <= value <= high for value in values]
    assert (found.n, found.n_within, found.agrees) == (len(values), sum(inside), all(inside))
    assert (found.lowest, found.highest) == (min(values), max(values))
    assert found.lowest <= found.median <= found.highest


def test_a_jump_without_an_apex_is_within_no_limits() -> None:
    found = judge_claim(CLAIM, np.array([[0.2, np.nan], [0.16, 0.24]]))
    assert (found.n, found.n_within, found.agrees) == (4, 3, False)
    assert (found.lowest, found.highest) == (0.16, 0.24)


def test_a_limit_that_is_absent_does_not_bind() -> None:
    assert judge_claim(replace(CLAIM, at_least=None), np.array([-1e9, 0.25])).agrees
    assert judge_claim(replace(CLAIM, at_most=None), np.array([0.15, 1e9])).agrees
    assert not judge_claim(replace(CLAIM, at_most=None), np.array([0.1])).agrees


def test_the_saving_is_that_of_single_jumps() -> None:
    figures = thesis_figures()
    values = VALUES["sim1.saving"](figures)
    assert values.size == figures.over_velocity.touchdown_speed_m_s.size + figures.over_ground.jumps.ce.cost_j.size
    pair = figures.over_velocity.jumps
    assert values[0] == pytest.approx((pair.ce.cost_j[0] - pair.ad.cost_j[0]) / pair.ce.cost_j[0])
    # (CE - AD) / AD says the same the other way round
    saving, excess = values[-1], VALUES["sim1.excess"](figures).ravel()[-1]
    assert excess == pytest.approx(saving / (1.0 - saving))


def test_the_two_ways_to_say_which_foot_saves_more_exclude_each_other() -> None:
    small, large = (VALUES[name](thesis_figures()) for name in ("sim2.small_foot", "sim2.large_foot"))
    assert small == pytest.approx(-large)


def test_prediction_2_holds_only_where_small_and_stiff_saves_most_and_large_and_soft_least() -> None:
    figures = thesis_figures()
    saving = figures.over_damping.saving
    margins = VALUES["sim2.pred2"](figures)
    assert margins.shape == (3, 3, saving.shape[-1] - 1)
    for place in np.ndindex(margins.shape):
        ground, coefficient = place[:2], place[2] + 1
        corners = saving[ground][:, [0, -1], coefficient]
        ranked = corners[1, 0] == corners.max() and corners[0, 1] == corners.min()
        assert (margins[place] >= 0.0) == ranked


def test_an_elbow_is_a_coefficient_of_the_figure() -> None:
    figures = thesis_figures()
    steps = VALUES["sim2.elbow_ground"](figures) / np.diff(figures.over_damping.active_damping_kg_m)[0]
    assert steps == pytest.approx(np.round(steps))


def test_findings_of_a_figure_need_no_other() -> None:
    figures = ThesisFigures()
    found = findings(figures, ["3.4"])
    assert {item.claim.id for item in found} == {"sim1.same_until_switch", "sim1.push"}
    assert "over_damping" not in vars(figures)
    assert findings(figures, ["3.2"]) == ()


def test_every_claim_has_a_finding() -> None:
    found = findings(thesis_figures())
    assert [item.claim for item in found] == list(claims())
    assert all(np.isfinite([item.lowest, item.highest]).all() and item.n > 0 for item in found)
    assert finding(found[0].claim, thesis_figures()) == found[0]
