"""Control limits come from the other runs of a condition, and are the same wherever they are told."""

from __future__ import annotations

import random
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from scipy.stats import binomtest
from scipy.stats import t as student

from data_schema.queries.runs import RunRow, list_runs
from data_schema.vocabulary import RunKind
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.rig_line import rig_lines_of_runs
from labbook.analysis.outcomes.control_limits import limits_of, runs_outside
from reports.trust import trust_sentences
from tests.helpers.attention import found_in
from tests.helpers.books import ADA, small_book
from tests.helpers.charged_book import Made, charged_book
from tests.helpers.decided import reports
from tests.helpers.wording import says


@pytest.fixture
def run(tmp_path: Path) -> RunRow:
    with small_book(tmp_path, ingested=False).open() as book, book.reading() as connection:
        return next(run for run in list_runs(connection) if run.kind is RunKind.JUMPS)


def outside_of(runs: Sequence[RunRow], values: Mapping[str, float], steps: Mapping[str, float] = {}) -> list[str]:
    return [each.uid for each in runs_outside(runs, values, limits_of(runs, values, steps))]


def test_limits_are_those_of_a_prediction_interval_from_the_other_runs_of_a_condition(run: RunRow) -> None:
    draws = random.Random(5)
    runs = [replace(run, uid=f"{n}", condition_key=f"{n % 3 if n < 70 else n // 3}") for n in range(80)]
    values = {each.uid: draws.gauss(40.0, 3.0) for each in runs if each.uid != "30"}
    found = limits_of(draws.sample(runs, len(runs)), values)
    assert set(found) == set(values)
    for each in runs:
        if each.uid not in values:
            continue
        others = [
            values[other.uid]
            for other in runs
            if other.uid in values and other.condition_key == each.condition_key and other.uid != each.uid
        ]
        assert found[each.uid].n == len(others)
        ends = found[each.uid].ends
        assert (ends is not None) is (len(others) >= 3)
        if ends is not None:
            middle, sd = statistics.mean(others), statistics.stdev(others) * (1.0 + 1.0 / len(others)) ** 0.5
            width = float(student.ppf(1.0 - 0.00135, len(others) - 1)) * sd
            assert ends == pytest.approx((middle - width, middle + width), rel=1e-9)


@pytest.mark.soak
@pytest.mark.parametrize("n", [4, 6, 20])
def test_of_runs_that_are_alike_27_in_10_000_lie_outside(n: int, run: RunRow) -> None:
    draws, runs = random.Random(n), [replace(run, uid=f"{at}") for at in range(n)]
    campaigns = 40_000 // n
    outside = sum(
        uid == "0"
        for _ in range(campaigns * 4)
        for values in [{each.uid: draws.gauss(40.0, 3.0) for each in runs}]
        for uid in outside_of(runs, values)
    )
    assert binomtest(outside, campaigns * 4, 0.0027).pvalue > 1e-4


FIVE = [1160.5, 40.5, 41.3, 42.4, 40.9]
TWO = [41.9, 40.5, 37.7, 396.0, 41.1, 38.5, 433.0, 39.4, 42.2, 40.3]


@pytest.mark.parametrize(
    ("values", "outside"),
    [
        (FIVE, ["0"]),  # limits of earlier runs alone never looked at the first five
        ([61.2, *FIVE[1:]], ["0"]),
        ([1e300, *FIVE[1:]], ["0"]),
        ([0.1] * 9, []),  # no scatter, and none of their rounding
        ([0.1] * 7 + [0.2, 0.1], ["7"]),
        (TWO, ["3", "6"]),  # do not hide each other
    ],
)
def test_slips_are_found(values: list[float], outside: list[str], run: RunRow) -> None:
    runs = [replace(run, uid=f"{n}", position_in_day=n) for n in range(len(values))]
    assert outside_of(runs, {f"{n}": value for n, value in enumerate(values)}) == outside


@pytest.mark.parametrize(("away", "outside"), [(1, []), (-1, []), (2, ["7"]), (-2, ["7"])])
def test_limits_are_no_narrower_than_the_rounding_of_readings(away: int, outside: list[str], run: RunRow) -> None:
    """Others that were read alike gave limits of no width: a run one step away lay outside."""
    step = 3.6 * 15.4 / 96
    runs = [replace(run, uid=f"{n}") for n in range(8)]
    values = {f"{n}": step * (68 + (away if n == 7 else 0)) for n in range(8)}
    steps = dict.fromkeys(values, step)
    assert outside_of(runs, values, steps) == outside
    assert limits_of(runs, values, steps)["7"].ends == pytest.approx((67.0 * step, 69.0 * step))
    assert outside_of(runs, values, steps | {"7": step / 1000}) == ["7"]


def test_one_step_of_the_charger_is_within_the_limits_at_the_rig_and_in_the_report(tmp_path: Path) -> None:
    """It was `OUTSIDE the control limits 39.2 to 39.2 J`, for a mAh."""
    mah_j = 3.6 * 15.4 / 25
    made = [Made(day, "small", gain, 80.0) for day in range(4) for gain in (0, 100)]
    runs = [*made, Made(4, "small", 0, 80.0 + mah_j), Made(4, "small", 100, 80.0 + 3.0 * mah_j)]
    with charged_book(tmp_path, runs).open() as book:
        lines = rig_lines_of_runs(book, ["r001", "r009", "r010"])
        named = [one.run for one in found_in(book, day="2021-06-18").get("outside_limits", [])]
        content = state_report(book, None, ADA, lambda _step: None).results
    assert [line.run for line in lines if line.concern == "outside_limits"] == ["r010"]
    assert named == list(content.outside_limits) == ["r010"]


def test_a_run_outside_is_named_at_the_rig_in_the_day_and_in_the_report(tmp_path: Path) -> None:
    """It was named at ingest alone: who did not read that line did not learn of it."""
    with small_book(tmp_path).open() as book:
        with book.session(ADA) as session:
            for name in ("r003", "r004", "r005"):
                correct(book, session, name, ["foot=small", "b_ad_gain=0"], "the runs of this test")
            correct(book, session, "r014", ["mah=600"], "the run of this test")
        (line,) = rig_lines_of_runs(book, ["r014"])
        days = [found_in(book, day=day).get("outside_limits", []) for day in ("2021-06-14", "2021-06-16")]
        notes = trust_sentences(state_report(book, None, ADA, lambda _step: None).results)
    says(line.text, "OUTSIDE the control limits")
    assert [[one.run for one in day] for day in days] == [[], ["r014"]]
    says(list(notes), "1 run lies", "control limits", "r014")


@pytest.mark.parametrize("exchanged", [True, False])
def test_two_rows_of_a_sheet_that_were_exchanged_are_suggested(tmp_path: Path, exchanged: bool) -> None:
    """A jump of the control takes a quarter more, and runs scatter by 1 %; else two runs of a day are odd alike."""
    draws = random.Random(8)
    runs = [
        Made(day, "small", gain, draws.gauss(400.0 - 0.8 * gain, 4.0)) for day in range(4) for gain in (0, 0, 100, 100)
    ]
    if not exchanged:
        runs[5:7] = [replace(runs[5], joules=480.0), replace(runs[6], joules=250.0)]
    swapped = {"r006": "r007", "r007": "r006"} if exchanged else {}
    content = reports(charged_book(tmp_path, runs, exchanged=swapped)).results
    assert content.outside_limits == ("r006", "r007")
    assert content.exchanged_charges == ((("r007", "r006"),) if exchanged else ())
    assert ("exchanged" in " ".join(trust_sentences(content))) is exchanged
