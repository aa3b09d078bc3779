"""docs/statistics.md shows what its tables hold, and the digits there are those that programs give today."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from benchmarks.stats_evidence.document import FOLDER, PAGE, SHOWN_WEAKNESSES, TABLES, page, read
from benchmarks.stats_evidence.sizes.design import Design
from benchmarks.stats_evidence.sizes.record import design_of, every_rate
from stats.planning.recorded import Recorded
from tests.helpers.wording import says

PROJECT = Path(__file__).parents[2]
OTHER_PROCESSOR = 2.5
"""Digits that linear algebra for another processor may move of another program's number: 1.9 of five kernels tried."""


def measured() -> list[dict[str, str]]:
    """In a process of its own, as the command that writes the table does."""
    code = "import json; from benchmarks.stats_evidence.digits.rows import rows; print(json.dumps(rows()))"
    done = subprocess.run([sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True, check=True)
    found: list[dict[str, str]] = json.loads(done.stdout)
    return found


def number(digits: str) -> float:
    return 0.0 if digits == "none" else float(digits)


@pytest.mark.soak
@pytest.mark.skipif(importlib.util.find_spec("pingouin") is None, reason="comparing with pingouin needs it")
def test_the_digits_come_out_as_they_are_written() -> None:
    of_labbook = Counter[str]()
    for row, again in zip(read("digits"), measured(), strict=True):
        assert {**row, "digits": ""} == {**again, "digits": ""}
        if row["program"] == "labbook":
            promised = 12.0 if row["quantity"].startswith("p of") else 14.0
            assert min(float(row["digits"]), float(again["digits"])) >= promised
            of_labbook[row["quantity"]] += 1
        else:
            assert abs(number(row["digits"]) - number(again["digits"])) <= OTHER_PROCESSOR, (row, again)
    assert of_labbook == {
        **dict.fromkeys(("mean", "standard deviation", "autocorrelation at lag 1"), 9),
        "F": 11,
        "p of F": 8,
        "log10 of p of F": 3,
        **dict.fromkeys(("worst coefficient", "worst standard error"), 11),
        **dict.fromkeys(("t", "p of t"), 7),
    }


def test_the_page_is_short_and_shows_what_its_tables_hold() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert page(text) == text
    assert text.count("<!-- from ") == text.count("<!-- end -->") == len(TABLES)
    assert sorted(path.stem for path in FOLDER.iterdir()) == sorted(TABLES)
    assert all(f"(statistics/{name}.csv)" in text for name in TABLES)
    assert len(text.replace("|", " ").split()) < 1550


def span(rows: list[Recorded]) -> tuple[str, str]:
    """The smallest and the largest share, as the page writes them."""
    least, most = (f"{share(row.value for row in rows):.2f}"[1:] for share in (min, max))
    return least, most


def test_shares_in_the_text_are_those_of_the_table() -> None:
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    rates = every_rate()
    three = [row for row in rates if design_of(row) == Design((3, 3))]
    covers = {row.method: span([row])[0] for row in three}
    says(
        text,
        "interval still covers",
        covers["difference_ci_welch"],
        "BCa do not",
        covers["bootstrap_percentile"],
        covers["bootstrap_bca"],
    )
    rejects = [row for row in rates if row.method == "brown_forsythe" and row.n in ((3, 3), (5, 5))]
    assert max(row.value for row in rejects) < 0.02
    welch = [row for row in rates if row.method == "welch"]
    weak = [row for row in welch if row.weak and not row.days]
    assert all(min(row.n) <= 3 and len({*row.n}) == 2 for row in weak)
    assert "two or three runs stand against more ({} to {})".format(*span(weak)) in text
    shared = [row for row in welch if row.layout == "shared" and row.days != 1 and row.n[0] == row.n[1]]
    assert "safe ({} to {})".format(*span([row for row in shared if row.sd_ratio == 1.0])) in text
    with_line = ("mean_ci_shared", "difference_ci_welch_shared", "fieller_shared")
    of_line = [row for row in rates if row.method in with_line]
    assert "cover {} to {}; with fewer".format(*span([row for row in of_line if row.idle_runs >= 6])) in text
    assert "until they cover {} to {}.".format(*span([row for row in of_line if row.idle_runs < 6])) in text


def test_each_wrong_answer_on_the_page_came_from_a_program_without_a_warning() -> None:
    silent = {(row["case"], row["question"]) for row in read("weaknesses") if row["silent"] == "yes"}
    assert silent >= set(SHOWN_WEAKNESSES)


def test_nothing_took_five_times_as_long_as_scipy() -> None:
    over_scipy = [float(row["labbook_over_program"]) for row in read("speed") if row["program"] == "scipy"]
    assert len(over_scipy) == 22 * 4
    assert max(over_scipy) < 5.0
