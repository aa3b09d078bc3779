"""`labbook stats`: what is read and left out is told, and a test by day says what it counts."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook, refused
from tests.helpers.wording import says

BY = ("--value", "v", "--by", "g", "--day", "day")
TABLE = "v,g\n1,a\n2,a\n3,b\n5,b\n"


def blocked(folder: Path, rows: str, *words: str) -> list[str]:
    path = folder / "data.csv"
    path.write_text("v,g,day\n" + "\n".join(rows.split()) + "\n", encoding="utf-8")
    return good(labbook("stats", "blocked", path, *BY, *words, at=folder)).out.splitlines()


def test_rows_without_a_value_and_without_a_label_are_counted_apart(tmp_path: Path) -> None:
    rows = "1,a,1 ,a,1 NA,a,2 2,a,2 3.5,a,1 4,b,1 5,b,2 nan,b,2 7,b,1 8,,1 ,b,"
    said = blocked(tmp_path, rows, "--missing", "drop")
    says(said[0], "n = 6", "3 missing")
    says(said, "5", "11 rows", "3 lack", "2 lack", "'g'")
    one = blocked(tmp_path, "1,a,1 2,a,2 3,b,1 5,b,2 8,,1", "--missing", "drop")
    assert "missing" not in one[0]
    says(one, "5 rows", "1 lacks", "'g'", "'day'")


def test_a_single_day_is_no_random_effect_and_bounds_the_claim(tmp_path: Path) -> None:
    said = blocked(tmp_path, "1,a,1 2,a,1 4,a,1 3,b,1 5,b,1 9,b,1 7,b,1")
    says(said[0], "conditions scatter alike")
    assert "random effect" not in said[0]
    says(said, "note:", "of one day", "that day")


def test_where_days_are_confounded_no_test_stands_that_counts_values(tmp_path: Path) -> None:
    alike = "1,a,1 4,a,1 2,a,2 3.1,a,2 5,b,3 2.5,b,3 4,b,4 3.3,b,4"
    said = blocked(tmp_path, alike)
    assert "F(1, 2)" in said[0]
    assert "F(1, 6)" not in said[0]
    says(said[0], "each day counts")
    says(said, "note:", "REML", "variance at 0")
    apart = blocked(tmp_path, "1,a,1 1.2,a,1 4,a,2 4.3,a,2 5,b,3 5.2,b,3 9,b,4 9.1,b,4")
    says(apart[0], "a random effect", "F(1, 2)")
    assert not any("REML puts" in line for line in apart if line.startswith("note: "))


def test_days_estimated_alike_are_told_where_the_model_counts_values(tmp_path: Path) -> None:
    said = blocked(tmp_path, "1,a,1 2,a,2 3.5,a,1 4,b,1 5,b,2 7,b,1")
    says(said[0], "not to differ")


def test_text_in_utf_16_with_its_mark_is_read_and_other_pages_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    words = ("stats", "compare", path, *BY[:4])
    path.write_text(TABLE, encoding="utf-8")
    expected = good(labbook(*words, at=tmp_path)).out
    path.write_bytes(TABLE.encode("utf-16"))
    assert good(labbook(*words, at=tmp_path)).out == expected
    path.write_bytes("v,g\n1,\u00fc\n".encode("cp1252"))
    refused(labbook(*words, at=tmp_path), 2, "UTF-16 with a byte order mark", "Windows-1252")
    path.write_bytes(TABLE.encode("utf-16")[:-1])
    refused(labbook(*words, at=tmp_path), 2, "is not UTF-8 text")


def test_groups_that_differ_in_capitals_only_and_points_of_thousands_are_told(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    path.write_text("v;g\n1.234,5;AD\n1.240,0;ad\n1.100,0;CE\n1.120,5;CE\n", encoding="utf-8")
    notes = good(labbook("stats", "compare", path, *BY[:4], "--decimal", ",", "--json", at=tmp_path)).json["notes"]
    says(notes, "capital letters count", "'AD'", "'ad'")
    says(notes, "--decimal", "'1.234,5'")


def test_points_that_could_be_thousands_are_told(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    path.write_text("v;g;k\n1.234;AD;1\n5.678;AD;1\n1.5;AD;2\n2.345;CE;1\n6.789;CE;1\n", encoding="utf-8")
    words = ("stats", "compare", path, *BY[:4], "--where", "k=1", "--json")
    found = good(labbook(*words, at=tmp_path)).json
    said = "Points are read as decimals and could be thousands: '1.234'; --decimal , or --decimal . says which."
    assert said in found["notes"]
    assert found["comparisons"][0]["mean_b"] == 3.456
    for sign, mean in ((".", 3.456), (",", 3456.0)):
        declared = good(labbook(*words, "--decimal", sign, at=tmp_path)).json
        assert said not in declared["notes"]
        assert declared["comparisons"][0]["mean_b"] == mean
    every = good(labbook(*words[:-3], "--json", at=tmp_path)).json  # 1.5 is a decimal, and so are the others
    assert said not in every["notes"]


def test_an_alpha_in_percent_is_refused_with_how_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    path.write_text(TABLE, encoding="utf-8")
    for alpha in ("5", "0", "1", "nan"):
        refused(
            labbook("stats", "compare", path, *BY[:4], "--alpha", alpha, at=tmp_path), 2, "for example 0.05 for 5 %"
        )


@pytest.mark.parametrize("words", [("compare",), ("anova",), ("savings",), ("equivalence", "--low=-1", "--high=1")])
def test_a_control_without_values_leaves_nothing_to_compare(words: tuple[str, ...], tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    path.write_text("v,g,day\n,a,1\n,a,2\n1,b,1\n2,b,2\n2.5,b,1\n3,c,1\n5,c,2\n", encoding="utf-8")
    common = (path, *BY, "--control", "a", "--missing", "drop")
    said = good(labbook("stats", words[0], *common, *words[1:], at=tmp_path)).out
    assert re.search("group a is empty|the control is empty", said)
    says(said, "7 rows", "2 lack")
    assert "`labbook stats blocked`" not in said
    refused(labbook("stats", "blocked", *common, at=tmp_path), 2, "the control 'a' has no values", "--control")
