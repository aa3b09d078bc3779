"""A charge is known by its file and line: what people said of it outlives another reading of the sheet.

After each test a rebuild has to make the same rows.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.errors import UsageError
from data_schema.queries.charges import charges_by_run
from data_schema.queries.files import last_reading
from data_schema.vocabulary import Undefined
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import FileOutcome
from labbook.actions.files.rereading import RereadRequest, reread
from labbook.actions.files.stored_files import dismiss, restore_item, withdraw
from labbook.actions.runs.correcting import correct, state_charge
from labbook.analysis.outcomes.run_energy import recharge_of
from labbook.book.naming import run_named
from tests.helpers.books import ADA, import_sheet
from tests.helpers.databases import server_in_a_soak
from tests.helpers.desk import Desk, desk_at, of_column
from tests.helpers.wording import refuses, says

SHEET = "run,charge,minutes\nr001,0.15,12\nr002,0.16,12\nr003,0.17,12\n,0.18,12\n"
AH = of_column("charge", "Ah")
ONE, OTHER = (f"run,mAh,minutes\nr001,{mah},12\n" for mah in (150, 99))
OF_NO_RUN = "pack,mAh,minutes\nA,99,12\n"


def found(outcome: FileOutcome, *rules: str) -> dict[str, int]:
    """How often each rule was found, of all or of these."""
    assert outcome.read is not None
    return {item.rule: item.count for item in outcome.read.findings if not rules or item.rule in rules}


def test_corrections_and_assignments_outlive_another_reading(desk: Desk) -> None:
    desk.take("s.csv", SHEET, of_column("charge"))
    assert desk.charges() == {"r001": [0.15], "r002": [0.16], "r003": [0.17], "r004": []}
    before = desk.uid_of("r001")
    desk.correct_charge("r002", "charge_mah=149")
    desk.say(assign, "s.csv#3", "none", "another pack's")
    desk.say(assign, "s.csv#4", "r004", None)
    again = desk.take("s.csv", SHEET, AH)
    assert again.changes is not None
    assert again.read is not None
    assert desk.charges() == {"r001": [150.0], "r002": [149.0], "r003": [], "r004": [pytest.approx(180.0)]}
    assert desk.uid_of("r001") == before
    (said,) = [finding.message for finding in again.read.findings if finding.rule == "correction_stands"]
    says(said, "charge_mah=160", "149")


@pytest.mark.parametrize("named", ["r099", "r004"])
def test_the_run_that_a_person_corrected_outlives_another_reading(named: str, desk: Desk) -> None:
    """Where the book has no such run yet, too."""
    desk.take("s.csv", SHEET, of_column("charge"))
    desk.correct_charge("r003", f"stated_run={named}")
    desk.take("s.csv", SHEET, AH)
    assert desk.charges() == {"r001": [150], "r002": [160], "r003": [], "r004": [170] if named == "r004" else []}


def test_rows_of_other_sheets_step_in_when_a_sheet_is_withdrawn_and_back(desk: Desk) -> None:
    desk.take("s.csv", SHEET, AH)
    grown = desk.take("grown.csv", SHEET + "r004,0.19,12\n", AH)
    assert found(grown, "charge_known") == {"charge_known": 3}
    both = desk.charges()
    says(desk.say(withdraw, "s.csv", "was a draft"), "3 rows")
    assert desk.charges() == both
    desk.use("-grown.csv")
    assert not any(desk.charges().values())
    desk.use("+grown.csv", "+s.csv")
    assert desk.charges() == both


@pytest.mark.parametrize(
    "steps",
    [
        ("-s.csv", "-g1.csv", "+g1.csv"),  # no charge once: the restored row repeated one that is withdrawn
        pytest.param(("-s.csv", "-g1.csv", "+s.csv"), marks=pytest.mark.soak),  # two charges once
        pytest.param(("-s.csv", "+s.csv", "-g1.csv", "-s.csv"), marks=pytest.mark.soak),  # no charge once
        ("-g2.csv", "-s.csv", "-g1.csv", "+g2.csv", "+s.csv", "-g2.csv"),
    ],
)
def test_of_sheets_that_say_the_same_one_counts_whatever_the_order(desk: Desk, steps: tuple[str, ...]) -> None:
    for name in ("s.csv", "g1.csv", "g2.csv"):
        desk.take(name, SHEET + f"# {name}\n", AH)
    before = desk.charges()
    assert [len(of_run) for of_run in before.values()] == [1, 1, 1, 0]
    desk.use(*steps)
    assert desk.charges() == before


def test_a_restored_sheet_adds_no_second_charge_and_no_row_that_is_gone(desk: Desk) -> None:
    desk.take("s.csv", SHEET, AH)
    desk.use("-s.csv")
    desk.type_in("r001", 155.0)
    desk.use("+s.csv")
    assert desk.charges()["r001"] == [155.0]
    desk.take("grown.csv", SHEET + "r004,0.19,12\n", AH)
    desk.use("-s.csv")
    desk.correct_charge("r002", "charge_mah=161")
    desk.use("+s.csv")
    assert desk.charges()["r002"] == [161.0]


@pytest.mark.parametrize("by_hand", [False, True])
def test_the_one_row_left_out_comes_with_the_corrected_sheet(desk: Desk, by_hand: bool) -> None:
    sheet = "run,mAh\nr001,150\nr002,{}\nr003,170\n"
    first = desk.take("s.csv", sheet.format("16O"))
    assert first.read is not None
    assert [(item.severity, item.line) for item in first.read.findings] == [("row", 3)]
    assert desk.charges() == {"r001": [150.0], "r002": [], "r003": [170.0], "r004": []}
    if by_hand:
        desk.type_in("r002", 160.0)
    assert found(desk.take("s.csv", sheet.format(160))) == {"charge_known": 2 + by_hand}
    assert desk.charges() == {"r001": [150.0], "r002": [160.0], "r003": [170.0], "r004": []}


def test_a_charge_taken_off_its_run_does_not_come_back_with_a_grown_sheet(desk: Desk) -> None:
    sheet = "run,charge,minutes\nr001,0.15,12\nr002,0.16,12\n"
    desk.take("s.csv", sheet, AH)
    desk.say(assign, "s.csv#1", "none", "another pack's")
    before = desk.inbox()
    desk.take("grown.csv", f"{sheet}r099,0.3,20\n", AH)
    assert desk.charges()["r001"] == []
    assert desk.inbox() == [*before, "grown.csv#3"]


def test_the_second_charge_of_a_run_is_refused_by_every_door(desk: Desk) -> None:
    desk.type_in("r001", 150.0)
    desk.take("other.csv", OTHER)
    for action, *given in (
        (assign, "other.csv#1", "r001", "it is"),
        (assign, "other.csv", "r001", "it is"),
        (state_charge, "r001", 99.0, None, None),
    ):
        with refuses(UsageError, "r001", "a charge already", "150 mAh"):
            desk.say(action, *given)
    assert desk.charges()["r001"] == [150.0]
    desk.say(dismiss, "other.csv#1", "of another robot")
    assert desk.inbox() == []
    desk.say(restore_item, "other.csv#1", None)
    assert desk.inbox() == ["other.csv#1"]


def test_two_charges_that_came_before_their_run_are_no_different(tmp_path: Path) -> None:
    with desk_at(tmp_path, runs=False) as desk:
        desk.take("a.csv", ONE)
        desk.take("b.csv", OTHER)
        import_sheet(desk.book, desk.small.instruments / "runs.csv")
        assert desk.charges()["r001"] == [150.0]
        assert desk.inbox() == ["b.csv#1"]


def test_what_counts_follows_from_what_is_said_now_and_not_from_what_was(desk: Desk) -> None:
    desk.take("s.csv", ONE)
    desk.take("other.csv", OTHER)
    for step, counts in (("-s.csv", 99.0), ("+s.csv", 150.0)):
        desk.use(step)
        assert desk.charges()["r001"] == [counts]
    assert desk.inbox() == ["other.csv#1"]
    says(desk.say(assign, "s.csv#1", "none", "another pack's"), "inbox", "other.csv#1")
    assert desk.charges()["r001"] == [99.0]
    assert desk.inbox() == ["s.csv#1"]


def test_a_sheet_that_grows_repeats_what_was_corrected_meanwhile(desk: Desk) -> None:
    desk.take("s.csv", SHEET, AH)
    desk.correct_charge("r002", "charge_mah=149")
    grown = desk.take("grown.csv", f"{SHEET}r004,0.19,12\n", AH)
    assert found(grown, "charge_known", "correction_stands") == {"charge_known": 3, "correction_stands": 1}
    assert desk.charges() == {"r001": [150.0], "r002": [149.0], "r003": [170.0], "r004": [190.0]}
    desk.use("-s.csv", "+s.csv")
    assert desk.charges()["r002"] == [149.0]


TWICE = "run_a,run_b,first,second,minutes\nr001,r002,150,150,12\n,,160,,12\n"


def columns(run: str = "run_a", amount: str = "first") -> dict[str, object]:
    """Have a sheet read by one of its columns of runs and one of its columns of amounts."""
    return {"columns": {run: {"channel": "run"}, **of_column(amount)["columns"]}}


SECOND = columns(amount="second")


def test_a_row_that_goes_and_comes_back_is_where_a_person_put_it(desk: Desk) -> None:
    desk.take("s.csv", TWICE, columns())
    desk.say(assign, "s.csv#2", "r004", None)
    for read, counts in ((SECOND, []), (columns(), [160.0]), (SECOND, [])):
        desk.read_again("s.csv", read)
        assert desk.charges()["r004"] == counts
    desk.type_in("r004", 99.0)
    desk.read_again("s.csv", columns())
    assert desk.charges()["r004"] == [99.0]  # the second charge of a run waits
    assert desk.inbox() == ["s.csv#2"]


@server_in_a_soak("database_url")
def test_rows_that_repeated_one_are_placed_when_it_says_something_else(
    tmp_path: Path, database_url: str | None
) -> None:
    with desk_at(tmp_path, database_url=database_url) as desk:
        desk.take("s.csv", TWICE, columns())
        desk.take("grown.csv", f"{TWICE}r003,,170,,12\n", columns())
        desk.read_again("s.csv", columns("run_b"))
        assert desk.charges() == {"r001": [150.0], "r002": [150.0], "r003": [170.0], "r004": []}


def test_a_dismissed_row_that_is_gone_is_not_restored(desk: Desk) -> None:
    desk.take("s.csv", TWICE, columns())
    desk.say(dismiss, "s.csv#2", "of another robot")
    desk.read_again("s.csv", SECOND)
    with refuses(UsageError, "has no charge", "2"):
        desk.say(restore_item, "s.csv#2", None)
    desk.read_again("s.csv", columns())
    assert desk.inbox() == []  # it is dismissed still
    desk.say(restore_item, "s.csv#2", None)
    assert desk.inbox() == ["s.csv#2"]


def test_a_charge_given_back_to_a_run_by_hand_counts_whatever_it_repeats(desk: Desk) -> None:
    desk.take("s.csv", TWICE, columns())
    desk.take("grown.csv", f"{TWICE}# more\n", columns())
    desk.say(assign, "s.csv#1", "none", "that sheet is a draft")
    desk.say(assign, "grown.csv#1", "r001", None)
    assert desk.charges()["r001"] == [150.0]


def test_a_file_withdrawn_meanwhile_is_not_read_again(desk: Desk) -> None:
    taken = desk.take("s.csv", TWICE, columns())
    with desk.book.reading() as connection:
        row = last_reading(connection, taken.sha256)
    assert row is not None
    desk.use("-s.csv")
    with refuses(UsageError, "s.csv"):
        reread(desk.book, row, RereadRequest(columns("run_b"), ADA, "otherwise"))
    assert not any(desk.charges().values())


def test_the_second_charge_of_a_run_waits_whatever_file_it_came_in(desk: Desk) -> None:
    """A file of one charge that names its run, ingested for it or assigned to it."""
    desk.take("s.csv", TWICE, columns())
    assert "charge_contradicts" in found(desk.take("one.csv", OF_NO_RUN, run="r001"))
    assert desk.charges()["r001"] == [150.0]
    again = f"{OF_NO_RUN}# again\n"
    desk.take("again.csv", again)
    says(desk.take("again.csv", again, run="r004").messages, "labbook assign")
    with refuses(UsageError, "r001", "a charge already"):
        desk.say(assign, "again.csv", "r001", None)
    says(desk.say(assign, "again.csv", "r004", None), "r004")


PARTS = "run,mAh,minutes\nr001,150,12\nr002,160,12\nr001,{second},12\n"


def joules_unknown(desk: Desk, run: str) -> bool:
    """Whether a run has no joules a jump for want of charges."""
    with desk.book.reading() as connection:
        run_of_charge = run_named(connection, run)
        charge = recharge_of(run_of_charge, charges_by_run(connection).get(run_of_charge.uid, []))
    return isinstance(charge, Undefined)


@pytest.mark.parametrize("second", [90, 150])
def test_the_parts_of_a_charge_are_added_up_whatever_becomes_of_their_sheet(desk: Desk, second: int) -> None:
    sheet = PARTS.format(second=second)
    both = {"r001": [150.0, float(second)], "r002": [160.0], "r003": [], "r004": []}
    desk.take("s.csv", sheet)
    desk.say(assign, "s.csv#3", "r001", None, add=True)
    assert desk.charges() == both
    desk.take("grown.csv", f"{sheet}r003,170,12\n")
    assert desk.charges() == {**both, "r003": [170.0]}
    assert desk.inbox() == []
    desk.use("-grown.csv", "-s.csv", "+s.csv")
    assert desk.charges() == both
    assert not joules_unknown(desk, "r001")


def test_a_part_alone_is_no_charge_of_its_run(desk: Desk) -> None:
    desk.take("s.csv", PARTS.format(second=90))
    with refuses(UsageError, "r003", "--add"):
        desk.say(assign, "s.csv#3", "r003", None, add=True)
    desk.say(assign, "s.csv#3", "r001", None, add=True)
    desk.say(assign, "s.csv#1", "none", "another pack's")
    assert desk.charges()["r001"] == [90.0]
    assert joules_unknown(desk, "r001")
    desk.type_in("r001", 151.0)
    assert not joules_unknown(desk, "r001")
    desk.say(correct, f"charge:{desk.uid_of('r001')}", ["run=none"], "it was not")
    assert desk.charges()["r001"] == [151.0]
