"""The state of the book at any entry of its journal is what the book held when that was its last entry."""

from __future__ import annotations

from collections.abc import Callable

from data_schema.outcomes import Outcome
from labbook.actions.files.assigning import assign
from labbook.actions.files.stored_files import restore, withdraw
from labbook.actions.runs.correcting import correct, state_charge, unvoid, void
from labbook.actions.runs.jump_review import decide
from labbook.analysis.comparison.pairing import POOLED
from labbook.analysis.preregistration.book_state import BookHistory, BookState, difference, read_history, state_at
from labbook.book.opening import Book
from labbook.book.rebuilding import rebuild_database
from labbook.book.write_session import WriteSession
from tests.helpers.books import ADA, SmallBook
from tests.helpers.decided import ingests, planned, reports
from tests.helpers.wording import says

STATEMENTS: tuple[Callable[[Book, WriteSession], object], ...] = (
    lambda book, session: correct(book, session, "r002", ["foot=large"], "w"),
    lambda book, session: correct(book, session, "r003", ["battery=C", "day=2021-06-16", "position_in_day=20"], "w"),
    lambda book, session: correct(book, session, "r001", ["jumps_made=2", "starts=2", "duration_s=700"], "w"),
    lambda book, session: correct(book, session, "r005", ["kind=idle", "jumps_made=0", "levels=none"], "w"),
    lambda _book, session: assign(session, "2021-06-14.csv#2", "none", "w"),
    lambda book, session: state_charge(session, book.configuration, "r002", 77.0, None, None),
    lambda _book, session: assign(session, "r004.csv", "r001", "w"),
    lambda _book, session: assign(session, "r004.csv", "none", "w"),
    lambda _book, session: assign(session, "r004.csv", "r002", None),
    lambda book, session: decide(book, session, "r003", [1, 2], "reject", "wrong_apex", None),
    lambda _book, session: withdraw(session, "r006.csv", "w"),
    lambda _book, session: withdraw(session, "2021-06-16.csv", "w"),
    lambda book, session: decide(book, session, "r003", [1], "clear", "other", None),
    lambda _book, session: void(session, "r001", "misfire"),
    lambda _book, session: restore(session, "2021-06-16.csv", "w"),
    lambda _book, session: void(session, "r006", "sensor fault"),
    lambda _book, session: unvoid(session, "r001", "w"),
    lambda _book, session: restore(session, "r006.csv", "w"),
)


def history_of(made: SmallBook) -> BookHistory:
    with made.open() as book, book.reading() as connection:
        return read_history(connection)


def test_a_state_is_what_the_book_held_then(honest: SmallBook) -> None:
    held: dict[int, BookState] = {}
    late = honest.instruments / "r002 again.csv"
    late.write_bytes(honest.log("r003").read_bytes()[:-1] + b"0\n")

    def hold(book: Book) -> None:
        with book.reading() as connection:
            last = connection.exec_driver_sql("SELECT max(seq) FROM journal").scalar_one()
            held[last] = state_at(read_history(connection))

    with honest.open() as book:
        for said in STATEMENTS:
            hold(book)
            with book.session(ADA) as session:
                said(book, session)
        hold(book)
    assert len(held) == len(STATEMENTS) + 1
    ingests(honest, late)
    history = history_of(honest)
    for seq, state in held.items():
        assert not difference(state, state_at(history, seq))
        assert state == state_at(history, seq)
    rebuild_database(honest.folder, lambda _step: None)
    history = history_of(honest)
    assert [state_at(history, seq) for seq in held] == list(held.values())


def test_what_came_later_is_not_there_before_and_is_as_first_stated(honest: SmallBook) -> None:
    history = history_of(honest)
    first = min(entry.seq for entry in history.since.values() if entry.kind == "ingest")
    assert len(state_at(history, first - 1).runs) == 16
    assert not state_at(history, first - 1).charges
    assert len(state_at(history, first).logs) + len(state_at(history, first).charges) < 12
    assert state_at(history, first, arrivals=False) == state_at(history)


def test_runs_give_what_the_analysis_has_of_them(honest: SmallBook) -> None:
    with honest.open() as book:
        for said in STATEMENTS:
            with book.session(ADA) as session:
                said(book, session)
    measured = reports(honest).measured
    state = state_at(history_of(honest))
    for outcome, found in measured.results.items():
        assert set(found.results) == {run.uid for run in measured.evidence.runs if outcome in state.given(run.uid)}


def test_a_withdrawn_sheet_takes_its_runs_out_until_its_numbers_are_back(honest: SmallBook) -> None:
    with honest.open() as book, book.session(ADA) as session:
        withdraw(session, "2021-06-14.csv", "looked odd")
    found = planned(honest)
    assert [said.split(" without ")[1] for said in found.departures] == ["joules a jump"] * 8
    says(str(found.exploratory(Outcome.JOULES, POOLED)), "which leaves run", "r002")
    again = honest.instruments / "again.csv"
    again.write_bytes((honest.instruments / "charger" / "2021-06-14.csv").read_bytes() + b"\n")
    ingests(honest, again)
    assert planned(honest).departures == ()
