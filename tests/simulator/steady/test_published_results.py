from __future__ import annotations

import csv
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.gains import (
    DAMPING_AT_ZERO_GAIN,
    DAMPING_PER_GAIN,
    STIFFNESS_AT_ZERO_GAIN_N_M,
    STIFFNESS_PER_GAIN_N_M,
)
from simulator.scene_file import load_scene
from simulator.steady.published_numbers import comparisons, published_numbers
from simulator.steady.published_results import (
    CONTRADICTED,
    NOT_TESTABLE,
    REPRODUCED,
    JudgedResult,
    contradictions,
    judge_results,
    published_claims,
    published_results,
    result_of,
)
from simulator.steady.tables import BED_DAMPING_GAINS, BED_GAINS, FEET_M
from simulator.thesis.claims import VALUES, Claim, claims, judge_claim
from tests.helpers.steady import results, steady_tables
from tests.helpers.thesis import thesis_figures

SHARED = Path(__file__).parents[3].parent / "shared"
RESULTS = SHARED / "reference" / "published_results.csv"
RELATIONS = {"approx": "about", "equal": "", "qualitative": ""}
UNITS = {"fraction": "1", "ratio": "1"}


def the_one(name: str) -> JudgedResult:
    """A published result, judged."""
    return next(item for item in results() if item.result.id == name)


@pytest.mark.skipif(not RESULTS.is_file(), reason="the collected results lie beside the project: ../shared/reference")
def test_every_collected_result_is_in_the_table_once() -> None:
    with RESULTS.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [result.id for result in published_results()] == [row["id"] for row in rows]
    for result, row in zip(published_results(), rows, strict=True):
        assert result.where == row["section"]
        assert result.published == (float(row["value"]) if row["value"] else None), result.id
        assert result.unit == UNITS.get(row["unit"], row["unit"])
        assert result.relation == RELATIONS.get(row["relation"], row["relation"])
        if result.foot:
            gains = [float(gain) for gain in row["b_ad_gain"].split("-")]
            assert (result.foot, result.gain) == (row["foot"], float(row["k_gain"]))
            assert (result.damping_gains[0], result.damping_gains[-1]) == (gains[0], gains[-1])


def test_every_result_is_judged_by_a_claim_or_says_why_it_cannot_be() -> None:
    assert len({item.result.id for item in results()}) == len(published_results())
    claimed = {claim.id: claim for claim in (*claims(), *(number.claim for number in published_numbers()))}
    for item in results():
        result = item.result
        assert (item.finding is None) == bool(result.why) == (item.verdict == NOT_TESTABLE)
        assert item.statement
        assert bool(result.statement) == bool(result.why), "one statement, and not two"
        if not result.why:
            claim = claimed[result.id]
            assert result.where in claim.where or claim.id.startswith("sim1.")
            if claim.published is not None:
                assert (claim.published, claim.unit) == (result.published, result.unit)
    assert [claim.id for claim in published_claims()] == [
        item.result.id for item in results() if item.result.id.startswith("sim")
    ]


@given(st.floats(0.0, 0.3))
def test_a_verdict_follows_from_the_number_by_the_limits_of_its_claim(saving: float) -> None:
    item = the_one("bed.saving_best")
    assert item.finding is not None
    changed = replace(item, finding=judge_claim(item.finding.claim, np.array([saving])))
    assert changed.verdict == (REPRODUCED if 0.1125 <= saving <= 0.1875 else CONTRADICTED)


def test_one_point_beyond_the_limits_contradicts() -> None:
    claim = Claim("own", "5.2.1", (), "a claim", "a number", "J", at_most=5.0)
    like = the_one("bed.anova").result
    assert JudgedResult(like, judge_claim(claim, np.array([1.0, 5.0]))).verdict == REPRODUCED
    assert JudgedResult(like, judge_claim(claim, np.array([1.0, 5.1]))).verdict == CONTRADICTED
    assert JudgedResult(like, None).verdict == NOT_TESTABLE


def test_other_jumps_give_other_verdicts() -> None:
    tables = steady_tables()
    cheaper = [replace(row, cost_j=0.85 * row.ce_cost_j if row.damping_gain else row.cost_j) for row in tables.bed.rows]
    bed = replace(tables.bed, rows=tuple(cheaper))
    chapter_3 = [item.finding for item in results() if item.result.id.startswith("sim") and item.finding]
    changed = {item.result.id: item for item in judge_results(chapter_3, comparisons(replace(tables, bed=bed)), bed)}
    assert the_one("bed.saving_best").verdict == CONTRADICTED
    assert changed["bed.saving_best"].verdict == REPRODUCED
    assert changed["bed.p.l.stiff.3"].saving == pytest.approx(0.15)
    assert changed["bed.apex_gain"].verdict == the_one("bed.apex_gain").verdict == CONTRADICTED


def test_a_result_of_certain_conditions_is_found_by_their_foot_and_gains() -> None:
    def found(*where: Any, of_apex: bool = False) -> str | None:
        result = result_of(*where, of_apex=of_apex)
        return None if result is None else result.id

    every = (50.0, 100.0, 150.0, 200.0, 250.0)
    assert found("small", 400.0, (150.0,)) == "bed.p.s.stiff.3"
    assert found("small", 400.0, every) == "bed.saving_best"
    assert found("large", 300.0, every) == "bed.pooled.l.soft"
    assert found("", 200.0, (33.0,)) == "emu.saving_scaled"
    assert found("", 400.0, (0.0,), of_apex=True) == "emu.apex_high"
    for unknown in (("small", 400.0, every[:3]), ("", 200.0, (50.0,)), ("", 400.0, (150.0,)), ("flat", 400.0, every)):
        assert found(*unknown) is None
    assert found("small", 400.0, (150.0,), of_apex=True) is None
    assert found("", 400.0, (0.0,)) is None


def test_beside_a_p_value_stands_the_saving_of_its_conditions() -> None:
    bed = steady_tables().bed
    for item in results():
        result = item.result
        assert (item.saving is None) == (not result.foot)
        if result.foot:
            costs_j = [
                row.cost_j for row in bed.of(result.foot, result.gain) if row.damping_gain in result.damping_gains
            ]
            assert len(costs_j) == len(result.damping_gains)
            (ce_j,) = [row.cost_j for row in bed.of(result.foot, result.gain, (0.0,))]
            assert item.saving == pytest.approx(1.0 - np.mean(costs_j) / ce_j)
            assert result.unit == "p"


def test_what_is_taken_over_is_in_the_scenes() -> None:
    fits = {
        "gain.stiffness": STIFFNESS_PER_GAIN_N_M,
        "gain.stiffness0": STIFFNESS_AT_ZERO_GAIN_N_M,
        "gain.damping": DAMPING_PER_GAIN,
        "gain.damping0": DAMPING_AT_ZERO_GAIN,
    }
    for name, value in fits.items():
        assert the_one(name).result.published == value
    bed = load_scene("bed")
    assert bed["b_compression"] == bed["b_extension"] == DAMPING_AT_ZERO_GAIN
    low, high = (the_one(f"bed.phi_{state}").result.published or 0.0 for state in ("loose", "hard"))
    assert low < bed["phi"] == 0.62 < high
    charge_mah = the_one("bed.passive").result.published or 0.0
    assert bed["passive_power"] == pytest.approx(charge_mah * 3.6 * 15.4 / 720.0)
    assert "passive_draw" not in bed.effects
    smallest, largest = FEET_M.values()
    assert bed["foot_radius"] == smallest < largest
    assert (len(BED_GAINS), len(BED_DAMPING_GAINS)) == (2, 5)


def test_the_note_on_the_feet_says_what_is_simulated() -> None:
    bed = steady_tables().bed
    small, large = ([bed.of(foot, gain)[0].ce_cost_j for gain in BED_GAINS] for foot in FEET_M)
    stiff_j, soft_j = (b - a for a, b in zip(small, large, strict=True))
    assert f"by {stiff_j:.1f} and {soft_j:.1f} J" in the_one("bed.foot_ad").remark


def test_the_notes_on_chapter_3_say_where_its_claims_fail() -> None:
    figures = thesis_figures()
    speeds, ground, feet = figures.over_velocity.touchdown_speed_m_s, figures.over_ground, figures.over_damping
    saved = [1.0 - pair.ad.cost_j / pair.ce.cost_j for pair in (figures.over_velocity.jumps, ground.jumps)]
    # sim1.saving
    assert max(values.max() for values in saved) < 0.25
    low = saved[0] < 0.15
    assert low[speeds < 0.51].all()
    assert not low[(speeds > 0.51) & (speeds < 1.44)].any()
    assert low[speeds > 1.44].mean() > 0.9
    softest, dampest = np.nonzero(saved[1] < 0.15)
    assert softest.size + low.sum() == 54
    assert ground.sigma_n_m3[softest].max() < ground.nominal_sigma_n_m3
    assert ground.drag_scale[dampest].max() < ground.nominal_drag_scale
    # sim1.mech_ratio
    over = [pair.ce.mechanical_j / pair.ad.mechanical_j > 2.5 for pair in (figures.over_velocity.jumps, ground.jumps)]
    softest, dampest = np.nonzero(over[1])
    assert not over[0].any()
    assert softest.max() < 3
    assert ground.drag_scale[dampest].min() > 1.4 * ground.nominal_drag_scale
    # sim2.pred1, sim2.pred2: values by factors on stiffness and drag
    shares, margins = VALUES["sim2.pred1"](figures), VALUES["sim2.pred2"](figures)
    assert (feet.stiffness_factors, feet.drag_factors) == ((0.5, 1.0, 2.0), (0.5, 1.0, 2.0))
    assert np.argwhere(shares > 0.1).tolist() == [[1, 0, 1]]
    assert f"{100 * shares.max():.0f} %" in the_one("sim2.pred1").remark
    assert (margins[0, 2] >= 0.0).all()
    assert (margins[2] < 0.0).all()


def test_what_is_contradicted_has_a_remark_and_what_is_explained_says_so() -> None:
    explained = {number.claim.id for number in published_numbers() if number.reason}
    for item in results():
        if item.verdict == CONTRADICTED:
            assert item.remark
            assert (item.remark == "why: see below") == (item.result.id in explained)
    for foot in FEET_M:
        for gain in BED_GAINS:
            assert (np.diff([row.cost_j for row in steady_tables().bed.of(foot, gain)]) < 0.0).all()


def test_the_contradictions_have_their_places() -> None:
    found = contradictions()
    assert len(found) == len({item.text for item in found})
    assert all(re.search(r"\b[345]\.\d", item.where) for item in found)


def test_no_verdict_is_left_out() -> None:
    counts = Counter(item.verdict for item in results())
    assert counts == {REPRODUCED: 7, CONTRADICTED: 8, NOT_TESTABLE: 32}
