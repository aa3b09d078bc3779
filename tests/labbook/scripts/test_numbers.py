"""Stand-alone scripts give the numbers of reports again, without labbook."""

from __future__ import annotations

import random
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from labbook.actions.report_command import state_report
from labbook.analysis.comparison.order import ADJUSTED
from labbook.book.opening import opened
from labbook.demo.running import make_study
from labbook.scripts.kinds import KINDS
from labbook.scripts.writing import R, facts_of, numbers_printed, script_of
from tests.helpers.books import ADA, reported_book
from tests.helpers.charged_book import Made, charged_book
from tests.helpers.demos import made_demo
from tests.helpers.scripts import differs, numbers_of_last_report, one_of_each, run_all, write_all


def test_every_number_of_a_book_of_two_days(tmp_path: Path) -> None:
    with reported_book(tmp_path / "book").open() as book:
        numbers = numbers_of_last_report(book)
        known = {uid: one for uid, one in numbers.items() if one.number.value is not None}
        written = list(write_all(book, known, tmp_path / "scripts"))
    assert len(written) > 100
    assert [each for number, printed in run_all(written) for each in differs(number, printed)] == []


@pytest.mark.parametrize("demo", ["two_runs_a_condition", pytest.param("demonstration", marks=pytest.mark.soak)])
def test_a_number_of_every_kind_of_the_demonstration(demo: str, tmp_path: Path) -> None:
    with opened(Path(made_demo(demo).book)) as book:
        numbers = numbers_of_last_report(book)
        some = one_of_each(numbers)
        if demo == "demonstration":
            uids = [uid for uid, one in numbers.items() if one.number.value is not None]
            some |= {uid: numbers[uid] for uid in random.Random(0).sample(uids, 50)}
        written = list(write_all(book, some, tmp_path))
    expected = set(KINDS) - ({"overall_savings"} if demo == "two_runs_a_condition" else set())
    assert {one.numbers.result_of(one.number).kind for one in some.values()} >= expected
    assert [each for number, printed in run_all(written) for each in differs(number, printed)] == []


@pytest.mark.soak
@pytest.mark.parametrize("study", ["force-plate", "emulator", "bed"])
def test_fifty_numbers_of_the_report_of_each_study_of_runs(study: str, tmp_path: Path) -> None:
    make_study(study, tmp_path / "demo", 1, lambda _step: None, lambda _line: None)
    with opened(tmp_path / "demo" / "book") as book:
        state_report(book, None, ADA, lambda _step: None)
        numbers = numbers_of_last_report(book)
        uids = [uid for uid, one in numbers.items() if one.number.value is not None]
        some = {uid: numbers[uid] for uid in random.Random(0).sample(uids, 50)}
        written = list(write_all(book, some, tmp_path / "scripts"))
    assert [each for number, printed in run_all(written) for each in differs(number, printed)] == []


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="Rscript is not installed")
def test_scripts_in_r_print_the_same(tmp_path: Path) -> None:
    with reported_book(tmp_path / "book").open() as book:
        numbers = numbers_of_last_report(book)
        some = one_of_each(numbers)
        with facts_of(book, next(iter(some.values())).shown_in[-1], lambda _step: None) as facts:
            scripts = {uid: script_of(one, facts) for uid, one in some.items()}
        computed = {(*script.steps[1:], script.settings.get("PICKED")): uid for uid, script in scripts.items()}
        some = {uid: numbers[uid] for uid in computed.values()}
        written = list(write_all(book, some, tmp_path / "scripts", in_r=True))
    assert len(written) > 20
    for number, folder in written:
        done = subprocess.run(["Rscript", str(folder / R)], capture_output=True, text=True, check=True, timeout=60)
        assert differs(number, numbers_printed(done.stdout)) == []


@pytest.mark.parametrize("sd_j", [3.0, 0.8])
def test_groups_whose_controls_come_first_and_runs_that_are_rounded_alike(sd_j: float, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    order = [(foot, gain) for foot in ("small", "large") for gain in (0, 0, 100, 100)]
    runs = [
        Made(day, foot, gain, 80.0 + (gain == 0) * 6.0 + sd_j * float(rng.normal()))
        for day in range(5)
        for foot, gain in order
    ]
    made = charged_book(tmp_path / "book", runs)
    with made.open() as book:
        state_report(book, None, ADA, lambda _step: None)
        numbers = numbers_of_last_report(book)
        some = one_of_each(numbers)
        written = list(write_all(book, some, tmp_path / "scripts"))
    overall = {
        str(one.numbers.result_of(one.number).scope.get("variant", ""))
        for one in some.values()
        if one.numbers.result_of(one.number).kind == "overall_savings"
    }
    assert overall == {"", ADJUSTED}
    tables = [(folder / "runs.csv").read_text() for _number, folder in written]
    assert any(",yes" in table for table in tables) == (sd_j < 1.0)
    assert [each for number, printed in run_all(written) for each in differs(number, printed)] == []
