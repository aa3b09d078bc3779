"""`labbook study field`: a known ratio found again from walks of two robots, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.validation_document import STUDIES, covered, outside
from ingest.formats.study_sheets import read_walks
from ingest.tables.sheet import SheetFile
from labbook.studies.field import FieldStudy, field_study
from simulator.steady.published_results import published_numbers
from tests.cli.shell import good, labbook, refused
from tests.helpers.study_pages import study_page

HEAD = "walk,robot,mass_kg,distance_m,energy_Wh\n"


def read(text: str) -> FieldStudy:
    """What a sheet says."""
    return field_study(read_walks(SheetFile("walks.csv", text.encode(), decimal=".")))


@pytest.mark.soak
def test_intervals_cover_the_ratio() -> None:
    """The count lies in the 99.9 % binomial band, though walks differ ten times as much as robots scatter."""
    assert not outside(covered(STUDIES["field"], 1000))


def test_energies_and_charges_in_any_units_are_the_same() -> None:
    rows = [("a", "x", 8, 400, 10), ("a", "y", 9, 400, 9), ("b", "x", 8, 300, 8), ("b", "y", 9, 300, 7)]
    text = HEAD + "".join(f"{walk},{robot},{kg},{m},{wh}\n" for walk, robot, kg, m, wh in rows)
    other = "Walk;Robot;Mass (g);Distance [km];charge_mAh;voltage_V\n" + "".join(
        f"{walk};{robot};{kg * 1000};{m / 1000};{wh / 16.8 * 1e3:.14g};16.8\n" for walk, robot, kg, m, wh in rows
    )
    found, same = read(text), read(other)
    assert found.robots[0].walks["a"] == pytest.approx(36000.0 / (8.0 * 9.80665 * 400.0), rel=1e-12)
    for one, again in zip(found.robots, same.robots, strict=True):
        assert one.walks == pytest.approx(again.walks, rel=1e-12)


LOG_HEAD = "walk,robot,mass_kg,distance_m,log\n"


def logged(tmp_path: Path, log: str, head: str = "time_s,power_W\n") -> Path:
    """A sheet of one walk whose robots have logs: one as given, the other of 10 W over 100 s."""
    (tmp_path / "a.csv").write_text(head + log, encoding="utf-8")
    (tmp_path / "b.csv").write_text("time_ms;power_W\n0;10\n50000;10\n100000;10\n", encoding="utf-8")
    (tmp_path / "walks.csv").write_text(LOG_HEAD + "w,thin,8,10,a.csv\nw,wide,8,10,b.csv\n", encoding="utf-8")
    return tmp_path


def test_energies_are_integrals_of_logged_power(tmp_path: Path) -> None:
    """Power that rises by straight pieces is integrated exactly: (0 + 10) / 2 times 4 s and 10 times 6 s."""
    current = "time_s,current_mA,voltage_v\n"
    for head, rows in (("time_s,power_w\n", "0,0\n4,10\n10,10\n"), (current, "0,0,20\n4,500,20\n10,500,20\n")):
        at = logged(tmp_path, rows, head)
        found = good(labbook("study", "field", "walks.csv", "--json", at=at)).json
        assert found["ratio"]["geometric_mean"] == pytest.approx(1000.0 / 80.0, rel=1e-12)


@pytest.mark.parametrize(
    ("log", "said"),
    [
        ("0,5\n1,5\n1,5\n", "does not rise"),
        ("0,5\n", "does not rise"),
        ("".join(f"{second},5\n" for second in (*range(50), *range(80, 130))), "nothing stands for 31 s"),
        ("0,-5\n1,-5\n", "turn the current's sign"),
    ],
)
def test_a_log_without_an_energy_is_refused(tmp_path: Path, log: str, said: str) -> None:
    refused(labbook("study", "field", "walks.csv", at=logged(tmp_path, log)), 2, "a.csv", said)


def test_a_log_needs_power_and_a_sheet_one_way_to_say_energies(tmp_path: Path) -> None:
    at = logged(tmp_path, "0,5\n1,5\n", "time_s,speed\n")
    refused(labbook("study", "field", "walks.csv", at=at), 2, "a.csv", "power_W")
    (at / "walks.csv").write_text(LOG_HEAD.replace("log", "log,energy_Wh") + "w,thin,8,400,b.csv,1\n", encoding="utf-8")
    refused(labbook("study", "field", "walks.csv", at=at), 2, "energies and logs")


def test_the_page_works_as_it_says(tmp_path: Path) -> None:
    page = study_page("field.md")
    (tmp_path / "walks.csv").write_text(page.sheet, encoding="utf-8")
    assert good(labbook(*page.words, at=tmp_path)).out == f"{page.said}field.pdf\n"
    assert (tmp_path / "field.pdf").read_bytes().startswith(b"%PDF")


def test_one_walk_has_numbers_and_no_interval(tmp_path: Path) -> None:
    (tmp_path / "walks.csv").write_text(HEAD + "a,thin,8,430,12\na,wide,8,430,10\n", encoding="utf-8")
    found = good(labbook("study", "field", "walks.csv", "--plot", "a.png", "--json", at=tmp_path)).json
    assert found["ratio"]["geometric_mean"] == pytest.approx(10 / 12)
    assert "reason" in found["ratio"]["ci"]
    assert (tmp_path / "a.png").exists()


def test_equal_robots_have_no_interval_for_a_reason(tmp_path: Path) -> None:
    rows = "a,x,8,430,12\na,y,8,430,12\nb,x,8,300,9\nb,y,8,300,9\n"
    (tmp_path / "walks.csv").write_text(HEAD + rows, encoding="utf-8")
    assert "y needed as much as x; no interval: " in good(labbook("study", "field", "walks.csv", at=tmp_path)).out


ROWS = "a,thin,8,430,12\na,wide,8,430,10\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", ("walk,robot,mass_kg",)),
        ("walk,robot,mass_kg,distance_m\na,thin,8,430\n", ("energies", "charge_mAh")),
        ("walk,robot,distance_m,energy_Wh\na,thin,430,12\n", ("mass",)),
        (HEAD.replace("walk", "day") + ROWS, ("walk",)),
        (HEAD.replace("Wh", "mAh") + ROWS, ("energy_mAh", "charge_mAh,voltage_V")),
        (HEAD + "a,thin,8,430,12\na,wide,8,43,10\n", ("'a'", "430 m (line 2)", "43 m (line 3)")),
        (HEAD.replace("mass_kg", "mass_g") + ROWS, ("mass_g", "0.02 kg", "unit")),
        (HEAD + ROWS + "b,thin,8,300,9\n", ("'wide'", "'b'", "line 4")),
        (HEAD + ROWS + "a,wide,8,300,9\n", ("line 4", "line 3", "drop the copy")),
        (LOG_HEAD + "a,thin,8,430,a.csv\na,wide,8,430,a.csv\n", ("line 3", "that of line 2")),
        (HEAD + ROWS + "a,other,8,300,9\n", ("line 4", "'other'", "two robots")),
        (HEAD + "a,thin,8,0,12\na,wide,8,430,10\n", ("line 2", "distance_m")),
        (HEAD + ",thin,8,4,12\na,wide,8,430,10\n", ("line 2", "walk")),
    ],
)
def test_refused_with_what_to_write(text: str, said: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "walks.csv").write_text(text, encoding="utf-8")
    refused(labbook("study", "field", "walks.csv", at=tmp_path), 2, *said)


def test_the_thesis_s_values_stand_beside_in_words_data_and_figure(tmp_path: Path) -> None:
    (tmp_path / "walks.csv").write_text(HEAD + ROWS + "b,thin,8,300,9\nb,wide,8,300,8\n", encoding="utf-8")
    assert "The thesis: 1.3 thin and 1.1 wide" in good(labbook("study", "field", "walks.csv", at=tmp_path)).out
    found = read(HEAD + ROWS.replace("thin", "RHex_THIN2").replace("wide", "everything"))
    thin, other = found.robots
    assert thin.published == published_numbers()["field.sr_thin"]
    assert other.published is found.ratio.published is None
    assert found.ratio.name == "everything / RHex_THIN2"
    assert found.ratio.walks["a"] == pytest.approx(other.walks["a"] / thin.walks["a"])
