"""What moved between two reports is told with what moved it: said by people, read from files, or another version."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from data_schema.vocabulary import Undefined
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.files.stored_files import withdraw
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct, unvoid, void
from labbook.actions.runs.jump_review import decide
from labbook.actions.upkeep.report_differences import (
    CauseKind,
    MovedNumber,
    ReportsCompared,
    compare_reports,
    report_named,
)
from labbook.analysis.comparison.pairing import POOLED
from labbook.analysis.outcomes import run_apexes
from labbook.book.opening import Book
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import ADA, BEN, SmallBook, copy_of, ingest_all, small_book
from tests.helpers.databases import server_in_a_soak
from tests.helpers.statements import state
from tests.helpers.wording import says

LATE = "r012"
"""The run whose log comes after the first report."""
CONTROL, TREATED = "foot=small k_gain=400 b_ad_gain=0", "foot=small k_gain=400 b_ad_gain=100"
"""The condition of r001, r006, r009 and r014, and that of r002, r004, r010 and the late run."""


def report(book: Book, where: str | None = None) -> None:
    state_report(book, where, ADA, lambda _step: None)


def compared(book: Book, before: str = "last-1", after: str = "last") -> ReportsCompared:
    with book.reading() as connection:
        return compare_reports(book, connection, report_named(connection, before), report_named(connection, after))


def moved_by(found: ReportsCompared, of: Callable[[MovedNumber], bool]) -> list[set[CauseKind]]:
    """The kinds of causes of each number that moved and is meant."""
    return [{found.causes[place].kind for place in one.causes} for one in found.moved if of(one)]


def mean(quantity: str, condition: str) -> Callable[[MovedNumber], bool]:
    about = {f"quantity={quantity}", f"condition={condition}", "selection="}

    def is_it(one: MovedNumber) -> bool:
        kind, _, rest = one.now.path.partition("/")
        scope, _, name = rest.rpartition("/")
        return (kind, set(scope.split(",")), name) == ("condition_summary", about, "mean")

    return is_it


def is_headline(one: MovedNumber) -> bool:
    """Whether it is a savings that the answer of a report states, over all groups or of one."""
    kind, _, rest = one.now.path.partition("/")
    of_group = kind == "decision" and f"family={POOLED}" in rest.split(",")
    return one.now.name == "savings" and "variant=" not in rest and (of_group or kind == "overall_savings")


def raise_apexes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a newer version of the algorithm find every apex 1 mm higher."""
    found, newer = run_apexes._apexes, replace(run_apexes.ALGORITHM, version=run_apexes.ALGORITHM.version + 1)

    def higher(*given: Any) -> run_apexes.RunApexes:
        apexes = found(*given)
        height = apexes.apex_height
        assert not isinstance(height.value, Undefined)
        return replace(apexes, apex_height=replace(height, value=height.value + 1e-3))

    monkeypatch.setattr(run_apexes, "ALGORITHM", newer)
    monkeypatch.setattr(run_apexes, "_apexes", higher)


@pytest.fixture
def before(tmp_path: Path) -> SmallBook:
    """A book with a report, made before the log of one run was ingested."""

    def made(folder: Path) -> SmallBook:
        small = small_book(folder, ingested=False, two_people=True)
        late = small.log(LATE).rename(folder / "late.csv")
        with small.open() as book:
            ingest_all(book, small.instruments)
            report(book)
        late.rename(small.log(LATE))
        return small

    return copy_of("reported-before-the-last-log", made, tmp_path)


def test_a_correction_a_verdict_a_file_and_a_version_are_told_apart(
    before: SmallBook, monkeypatch: pytest.MonkeyPatch
) -> None:
    with before.open() as book:
        state(book, correct, "r004", ["duration_s=780"], "typed wrong", person=BEN)
        state(book, decide, "r002", [1], "reject", "touched_by_hand", "saw it", person=BEN)
        ingest_file(book, before.log(LATE), IngestRequest(person=ADA))
        raise_apexes(monkeypatch)
        report(book)
        found = compared(book)
    assert [(one.kind, one.person) for one in found.causes] == [
        (CauseKind.CORRECTION, BEN),
        (CauseKind.VERDICT, BEN),
        (CauseKind.FILE, ADA),
        (CauseKind.VERSION, None),
    ]
    assert all(one.moved > 0 for one in found.causes)
    assert all(one.causes for one in found.moved)
    assert moved_by(found, mean("joules a jump", TREATED)) == [{CauseKind.CORRECTION}]
    assert moved_by(found, mean("joules a jump", CONTROL)) == []
    assert moved_by(found, mean("apex height", CONTROL)) == [{CauseKind.VERSION}]
    assert moved_by(found, mean("apex height", TREATED)) == [set(CauseKind) & {one.kind for one in found.causes}]
    headlines = [is_headline(one) for one in found.moved]
    assert any(headlines)
    assert headlines == sorted(headlines, reverse=True)
    told = good(labbook("reports", "diff", "1", "2", at=before.folder)).out
    first, *lines = told.splitlines()
    counts = f"{len(found.moved)} of {found.common} numbers"
    says(first, counts, "1 correction", "1 verdict", "1 file", "1 algorithm")
    for said in (
        'run r004: duration_s 720 to 780, "typed wrong" (Ben Ode, ',
        "of run r002 rejected, touched_by_hand",
        f"{LATE}.csv ingested",
        f"run_apexes {run_apexes.ALGORITHM.version - 1} to {run_apexes.ALGORITHM.version}",
    ):
        assert sum(said in line for line in lines) == 1, (said, told)


@server_in_a_soak("book")
def test_nothing_moves_where_nothing_was_said(book: SmallBook) -> None:
    with book.open() as standing:
        report(standing)
        report(standing)
        found = compared(standing)
        state(standing, correct, "r004", ["duration_s=780"], "typed wrong")
        report(standing)
        (cause,) = compared(standing).causes
    assert (found.moved, found.only_before, found.only_after, found.causes) == ((), (), (), ())
    assert found.common == found.before.numbers == found.after.numbers > 0
    assert cause.moved > 0
    told = good(labbook("reports", "diff", "1", "last-1", at=book.folder)).out
    assert told.startswith(f"None of {found.common} numbers moved.\n")
    same = good(labbook("reports", "diff", "last", "last", "--json", at=book.folder)).json
    assert same["moved"] == []


def test_what_was_taken_away_or_back_and_a_change_of_labbook_toml_are_causes(before: SmallBook) -> None:
    with before.open() as book:
        state(book, decide, "r004", [1], "reject", "touched_by_hand", None)
        state(book, decide, "r004", [1], "clear", "other", None)
        state(book, withdraw, "r001.csv", "of another robot")
        state(book, void, "r006", "foot came loose")
    before.rewrite("exclude_first_jumps = 0", "exclude_first_jumps = 1")
    with before.open() as book:
        report(book)
        found = compared(book)
        state(book, unvoid, "r006", "it was tight")
        report(book)
        (again,) = compared(book).causes
    assert [(one.kind, one.moved > 0) for one in found.causes] == [
        (CauseKind.VERDICT, False),
        (CauseKind.VERDICT, False),  # it was taken back
        (CauseKind.FILE, True),
        (CauseKind.VOID, True),
        (CauseKind.CONFIGURATION, True),
    ]
    assert [one.what for one in (*found.causes[2:4], again)] == [
        "r001.csv withdrawn",
        "run r006 declared void",
        "run r006 counts again",
    ]
    assert moved_by(found, mean("joules a jump", CONTROL)) == [{CauseKind.VOID}]
    assert moved_by(found, mean("apex height", TREATED)) == [{CauseKind.CONFIGURATION}]
    assert all(one.causes for one in found.moved)


def test_reports_are_called_by_number_place_and_id(before: SmallBook) -> None:
    (first,) = good(labbook("reports", "list", "--json", at=before.folder)).json
    assert (first["number"], first["person"], first["selection"]) == (1, ADA, "")
    listed = good(labbook("reports", "list", at=before.folder)).out.splitlines()[1]
    assert first["uid"] in listed
    assert re.search(rf" {first['numbers']} +all runs$", listed)
    shown = good(labbook("reports", "show", "1", at=before.folder)).out
    assert f"run_apexes {run_apexes.ALGORITHM.version}" in shown
    for name in ("last", first["uid"], first["uid"][:5]):
        assert good(labbook("reports", "show", name, at=before.folder)).out == shown
    numbers = good(labbook("reports", "show", "last", "--json", at=before.folder)).json["numbers"]
    assert len(numbers) == first["numbers"]
    refused(labbook("reports", "show", "lsat", at=before.folder), 2, "'lsat' is not a known report", "mean 'last'")
    refused(labbook("reports", "diff", "last-1", "last", at=before.folder), 2, "'last-1'", "`labbook reports list`")
    refused(labbook("reports", "diff", "1", "99", at=before.folder), 2, "'99' is not a known report: there is 1.")
