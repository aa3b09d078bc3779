"""A charge is known by its file and line: what people said of it outlives another reading of the sheet."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.errors import UsageError
from data_schema.queries.charges import charges_by_run
from data_schema.queries.imported_files import inbox
from data_schema.queries.readings import last_reading
from data_schema.vocabulary import Undefined
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import FileOutcome, IngestRequest, ingest_file
from labbook.actions.files.rereading import RereadRequest, reread
from labbook.actions.files.stored_files import dismiss, reread_named, restore, restore_item, withdraw
from labbook.actions.runs.charges import state_charge
from labbook.actions.runs.correcting import correct
from labbook.analysis.outcomes.run_energy import recharge_of
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.rebuilding import rebuild_database
from tests.helpers.books import ADA, SmallBook, import_sheet, small_book
from tests.helpers.databases import all_rows_by_name, server_in_a_soak
from tests.helpers.wording import refuses, says

SHEET = "run,charge,minutes\nr001,0.15,12\nr002,0.16,12\nr003,0.17,12\n,0.18,12\n"


def take(book: Book, folder: Path, name: str, text: str, options: dict[str, object] | None = None) -> FileOutcome:
    path = folder / name
    path.write_text(text)
    return ingest_file(book, path, IngestRequest(options=options, person=ADA))


def charges(book: Book) -> dict[str, list[float]]:
    """What was put back after each run, by its name."""
    with book.reading() as connection:
        by_uid = charges_by_run(connection)
        runs = {name: run_named(connection, name).uid for name in ("r001", "r002", "r003", "r004")}
    return {name: [charge.charge_mah for charge in by_uid.get(uid, [])] for name, uid in runs.items()}


def uid_of(book: Book, run: str) -> str:
    with book.reading() as connection:
        return charges_by_run(connection)[run_named(connection, run).uid][0].uid


def rebuilt_alike(small: SmallBook) -> None:
    with small.open() as book:
        before = all_rows_by_name(book.engine)
    rebuild_database(small.folder, lambda _step: None)
    with small.open() as book:
        assert all_rows_by_name(book.engine) == before


@pytest.fixture
def small(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path, ingested=False)


def declared(unit: str) -> dict[str, object]:
    return {"columns": {"charge": {"channel": "charge", "unit": unit}}}


def test_corrections_and_assignments_outlive_another_reading(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", SHEET, declared("mAh"))
        assert charges(book) == {"r001": [0.15], "r002": [0.16], "r003": [0.17], "r004": []}
        before = uid_of(book, "r001")
        with book.session(ADA) as session:
            correct(book, session, f"charge:{uid_of(book, 'r002')}", ["charge_mah=149"], "the display said 149")
        with book.session(ADA) as session:
            assign(session, "s.csv#3", "none", "another pack's")
        with book.session(ADA) as session:
            assign(session, "s.csv#4", "r004", None)
        again = take(book, tmp_path, "s.csv", SHEET, declared("Ah"))
        assert again.changes is not None
        assert again.read is not None
        assert charges(book) == {"r001": [150.0], "r002": [149.0], "r003": [], "r004": [pytest.approx(180.0)]}
        assert uid_of(book, "r001") == before
        (said,) = [finding.message for finding in again.read.findings if finding.rule == "correction_stands"]
        assert "charge_mah=160" in said
        assert "149" in said
    rebuilt_alike(small)


@pytest.mark.parametrize("named", ["r099", "r004"])
def test_the_run_that_a_person_corrected_outlives_another_reading(named: str, small: SmallBook, tmp_path: Path) -> None:
    """Where the book has no such run yet, too."""
    with small.open() as book:
        take(book, tmp_path, "s.csv", SHEET, declared("mAh"))
        with book.session(ADA) as session:
            target = f"charge:{uid_of(book, 'r003')}"
            correct(book, session, target, [f"stated_run={named}"], "the line was another run's")
        take(book, tmp_path, "s.csv", SHEET, declared("Ah"))
        by_run = charges(book)
        assert by_run == {"r001": [150], "r002": [160], "r003": [], "r004": [170] if named == "r004" else []}
    rebuilt_alike(small)


def test_rows_of_other_sheets_step_in_when_a_sheet_is_withdrawn_and_back(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", SHEET, declared("Ah"))
        grown = take(book, tmp_path, "grown.csv", SHEET + "r004,0.19,12\n", declared("Ah"))
        assert grown.read is not None
        assert [(item.rule, item.count) for item in grown.read.findings if item.rule == "charge_known"] == [
            ("charge_known", 3)
        ]
        both = charges(book)
        with book.session(ADA) as session:
            said = withdraw(session, "s.csv", "was a draft")
        says(said, "3 rows")
        assert charges(book) == both
        with book.session(ADA) as session:
            withdraw(session, "grown.csv", "so was this")
        assert not any(charges(book).values())
        for name in ("grown.csv", "s.csv"):
            with book.session(ADA) as session:
                restore(session, name, None)
        assert charges(book) == both
    rebuilt_alike(small)


def use(book: Book, *steps: str) -> None:
    """Withdraw (`-NAME`) and restore (`+NAME`) sheets in this order."""
    for step in steps:
        with book.session(ADA) as session:
            if step.startswith("-"):
                withdraw(session, step[1:], "a draft")
            else:
                restore(session, step[1:], None)


@pytest.mark.parametrize(
    "steps",
    [
        ("-s.csv", "-g1.csv", "+g1.csv"),  # no charge once: the restored row repeated one that is withdrawn
        pytest.param(("-s.csv", "-g1.csv", "+s.csv"), marks=pytest.mark.soak),  # two charges once
        pytest.param(("-s.csv", "+s.csv", "-g1.csv", "-s.csv"), marks=pytest.mark.soak),  # no charge once
        ("-g2.csv", "-s.csv", "-g1.csv", "+g2.csv", "+s.csv", "-g2.csv"),
    ],
)
def test_of_sheets_that_say_the_same_one_counts_whatever_the_order(
    small: SmallBook, tmp_path: Path, steps: tuple[str, ...]
) -> None:
    with small.open() as book:
        for name in ("s.csv", "g1.csv", "g2.csv"):
            take(book, tmp_path, name, SHEET + f"# {name}\n", declared("Ah"))
        before = charges(book)
        assert [len(of_run) for of_run in before.values()] == [1, 1, 1, 0]
        use(book, *steps)
        assert charges(book) == before
    rebuilt_alike(small)


def test_a_restored_sheet_adds_no_second_charge_and_no_row_that_is_gone(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", SHEET, declared("Ah"))
        use(book, "-s.csv")
        with book.session(ADA) as session:
            state_charge(session, book.configuration, "r001", 155.0, None, None)
        use(book, "+s.csv")
        assert charges(book)["r001"] == [155.0]
        take(book, tmp_path, "grown.csv", SHEET + "r004,0.19,12\n", declared("Ah"))
        use(book, "-s.csv")
        uid = uid_of(book, "r002")
        with book.session(ADA) as session:
            correct(book, session, f"charge:{uid}", ["charge_mah=161"], "misread")
        use(book, "+s.csv")
        assert charges(book)["r002"] == [161.0]
    rebuilt_alike(small)


@pytest.mark.parametrize("by_hand", [False, True])
def test_the_one_row_left_out_comes_with_the_corrected_sheet(small: SmallBook, tmp_path: Path, by_hand: bool) -> None:
    with small.open() as book:
        first = take(book, tmp_path, "s.csv", "run,mAh\nr001,150\nr002,16O\nr003,170\n")
        assert first.read is not None
        assert [(found.severity, found.line) for found in first.read.findings] == [("row", 3)]
        assert charges(book) == {"r001": [150.0], "r002": [], "r003": [170.0], "r004": []}
        if by_hand:
            with book.session(ADA) as session:
                state_charge(session, book.configuration, "r002", 160.0, None, None)
        again = take(book, tmp_path, "s.csv", "run,mAh\nr001,150\nr002,160\nr003,170\n")
        assert again.read is not None
        assert [(found.rule, found.count) for found in again.read.findings] == [("charge_known", 2 + by_hand)]
        assert charges(book) == {"r001": [150.0], "r002": [160.0], "r003": [170.0], "r004": []}
    rebuilt_alike(small)


def test_a_charge_taken_off_its_run_does_not_come_back_with_a_grown_sheet(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        sheet = "run,charge,minutes\nr001,0.15,12\nr002,0.16,12\n"
        take(book, tmp_path, "s.csv", sheet, declared("Ah"))
        with book.session(ADA) as session:
            assign(session, "s.csv#1", "none", "another pack's")
        with book.reading() as connection:
            before = inbox(connection)
        take(book, tmp_path, "grown.csv", f"{sheet}r099,0.3,20\n", declared("Ah"))
        assert charges(book)["r001"] == []
        with book.reading() as connection:
            assert [item for item in inbox(connection) if item not in before] == inbox(connection)[-1:], "r099 alone"


def test_the_second_charge_of_a_run_is_refused_by_every_door(small: SmallBook, tmp_path: Path) -> None:
    other = "run,mAh,minutes\nr001,99,12\n"
    with small.open() as book:
        with book.session(ADA) as session:
            state_charge(session, book.configuration, "r001", 150.0, None, None)
        take(book, tmp_path, "other.csv", other)
        for say in (
            lambda session: assign(session, "other.csv#1", "r001", "it is"),
            lambda session: assign(session, "other.csv", "r001", "it is"),
            lambda session: state_charge(session, book.configuration, "r001", 99.0, None, None),
        ):
            with (
                refuses(UsageError, "r001", "a charge already", "150 mAh"),
                book.session(ADA) as session,
            ):
                say(session)
        assert charges(book)["r001"] == [150.0]
        with book.session(ADA) as session:
            dismiss(session, "other.csv#1", "of another robot")
        with book.reading() as connection:
            assert inbox(connection) == []
        with book.session(ADA) as session:
            restore_item(session, "other.csv#1", None)
        with book.reading() as connection:
            assert [item.name for item in inbox(connection)] == ["other.csv#1"]
    rebuilt_alike(small)


def test_two_charges_that_came_before_their_run_are_no_different(tmp_path: Path) -> None:
    """The old answer: both were given to the run when it was stated, and its joules were undefined."""
    small = small_book(tmp_path, runs=False, ingested=False)
    with small.open() as book:
        take(book, tmp_path, "a.csv", "run,mAh,minutes\nr001,150,12\n")
        take(book, tmp_path, "b.csv", "run,mAh,minutes\nr001,99,12\n")

        import_sheet(book, small.instruments / "runs.csv")
        assert charges(book)["r001"] == [150.0]
        with book.reading() as connection:
            assert [item.name for item in inbox(connection)] == ["b.csv#1"]
    rebuilt_alike(small)


def test_what_counts_follows_from_what_is_said_now_and_not_from_what_was(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", "run,mAh,minutes\nr001,150,12\n")
        take(book, tmp_path, "other.csv", "run,mAh,minutes\nr001,99,12\n")
        for steps, counts in ((("-s.csv",), 99.0), (("+s.csv",), 150.0)):
            use(book, *steps)
            assert charges(book)["r001"] == [counts]
        with book.reading() as connection:
            assert [item.name for item in inbox(connection)] == ["other.csv#1"]
        with book.session(ADA) as session:
            says(assign(session, "s.csv#1", "none", "another pack's"), "inbox", "other.csv#1")
        assert charges(book)["r001"] == [99.0]
        with book.reading() as connection:
            assert [item.name for item in inbox(connection)] == ["s.csv#1"]
    rebuilt_alike(small)


def test_a_sheet_that_grows_repeats_what_was_corrected_meanwhile(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", SHEET, declared("Ah"))
        with book.session(ADA) as session:
            correct(book, session, f"charge:{uid_of(book, 'r002')}", ["charge_mah=149"], "the display said 149")
        grown = take(book, tmp_path, "grown.csv", f"{SHEET}r004,0.19,12\n", declared("Ah"))
        assert grown.read is not None
        rules = {finding.rule: finding.count for finding in grown.read.findings}
        assert {"charge_known": 3, "correction_stands": 1}.items() <= rules.items()
        assert charges(book) == {"r001": [150.0], "r002": [149.0], "r003": [170.0], "r004": [190.0]}
        use(book, "-s.csv", "+s.csv")
        assert charges(book)["r002"] == [149.0]
    rebuilt_alike(small)


TWICE = "run_a,run_b,first,second,minutes\nr001,r002,150,150,12\n,,160,,12\n"


def columns(run: str = "run_a", amount: str = "first") -> dict[str, object]:
    """Have a sheet read by one of its columns of runs and one of its columns of amounts."""
    return {"columns": {run: {"channel": "run"}, amount: {"channel": "charge", "unit": "mAh"}}}


def read_again(book: Book, name: str, options: dict[str, object]) -> None:
    assert not reread_named(book, name, RereadRequest(options, ADA, "otherwise")).read.refused


def test_a_row_that_goes_and_comes_back_is_where_a_person_put_it(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", TWICE, columns())
        with book.session(ADA) as session:
            assign(session, "s.csv#2", "r004", None)
        read_again(book, "s.csv", columns(amount="second"))
        assert charges(book)["r004"] == []
        read_again(book, "s.csv", columns())
        assert charges(book)["r004"] == [160.0]
        read_again(book, "s.csv", columns(amount="second"))
        with book.session(ADA) as session:
            state_charge(session, book.configuration, "r004", 99.0, None, None)
        read_again(book, "s.csv", columns())
        assert charges(book)["r004"] == [99.0]  # the second charge of a run waits
        with book.reading() as connection:
            assert [item.name for item in inbox(connection)] == ["s.csv#2"]
    rebuilt_alike(small)


@server_in_a_soak("database_url")
def test_rows_that_repeated_one_are_placed_when_it_says_something_else(
    tmp_path: Path, database_url: str | None
) -> None:
    small = small_book(tmp_path, ingested=False, database_url=database_url)
    with small.open() as book:
        take(book, tmp_path, "s.csv", TWICE, columns())
        take(book, tmp_path, "grown.csv", f"{TWICE}r003,,170,,12\n", columns())
        read_again(book, "s.csv", columns("run_b"))
        assert charges(book) == {"r001": [150.0], "r002": [150.0], "r003": [170.0], "r004": []}
    rebuilt_alike(small)


def test_a_dismissed_row_that_is_gone_is_not_restored(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", TWICE, columns())
        with book.session(ADA) as session:
            dismiss(session, "s.csv#2", "of another robot")
        read_again(book, "s.csv", columns(amount="second"))
        with (
            refuses(UsageError, "has no charge", "2"),
            book.session(ADA) as session,
        ):
            restore_item(session, "s.csv#2", None)
        read_again(book, "s.csv", columns())
        with book.reading() as connection:
            assert inbox(connection) == []  # it is dismissed still
        with book.session(ADA) as session:
            restore_item(session, "s.csv#2", None)
        with book.reading() as connection:
            assert [item.name for item in inbox(connection)] == ["s.csv#2"]
    rebuilt_alike(small)


def test_a_charge_given_back_to_a_run_by_hand_counts_whatever_it_repeats(small: SmallBook, tmp_path: Path) -> None:
    """A known row that was assigned was said to belong to its run, and did not count."""
    with small.open() as book:
        take(book, tmp_path, "s.csv", TWICE, columns())
        take(book, tmp_path, "grown.csv", f"{TWICE}# more\n", columns())
        with book.session(ADA) as session:
            assign(session, "s.csv#1", "none", "that sheet is a draft")
            assign(session, "grown.csv#1", "r001", None)
        assert charges(book)["r001"] == [150.0]
    rebuilt_alike(small)


def test_a_file_withdrawn_meanwhile_is_not_read_again(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        taken = take(book, tmp_path, "s.csv", TWICE, columns())
        with book.reading() as connection:
            row = last_reading(connection, taken.sha256)
        assert row is not None
        use(book, "-s.csv")
        with refuses(UsageError, "s.csv"):
            reread(book, row, RereadRequest(columns("run_b"), ADA, "otherwise"))
        assert not any(charges(book).values())


def test_the_second_charge_of_a_run_waits_whatever_file_it_came_in(small: SmallBook, tmp_path: Path) -> None:
    """A file of one charge that names its run was given to it as a second one, by ingest and by another assignment."""
    one = "pack,mAh,minutes\nA,99,12\n"
    with small.open() as book:
        take(book, tmp_path, "s.csv", TWICE, columns())
        path = tmp_path / "one.csv"
        path.write_text(one)
        first = ingest_file(book, path, IngestRequest(run="r001", person=ADA))
        assert first.read is not None
        assert "charge_contradicts" in {finding.rule for finding in first.read.findings}
        assert charges(book)["r001"] == [150.0]
        path.write_text(f"{one}# again\n")
        ingest_file(book, path, IngestRequest(person=ADA))
        with refuses(UsageError, "r001", "a charge already"):
            ingest_file(book, path, IngestRequest(run="r001", person=ADA))
    rebuilt_alike(small)


@pytest.mark.parametrize("dry_run", [True, False])
def test_a_dry_run_refuses_the_second_charge_of_a_run_too(small: SmallBook, tmp_path: Path, dry_run: bool) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", TWICE, columns())
        take(book, tmp_path, "one.csv", "pack,mAh,minutes\nA,99,12\n")
        with refuses(UsageError, "r001", "a charge already"):
            ingest_file(book, tmp_path / "one.csv", IngestRequest(run="r001", person=ADA, dry_run=dry_run))
        said = ingest_file(book, tmp_path / "one.csv", IngestRequest(run="r004", person=ADA, dry_run=dry_run)).messages
        assert ("belong to run" in said[0]) == dry_run


PARTS = "run,mAh,minutes\nr001,150,12\nr002,160,12\nr001,{second},12\n"


def joules_unknown(book: Book, run: str) -> str | None:
    """Why a run has no joules a jump, by its charges; None where these are enough."""
    with book.reading() as connection:
        found = run_named(connection, run)
        charge = recharge_of(found, charges_by_run(connection).get(found.uid, []))
    return charge.reason if isinstance(charge, Undefined) else None


def add(book: Book, what: str, run: str) -> None:
    with book.session(ADA) as session:
        assign(session, what, run, None, add=True)


@pytest.mark.parametrize("second", [90, 150])
@pytest.mark.parametrize("again", [[("-s.csv",), ("+s.csv",)], [("-s.csv", "+s.csv")]])
def test_the_parts_of_a_charge_are_added_up_whatever_becomes_of_their_sheet(
    small: SmallBook, tmp_path: Path, second: int, again: list[tuple[str, ...]]
) -> None:
    sheet = PARTS.format(second=second)
    both = {"r001": [150.0, float(second)], "r002": [160.0], "r003": [], "r004": []}
    with small.open() as book:
        take(book, tmp_path, "s.csv", sheet)
        add(book, "s.csv#3", "r001")
        assert charges(book) == both
        take(book, tmp_path, "grown.csv", f"{sheet}r003,170,12\n")
        assert charges(book) == {**both, "r003": [170.0]}
        with book.reading() as connection:
            assert inbox(connection) == []
        use(book, "-grown.csv")
        for steps in again:
            use(book, *steps)
        assert charges(book) == both
        assert joules_unknown(book, "r001") is None
    rebuilt_alike(small)


def test_a_part_alone_is_no_charge_of_its_run(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", PARTS.format(second=90))
        with refuses(UsageError, "r003", "--add"):
            add(book, "s.csv#3", "r003")
        add(book, "s.csv#3", "r001")
        with book.session(ADA) as session:
            assign(session, "s.csv#1", "none", "another pack's")
        assert charges(book)["r001"] == [90.0]
        assert joules_unknown(book, "r001") is not None
        with book.session(ADA) as session:
            state_charge(session, book.configuration, "r001", 151.0, None, None)
        assert joules_unknown(book, "r001") is None
        with book.session(ADA) as session:
            correct(book, session, f"charge:{uid_of(book, 'r001')}", ["run=none"], "it was not")
        assert charges(book)["r001"] == [151.0]
    rebuilt_alike(small)


def test_a_part_is_typed_in_too(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        take(book, tmp_path, "s.csv", "run,mAh\nr001,150\n")
        with book.session(ADA) as session:
            state_charge(session, book.configuration, "r001", 90.0, None, None, add=True)
        use(book, "-s.csv", "+s.csv")
        assert sorted(charges(book)["r001"]) == [90.0, 150.0]
        assert joules_unknown(book, "r001") is None
    rebuilt_alike(small)
