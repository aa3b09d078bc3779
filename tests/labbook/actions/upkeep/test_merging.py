"""Two books of one study become one: nothing lost, nothing twice, nothing overwritten, or nothing at all."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from data_schema.errors import BookDamaged, InputRefused, UnknownName
from data_schema.queries.charges import charges_by_run
from data_schema.queries.detections import jump_decisions
from data_schema.queries.files import last_reading
from data_schema.queries.history import list_reports
from data_schema.queries.runs import list_runs
from data_schema.queries.signals import signals_of_runs
from data_schema.queries.study import PlannedEntry
from data_schema.vocabulary import Action, PlanMethod
from ingest.store import raw_path
from ingest.tables.sheet import SheetFile
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.files.rereading import RereadRequest, reread
from labbook.actions.files.stored_files import dismiss, list_files, restore, restore_item, show_file, withdraw
from labbook.actions.planning.plan import state_plan
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct, state_charge, unvoid, void
from labbook.actions.runs.jump_review import decide
from labbook.actions.runs.run_view import run_view
from labbook.actions.runs.runs_importing import import_runs
from labbook.actions.upkeep.merging import Merged, merge
from labbook.actions.upkeep.report_differences import report_named
from labbook.actions.upkeep.tracing import find_number, trace, trace_lines
from labbook.analysis.outcomes.detection import Detections
from labbook.book.making import make_book
from labbook.book.opening import Book
from labbook.book.report_numbers import read_numbers
from tests.cli.shell import contents, labbook, refused
from tests.helpers.attention import found_in
from tests.helpers.books import ADA, BEN, SmallBook, copy_of, instrument_files, small_book, small_toml
from tests.helpers.once import made_once
from tests.helpers.statements import in_table, note, said_alike, state
from tests.helpers.upkeep import health, rebuilt, rows_by_name
from tests.helpers.wording import refuses, says

HEAD, *ROWS = instrument_files()["runs.csv"].decode().splitlines(keepends=True)
FIRST_DAY, SECOND_DAY = ROWS[:8], ROWS[8:]

Work = Callable[[Book, SmallBook], object]


def state_runs(book: Book, rows: list[str], person: str = ADA) -> None:
    state(book, import_runs, SheetFile("runs.csv", (HEAD + "".join(rows)).encode()), person=person)


def take(book: Book, path: Path, person: str = ADA, run: str | None = None) -> None:
    ingest_file(book, path, IngestRequest(person=person, run=run))


def judge(book: Book, run: str, jump: int, verdict: str = "reject", person: str = ADA) -> None:
    reason = "touched_by_hand" if verdict == "reject" else "looks_right"
    state(book, decide, run, [jump], verdict, reason, None, person=person)


def change(book: Book, run: str, said: str, person: str = ADA) -> None:
    state(book, correct, run, [said], "misread", person=person)


def charge(book: Book, run: str, *parts_mah: float) -> None:
    for place, mah in enumerate(parts_mah):
        state(book, state_charge, run, mah, None, None, add=place > 0)


def declared_otherwise(book: Book, name: str, channel: str, person: str = ADA) -> None:
    with book.reading() as connection:
        row = last_reading(connection, show_file(connection, name).sha256)
    assert row is not None
    reread(book, row, RereadRequest({"columns": {"k_gain": {"channel": channel}}}, person))


def moved(book: Book, name: str, run: str) -> None:
    state(book, assign, name, run, "misnamed")


def first_day(folder: Path) -> SmallBook:
    """Make a book with the runs of the first day and two logs."""
    book = small_book(folder, runs=False, ingested=False, two_people=True)
    with book.open() as opened_book:
        state_runs(opened_book, FIRST_DAY)
        for run in ("r001", "r002"):
            take(opened_book, book.log(run))
    return book


@pytest.fixture
def lab(tmp_path: Path) -> SmallBook:
    """A book with the runs of the first day and two logs."""
    return copy_of("merging", first_day, tmp_path / "lab")


@pytest.fixture
def laptop(lab: SmallBook, tmp_path: Path) -> SmallBook:
    """A copy of it, taken to the field."""
    shutil.copytree(lab.folder, tmp_path / "laptop" / "book")
    return SmallBook(tmp_path / "laptop" / "book", lab.instruments)


def at_the_lab(book: Book, files: SmallBook) -> None:
    take(book, files.log("r003"))
    take(book, files.instruments / "charger" / "2021-06-14.csv")
    judge(book, "r001", 1)
    state(book, note, "the lab's remark", "r002")
    state(book, void, "r005", "foot came loose")


def in_the_field(book: Book, files: SmallBook) -> None:
    state_runs(book, SECOND_DAY, BEN)
    for run in ("r009", "r010", "r011"):
        take(book, files.log(run), BEN)
    take(book, files.instruments / "charger" / "2021-06-16.csv", BEN)
    judge(book, "r010", 2, person=BEN)
    judge(book, "r002", 1, person=BEN)
    change(book, "r004", "duration_s=700", BEN)
    state(book, note, "mud on the foot", "r009", person=BEN)
    state(book, assign, "r011.csv", "none", "not sure", person=BEN)
    state(book, assign, "r011.csv", "r011", None, person=BEN)
    declared_otherwise(book, "r009.csv", "aux", BEN)
    state(book, withdraw, "r002.csv", "of another robot", person=BEN)


def go_on(lab: SmallBook, laptop: SmallBook, here: Work = at_the_lab, there: Work = in_the_field) -> None:
    for book, work in ((lab, here), (laptop, there)):
        if work in (at_the_lab, in_the_field):  # of many tests: done once, to a copy of what `lab` gives
            made = made_once(f"merging-{work.__name__}", partial(_gone_on, work=work))
            shutil.rmtree(book.folder)
            shutil.copytree(made, book.folder)
        else:
            with book.open() as opened_book:
                work(opened_book, book)


def _gone_on(folder: Path, work: Work) -> Path:
    book = copy_of("merging", first_day, folder)
    with book.open() as opened_book:
        work(opened_book, book)
    return book.folder


def merged(into: SmallBook, other: SmallBook, *, dry_run: bool = False) -> Merged:
    with into.open() as book:
        return merge(book, other.folder, ADA, dry_run=dry_run)


def is_whole(folder: Path) -> None:
    """Every row is what raw copies and journal give: a rebuild beside the book has the same ones."""
    found = health(folder, deep=True)
    assert (found.problems, found.whole) == ((), True)


def test_what_the_laptop_says_comes_home(lab: SmallBook, laptop: SmallBook) -> None:
    go_on(lab, laptop)
    with lab.open() as book:
        before = in_table(book)
    with laptop.open() as book:
        theirs = in_table(book)
    there = contents(laptop.folder)
    done = merged(lab, laptop)
    assert contents(laptop.folder) == there
    with lab.open() as book, book.reading() as connection:
        entries = said_alike(book)
        statement, *came = entries[len(before) :]
        assert entries[: len(before)] == before
        assert (statement.action, statement.person, statement.following) == (Action.MERGE, ADA, len(came))
        assert [(one.origin, one.at_utc, one.person, one.action) for one in came] == [
            ({"seq": one.seq, "hash": one.hash}, one.at_utc, one.person, one.action) for one in theirs[done.common :]
        ]
        detections = Detections(connection, book.store)
        found = run_view(detections, book.configuration, "r009")
        says([one.text for one in found.notes], "on the foot")
        assert run_view(detections, book.configuration, "r004").run.duration_s == 700
        assert len(show_file(connection, "r009.csv").readings) == 2
        remarks = {item.reading.name: item.remark for item in list_files(connection)}
        says(remarks["r002.csv"], "withdrawn by", BEN)
        assert "r012" in {one.run for several in found_in(book, day="2021-06-16").values() for one in several}
        logs = [signal.sha256 for signal in signals_of_runs(connection)]
        said = [said for some in jump_decisions(connection, logs).values() for said in some]
        assert {(one.person, str(one.verdict)) for one in said} == {(ADA, "reject"), (BEN, "reject")}
    is_whole(lab.folder)


def test_numbers_of_merged_runs_lead_to_their_bytes(lab: SmallBook, laptop: SmallBook) -> None:
    def there(book: Book, files: SmallBook) -> None:
        in_the_field(book, files)
        state_report(book, None, BEN, lambda _step: None)

    go_on(lab, laptop, there=there)
    merged(lab, laptop)
    with lab.open() as book:
        with book.reading() as connection:
            (elsewhere,) = list_reports(connection)
            with refuses(UnknownName, "merged into this one", "ask there"):
                read_numbers(book.store.root, elsewhere)
            with refuses(UnknownName, "last", "no"):
                report_named(connection, "last")
        made = state_report(book, None, ADA, lambda _step: None)
        with book.reading() as connection:
            assert report_named(connection, "last").number == 2
            traced = [trace(connection, find_number(book, connection, uid)) for uid in sorted(made.shown)[:8]]
    said = " ".join(line for one in traced for line in trace_lines(one))
    assert "r010.csv" in said or "2021-06-16.csv" in said
    is_whole(lab.folder)


@pytest.mark.soak
def test_a_second_merge_adds_only_what_is_new_and_both_can_merge_each_other(lab: SmallBook, laptop: SmallBook) -> None:
    go_on(lab, laptop)
    first = merged(lab, laptop)
    before = contents(lab.folder)
    again = merged(lab, laptop)
    assert (sum(first.entries.values()) > 20, again.entries, again.conflicts) == (True, {}, ())
    assert contents(lab.folder) == before
    with lab.open() as book:
        change(book, "r004", "duration_s=720")
        change(book, "r009", "duration_s=500")
    with laptop.open() as book:
        state(book, note, "later", "r009", person=BEN)
    assert merged(lab, laptop).entries == {"note": 1}
    is_whole(lab.folder)
    assert merged(laptop, lab).entries["file"] == 2
    assert (merged(lab, laptop).entries, merged(laptop, lab).entries) == ({}, {})
    assert len(rows_by_name(lab.folder)["charge"]) == len(rows_by_name(laptop.folder)["charge"])
    is_whole(laptop.folder)


# --- what stands in the way


def plan_in(book: Book, seed: int) -> None:
    entries = [PlannedEntry(f"r0{number}", 1, "", None) for number in range(40, 43)]
    state(book, state_plan, seed, PlanMethod.RANDOMISED, entries)


def take_inbox(book: Book, files: SmallBook, run: str | None) -> None:
    """Ingest a charge of a run that is not stated yet, and say that it is another's, or nobody's."""
    path = files.folder.parent / "sheet.csv"
    lines = (files.instruments / "charger" / "2021-06-16.csv").read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:2]))
    take(book, path)
    state(book, *((dismiss, "sheet.csv#1", "nobody's") if run is None else (assign, "sheet.csv#1", run, None)))


def second_day(book: Book, _files: SmallBook, duration_s: str) -> None:
    """State the runs of the second day, the first of which lasted so long."""
    state_runs(book, [SECOND_DAY[0].replace(",720,", f",{duration_s},"), *SECOND_DAY[1:]])


def log_of(book: Book, files: SmallBook, log: str, run: str) -> None:
    take(book, files.log(log), run=run)


def read_with(book: Book, files: SmallBook, declared: dict[str, Any]) -> None:
    ingest_file(book, files.log("r003"), IngestRequest(person=ADA, options=declared))


def on_book(work: Callable[..., object], *first: object) -> Callable[..., object]:
    return lambda book, _files, *rest: work(book, *first, *rest)


AGAINST: dict[str, tuple[Callable[..., object], tuple[Any, ...], tuple[Any, ...], tuple[str, ...]]] = {
    "a run in both": (second_day, ("720",), ("700",), ("r009", "720", "700")),
    "a verdict": (on_book(judge, "r001", 1), ("reject",), ("accept",), ("r001", "reject", "accept")),
    "a correction": (on_book(change, "r004"), ("duration_s=710",), ("duration_s=730",), ("r004", "710", "730")),
    "a file read otherwise": (read_with, ({},), ({"columns": {"k_gain": {"channel": "aux"}}},), ("r003.csv", "reread")),
    "a file of two runs": (log_of, ("r003", "r003"), ("r003", "r004"), ("r003.csv", "r004")),
    "a file read again": (on_book(declared_otherwise, "r001.csv"), ("aux",), ("sync",), ("r001.csv", "reread")),
    "a file moved to two runs": (on_book(moved, "r001.csv"), ("r004",), ("r005",), ("r004", "r005")),
    "two charges of a run": (on_book(charge, "r001"), (812,), (790,), ("r001", "812", "790")),
    "two charges, in parts": (on_book(charge, "r001"), (812, 90), (812, 80), ("r001", "90 mAh", "80 mAh")),
    "two logs of a run": (
        *(log_of, ("r003", "r003"), ("r004", "r003")),
        ("run r003", "r003.csv here", "r004.csv there", "assign FILE none"),
    ),
    "a file off its run": (
        *(on_book(moved, "r001.csv"), ("none",), ("r004",)),
        ("corrected run_file", "has no place here"),
    ),
    "a charge that is dismissed": (take_inbox, ("r004",), (None,), ("of run r004", "out of use")),
    "two plans of the same runs": (on_book(plan_in), (7,), (8,), ("r040", "r042", "--withdraw")),
}
"""What is done in both books with a value of each, and what the refusal says."""


def go_against(lab: SmallBook, laptop: SmallBook, case: str) -> tuple[str, ...]:
    work, here, there, words = AGAINST[case]
    go_on(lab, laptop, lambda book, files: work(book, files, *here), lambda book, files: work(book, files, *there))
    return words


@pytest.mark.parametrize("case", AGAINST)
def test_a_contradiction_is_named_and_nothing_is_written(lab: SmallBook, laptop: SmallBook, case: str) -> None:
    words = go_against(lab, laptop, case)
    before = contents(lab.folder)
    (sentence,) = merged(lab, laptop, dry_run=True).conflicts
    assert [word for word in words if word not in sentence] == []
    command = ("merge", laptop.folder, "--as", ADA)
    assert labbook(*command, "--dry-run", at=lab.folder).code == 1
    refused(labbook(*command, at=lab.folder), 2, sentence)
    assert contents(lab.folder) == before


def test_what_both_say_alike_is_said_once(lab: SmallBook, laptop: SmallBook) -> None:
    def both(book: Book, files: SmallBook) -> None:
        state_runs(book, SECOND_DAY)
        take(book, files.log("r009"))
        take(book, files.instruments / "charger" / "2021-06-16.csv")
        change(book, "r004", "duration_s=710")
        declared_otherwise(book, "r001.csv", "aux")
        charge(book, "r001", 812)
        plan_in(book, 7)
        state(book, void, "r005", "foot came loose")
        state(book, withdraw, "r002.csv", "of another robot")

    go_on(lab, laptop, both, both)
    with laptop.open() as book:
        take(book, laptop.log("r010"))
        moved(book, "r009.csv", "r012")
        charge(book, "r002", 600)
    assert merged(lab, laptop).entries == {"file": 1, "correction": 1, "charge": 1}
    with lab.open() as book, book.reading() as connection:
        assert show_file(connection, "r009.csv").runs == ("r012",)
    is_whole(lab.folder)


def test_a_charge_in_parts_comes_home_whole(lab: SmallBook, laptop: SmallBook) -> None:
    def here(book: Book, _files: SmallBook) -> None:
        charge(book, "r001", 400, 400)
        charge(book, "r002", 600)
        charge(book, "r004", 300)

    def there(book: Book, files: SmallBook) -> None:
        charge(book, "r001", 400, 400)
        charge(book, "r002", 600, 600)
        sheet = files.folder / "parts.csv"
        sheet.write_text("run,mAh\nr003,500\nr003,70\nr004,300\n")
        take(book, sheet)
        state(book, assign, "parts.csv#2", "r003", None, add=True)

    go_on(lab, laptop, here, there)
    merged(lab, laptop)
    with lab.open() as book, book.reading() as connection:
        charged = charges_by_run(connection)
        runs = {run.name: [row.charge_mah for row in charged.get(run.uid, ())] for run in list_runs(connection)}
    assert {name: mah for name, mah in runs.items() if mah} == {
        "r001": [400, 400],
        "r002": [600, 600],
        "r003": [500, 70],
        "r004": [300],
    }
    assert merged(laptop, lab).conflicts == ()
    is_whole(lab.folder)


def test_what_was_taken_back_there_is_taken_back_here(lab: SmallBook, laptop: SmallBook) -> None:
    def there(book: Book, files: SmallBook) -> None:
        take_inbox(book, files, None)
        state(book, withdraw, "r001.csv", "whose?", person=BEN)
        state(book, void, "r005", "foot came loose", person=BEN)
        state(book, restore, "r001.csv", "mine", person=BEN)
        state(book, restore_item, "sheet.csv#1", "r009's", person=BEN)
        state(book, unvoid, "r005", "it was r006", person=BEN)

    def here(book: Book, _files: SmallBook) -> None:
        state(book, withdraw, "r001.csv", "of another robot")
        state(book, void, "r005", "foot came loose")

    go_on(lab, laptop, here, there)
    assert len(merged(lab, laptop, dry_run=True).conflicts) == 2
    with lab.open() as book:
        state(book, restore, "r001.csv", "as Ben says")
        state(book, unvoid, "r005", "as Ben says")
    assert merged(lab, laptop).entries == {"file": 1, "charge dismissed": 1, "file or charge restored": 1}
    is_whole(lab.folder)


def test_runs_of_one_name_can_both_stay_when_one_is_renamed(lab: SmallBook, laptop: SmallBook) -> None:
    go_against(lab, laptop, "a run in both")
    with lab.open() as book:
        change(book, "r009", "name=r009b")
    assert merged(lab, laptop).entries == {"run": 1, "note": 1}


# --- no common beginning


@pytest.fixture
def stranger(lab: SmallBook, tmp_path: Path) -> SmallBook:
    """A book of the same study, described on another machine."""
    (tmp_path / "stranger").mkdir()
    made = SmallBook(tmp_path / "stranger", lab.instruments)
    made.toml.write_text(small_toml(two_people=True), encoding="utf-8")
    make_book(made.folder, BEN)
    return made


def test_books_without_a_common_beginning_are_matched_by_names(lab: SmallBook, stranger: SmallBook) -> None:
    with stranger.open() as book:
        state_runs(book, [*FIRST_DAY, *SECOND_DAY], BEN)
        take(book, lab.log("r001"), BEN)
        moved(book, "r001.csv", "r004")
        for run in ("r009", "r003"):  # in the first condition
            take(book, lab.log(run), BEN)
    done = merged(lab, stranger)
    assert (done.common, done.entries["run"], done.entries["file"]) == (0, 8, 2)
    with lab.open() as book, book.reading() as connection:
        assert show_file(connection, "r001.csv").runs == ("r004",)
        assert len(list_runs(connection)) == 16
    assert merged(lab, stranger).entries == {}
    is_whole(lab.folder)


def test_another_configuration_is_refused_until_both_say_the_same(lab: SmallBook, laptop: SmallBook) -> None:
    text = laptop.toml.read_text().replace('"Ben Ode" = "BO"', '"Ben Ode" = "BO"\n"Cy Dee" = "CD"')
    laptop.toml.write_text(text)
    with laptop.open() as book:
        state(book, note, "by a third", person="CD")
    with pytest.raises(InputRefused, match=r"\[people\]"):
        merged(lab, laptop)
    lab.toml.write_text(text)
    assert merged(lab, laptop).entries == {"note": 1}
    is_whole(lab.folder)


# --- other books


@pytest.mark.parametrize("how", ["changed", "lost", "cut"])
def test_a_raw_copy_or_a_journal_that_is_not_what_it_was_there_is_named(
    lab: SmallBook, laptop: SmallBook, how: str
) -> None:
    go_on(lab, laptop)
    before = contents(lab.folder)
    with laptop.open() as book, book.reading() as connection:
        path = book.store.root / raw_path(show_file(connection, "r009.csv").sha256)
    path.chmod(0o644)
    if how == "cut":
        laptop.journal.write_text("".join(laptop.journal.read_text().splitlines(keepends=True)[:-1]))
    elif how == "lost":
        path.unlink()
    else:
        path.write_bytes(b"something else")
    with pytest.raises(BookDamaged, match="rebuild --journal" if how == "cut" else "laptop"):
        merged(lab, laptop)
    assert contents(lab.folder) == before


def test_a_book_on_postgresql_takes_in_one_on_sqlite(tmp_path: Path, postgres_url: str) -> None:
    lab = small_book(tmp_path / "lab", runs=False, ingested=False, two_people=True, database_url=postgres_url)
    with lab.open() as book:
        state_runs(book, FIRST_DAY)
        for run in ("r001", "r002"):
            take(book, lab.log(run))
    laptop = SmallBook(tmp_path / "laptop", lab.instruments)
    shutil.copytree(lab.folder, laptop.folder)
    laptop.toml.write_text(small_toml(two_people=True))
    rebuilt(laptop)
    go_on(lab, laptop)
    assert merged(lab, laptop).entries["run"] == 8
    assert merged(lab, laptop).entries == {}
    is_whole(lab.folder)
