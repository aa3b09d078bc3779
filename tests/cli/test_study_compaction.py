"""`labbook study compaction`: known fractions found again from sheets of flasks, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import statsmodels.api as sm

from benchmarks.validation_document import STUDIES, covered, outside
from ingest.formats.study_sheets import StudySheet, read_flasks
from ingest.tables.sheet import SheetFile
from labbook.demo.studies.sheets import COMPACTED, FLASK_RADII_MM, GRAIN_MM, LOOSE, WALLS, flasks
from labbook.studies.compaction import Compaction, compaction
from tests.cli.shell import good, labbook, refused
from tests.helpers.study_pages import study_page
from tests.helpers.wording import says


def read(text: str, decimal: str | None = None) -> Compaction:
    """What a sheet says."""
    return compaction(read_flasks(SheetFile("flasks.csv", text.encode(), decimal=decimal)), GRAIN_MM)


@pytest.mark.soak
def test_intervals_cover_the_fractions_and_their_difference() -> None:
    """Each count lies in the 99.9 % binomial band."""
    assert not outside(covered(STUDIES["compaction"], 400))


def test_without_errors_the_fractions_are_found_to_rounding() -> None:
    found = read(flasks(np.random.default_rng(0), 0.0, 0.0, str))
    assert [state.fraction for state in found.states] == pytest.approx([LOOSE, COMPACTED], rel=1e-7)
    assert [state.line.coefficients[1] for state in found.states] == pytest.approx(WALLS, rel=1e-6)
    assert found.difference.fraction == pytest.approx(COMPACTED - LOOSE, rel=1e-6)


def test_a_curve_s_interval_stands_beside_that_of_the_line_and_a_curve_that_shows_is_said() -> None:
    """A line through fractions on a curve has the shorter interval, which does not hold what is true."""
    radii_m = np.geomspace(0.015, 0.08, 12)
    wall, errors = 3.4e-3 / radii_m, np.random.default_rng(7).normal(0.0, 1e-3, (2, 12))

    def of(curvature: float) -> Compaction:
        water = 1.0 - np.array([[LOOSE], [COMPACTED]]) + (0.25 - curvature * wall) * wall - errors
        values = {"radius": [*radii_m.tolist()] * 2, "flask": [1.0] * 24, "water": water.ravel().tolist()}
        return compaction(StudySheet(values, {"state": ["loose"] * 12 + ["compacted"] * 12}, range(24)), 3.4)

    straight, curved = of(0.0), of(1.5)
    for found in (straight, curved):
        for state, true in zip(found.states, (LOOSE, COMPACTED), strict=True):
            assert isinstance(state.curved_ci, tuple)
            assert state.curved_ci[0] < true < state.curved_ci[1]
    line = curved.states[0].ci
    assert isinstance(line, tuple)
    assert not line[0] < LOOSE < line[1]
    x = sm.add_constant(np.column_stack([wall, wall**2]))
    middle = np.mean([state.fractions for state in curved.states], axis=0)
    assert curved.curvature_p == pytest.approx(sm.OLS(middle, x).fit().pvalues[2], rel=1e-6)
    assert any("follow no line" in line for line in curved.sentences())
    assert not any("follow no line" in line for line in straight.sentences())
    says(straight.sentences()[0], "along a curve 0.6")


def test_units_and_measured_volumes_are_those_of_the_columns() -> None:
    rows = [line.split(",") for line in flasks(np.random.default_rng(1)).splitlines()[1:]]
    volumes_l = [4.0 / 3.0 * math.pi * float(radius) ** 3 / 1e6 for radius, _, _ in rows]
    lines = [
        f"{float(radius) / 10.0!r};{state};{float(water) / 1e3!r};{volume_l!r}"
        for (radius, state, water), volume_l in zip(rows, volumes_l, strict=True)
    ]
    text = "\n".join(["Radius (cm);State;water volume [l];flask_l", *lines])
    one = read(flasks(np.random.default_rng(1)))
    other = read(text, ".")
    for state, same in zip(one.states, other.states, strict=True):
        assert state.fractions == pytest.approx(same.fractions, rel=1e-12)


def test_repeated_fillings_of_a_flask_are_one_flask() -> None:
    """They share the flask's error: more of them make no more flasks, and need not be as many in both states."""
    lines = flasks(np.random.default_rng(4)).splitlines(keepends=True)
    once = read("".join(lines))
    often = read("".join([*lines, *lines[1:], lines[1]]))
    assert often.n == len(FLASK_RADII_MM)
    assert often.difference.ci == pytest.approx(once.difference.ci, rel=1e-9)


def test_rows_that_are_the_same_are_named(tmp_path: Path) -> None:
    """A coarse balance may give two fillings the same digits: they count, and are said."""
    head, *rows = flasks(np.random.default_rng(4)).splitlines()
    sheet = tmp_path / "flasks.csv"
    sheet.write_text("\n".join([head, *rows, rows[1], ""]), encoding="utf-8")
    asked = ("study", "compaction", "flasks.csv", "--grain", "3.4")
    says(good(labbook(*asked, at=tmp_path)).out, "line 12", "line 3", "copy")
    assert "line 12" in good(labbook(*asked, "--json", at=tmp_path)).json["doubt"]
    sheet.write_text("\n".join([head + ",filling", *(f"{row},{n}" for n, row in enumerate([*rows, rows[1]])), ""]))
    assert good(labbook(*asked, "--json", at=tmp_path)).json["doubt"] is None


def test_loose_comes_first_and_swapped_states_are_said() -> None:
    head, *rows = flasks(np.random.default_rng(5)).splitlines()
    swapped = [row.replace("loose", "x").replace("compacted", "Loose").replace("x", "compacted") for row in rows]
    found = read("\n".join([head, *swapped]))
    assert [state.state for state in found.states] == ["Loose", "compacted"]
    assert any("swapped" in line for line in found.sentences())


def test_a_fraction_beyond_equal_spheres_is_said_first() -> None:
    head, *rows = (line.split(",") for line in flasks(np.random.default_rng(5)).splitlines())
    dense = [",".join([*row[:2], f"{float(row[2]) / 2:.2f}"]) for row in rows]
    found = read("\n".join([",".join(head), *dense]))
    says(found.sentences()[0], "A flask is 0.8", "0.7405")


def test_the_page_works_as_it_says(tmp_path: Path) -> None:
    page = study_page("compaction.md")
    (tmp_path / "flasks.csv").write_text(page.sheet, encoding="utf-8")
    told = good(labbook(*page.words, at=tmp_path)).out
    assert told == f"{page.said}compaction.pdf\n"
    assert len(told.split("\n\n")[1].splitlines()) == 12, "a head, ten measurements, and the file"
    assert (tmp_path / "compaction.pdf").read_bytes().startswith(b"%PDF")


ROWS = "15,loose,6.3\n15,hard,5.9\n20,loose,14.5\n20,hard,13.6\n"
HEAD = "radius_mm,state,water_ml\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("radius_mm,state\n15,loose\n", ("water", "radius_mm,state,water_ml")),
        ("radius_mm,water_ml\n15,6\n", ("state",)),
        ("radius_kg,state,water_ml\n" + ROWS, ("kg",)),
        ("radius_mm,state,water_kg\n" + ROWS, ("water_kg", "water_ml")),
        (HEAD + ROWS, ("only 2", "at least 3")),
        (HEAD + ROWS + "30,loose,47\n", ("30 mm", "line 6", "'hard'")),
        (HEAD + ROWS + "30,lose,47\n", ("line 6", "'lose'", "did you mean 'loose'")),
        (HEAD + ROWS + "1,loose,0.0016\n1,hard,0.0015\n", ("3.4 mm", "1 mm", "units")),
        (HEAD + ROWS + "30,loose,\n", ("line 6", "water_ml")),
        (HEAD + ROWS + "30,loose,4700\n", ("line 6", "4700", "30 mm")),
        (HEAD.replace("mm", "m") + ROWS, ("line 2", "6.3 ml", "15000 mm", "0.95", "units")),
    ],
)
def test_refused_with_what_to_measure(text: str, said: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "flasks.csv").write_text(text, encoding="utf-8")
    refused(labbook("study", "compaction", "flasks.csv", "--grain", "3.4", at=tmp_path), 2, *said)


def test_a_grain_size_that_is_none_or_of_another_unit_is_refused_or_said(tmp_path: Path) -> None:
    """Metres for millimetres; centimetres, or grains too large for the smallest flask."""
    (tmp_path / "flasks.csv").write_text(flasks(np.random.default_rng(3)), encoding="utf-8")
    asked = ("study", "compaction", "flasks.csv", "--grain")
    refused(labbook(*asked, "-1", at=tmp_path), 2, "--grain")
    refused(labbook(*asked, "0.0034", at=tmp_path), 2, "0.0034", "0.05 mm", "3.4")
    says(good(labbook(*asked, "7", at=tmp_path)).out, "7 mm", "a third", "20 mm")
    assert "a third" not in good(labbook(*asked, "6", at=tmp_path)).out
