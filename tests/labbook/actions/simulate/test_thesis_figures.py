"""From simulated data to the drawings of ch. 3's figures, and its claims as a table."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest

from labbook.actions.simulate.thesis_figures import THESIS_FIGURES
from labbook.presenting.simulation.published import claims_data, claims_table
from reports.tables.formats import csv_bytes, markdown_text
from simulator.thesis.claims import Claim, Finding, judge_claim
from tests.helpers.thesis import thesis_figures

SAVING = Claim("own.saving", "3.2.3", ("3.8",), "it saves", "a | b", "1", published=0.2, at_least=0.15, at_most=0.25)
JOULES = Claim("own.joules", "3.3.1", ("3.13",), "it is small", "spread", "J", at_most=5.0)
FINDINGS: tuple[Finding, ...] = (
    judge_claim(SAVING, np.array([0.16, 0.2])),
    judge_claim(JOULES, np.array([1 / 3, 4.0, 9.5])),
)


@pytest.mark.parametrize("number", THESIS_FIGURES)
def test_every_figure_is_drawn_from_what_was_simulated(number: str) -> None:
    figure = THESIS_FIGURES[number]
    drawn = figure.draw(thesis_figures())
    assert any(axes.get_xlabel() for axes in drawn.axes)
    caption = figure.full_caption(thesis_figures())
    assert caption.startswith(figure.caption)
    assert ("jumps are ill-conditioned" in caption) == (number in ("3.8", "3.9", "3.11", "3.12", "3.13"))


def test_the_drawn_cost_is_the_simulated_one() -> None:
    figures = thesis_figures()
    ce, ce_flagged, ad, ad_flagged = THESIS_FIGURES["3.8"].draw(figures).axes[0].get_lines()
    assert ce.get_ydata() == pytest.approx(figures.over_velocity.jumps.ce.cost_j)
    assert ad.get_ydata() == pytest.approx(figures.over_velocity.jumps.ad.cost_j)
    assert ce.get_xdata() == pytest.approx(figures.over_velocity.touchdown_speed_m_s)
    marked = figures.over_velocity.touchdown_speed_m_s[figures.over_velocity.jumps.ad.ill_conditioned]
    assert len(np.asarray(ce_flagged.get_xdata())) == 0
    assert ad_flagged.get_xdata() == pytest.approx(marked)


def test_claims_are_told_as_csv_with_all_digits_as_marked_markdown_and_as_json() -> None:
    rows = list(csv.DictReader(io.StringIO(csv_bytes(claims_table(FINDINGS)).decode())))
    assert float(rows[1]["lowest"]) == 1 / 3
    assert (rows[1]["at_least"], rows[1]["at_most"], rows[1]["n_within"]) == ("", "5.0", "2")
    lines = [line for line in markdown_text(claims_table(FINDINGS)).splitlines() if line.startswith("| own.")]
    assert ["**" in line for line in lines] == [False, True]
    assert "a \\| b" in lines[0]
    saving, joules = json.loads(json.dumps(claims_data(FINDINGS), allow_nan=False))
    assert (saving["agrees"], joules["agrees"], joules["share_within"]) == (True, False, 2 / 3)
    assert (saving["figures"], joules["highest"], joules["published"]) == (["3.8"], 9.5, None)
