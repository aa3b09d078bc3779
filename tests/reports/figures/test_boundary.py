"""The boundary of where active damping saves: a line where its saving passes a level, none where it jumps over it."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.tri import TriContourSet

from reports.figures.boundary import draw_boundary
from simulator.compiled import Row
from simulator.falsify import SAVES, Judged, Searched, question_by_words
from simulator.sweep.design import sobol_shares

QUESTION = question_by_words("bed", ["kg_scale=0.1:100", "bg_scale=0.03:10"], grounds=256)
SHARES = sobol_shares(2, 256, 0)


def _drawn(saving: Row, *, broken: bool) -> Row:
    """Where a line is drawn, shape (points, 2), across a box of which the left half asks for a stiffer extension."""
    stiffer = (SHARES[:, 0] < 0.5) & broken
    nowhere = np.zeros(256, np.bool_)
    judged = Judged(np.full(256, SAVES), np.ones(256), saving, nowhere, np.ones((2, 256)), np.zeros(256), stiffer)
    (axes,) = draw_boundary(QUESTION, Searched(SHARES, judged, 256), (), "title").axes
    paths = [path for lines in axes.collections if isinstance(lines, TriContourSet) for path in lines.get_paths()]
    found: Row = np.concatenate([path.vertices for path in paths] or [np.empty((0, 2))])
    return found


@pytest.mark.parametrize("broken", [False, True])
def test_a_line_is_drawn_where_the_saving_passes_a_level_and_not_along_a_break(broken: bool) -> None:
    saving = np.where(SHARES[:, 0] < 0.5, 0.15, 0.05)
    assert bool(len(_drawn(saving, broken=broken))) is not broken


def test_a_line_goes_on_on_both_sides_of_a_break() -> None:
    drawn = _drawn(0.2 * SHARES[:, 1], broken=True)
    assert drawn[:, 0].min() < 0.2
    assert drawn[:, 0].max() > 50.0
    assert np.median(drawn[:, 1]) == pytest.approx((0.03 * 10.0) ** 0.5, rel=0.1)


def test_where_there_is_no_share_of_a_cost_no_line_is_drawn_and_one_parameter_is_drawn_in_joules() -> None:
    drawn = _drawn(np.where(SHARES[:, 0] < 0.5, np.nan, 0.2 * SHARES[:, 1]), broken=False)
    assert drawn[:, 0].min() > 1.0
    question = question_by_words("bed", ["kg_scale=0.1:100"], grounds=8)
    saved_j, nowhere = np.linspace(-2.0, 5.0, 8), np.zeros(8, np.bool_)
    some = np.where(saved_j < 0.0, np.nan, 0.1)
    judged = Judged(np.full(8, SAVES), saved_j, some, np.isnan(some), np.ones((2, 8)), np.zeros(8), nowhere)
    (axes,) = draw_boundary(question, Searched(sobol_shares(1, 8, 0), judged, 8), (), "title").axes
    heights = np.concatenate([np.asarray(marks.get_offsets())[:, 1] for marks in axes.collections])
    assert heights == pytest.approx(saved_j)
    assert "J" in axes.get_ylabel()
