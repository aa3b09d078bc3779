"""A report while others write: it is of one entry of the journal, says which, and is traced and checked as of that."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from labbook.actions.report_command import WrittenReport, write
from labbook.actions.runs.correcting import correct
from labbook.actions.upkeep.report_differences import compare_reports, report_named
from labbook.actions.upkeep.tracing import find_number, recompute
from tests.cli.shell import good, labbook, process
from tests.helpers.books import ADA, SmallBook
from tests.helpers.statements import in_file, note, state
from tests.helpers.upkeep import health, rebuilt_alike
from tests.helpers.wording import says


def reported(book: SmallBook, said: list[str]) -> WrittenReport:
    """Make a report, with something said at every step of it: first a correction of a charge."""
    with book.open() as standing, book.open() as other:

        def somebody_speaks(step: str) -> None:
            if not said:
                with other.session(ADA) as session:
                    correct(other, session, "r001", ["mah=700"], "misread")
            state(other, note, step)
            said.append(step)

        return write(standing, None, None, ADA, somebody_speaks)


def test_a_report_is_of_the_entry_at_which_it_began(whole: SmallBook) -> None:
    said: list[str] = []
    with whole.open() as book:
        before = len(in_file(book))
    written = reported(whole, said)
    assert len(said) > 2
    with whole.open() as book:
        entry = in_file(book)[-1]
        assert (entry.new or {})["as_of"] == written.as_of == before
        assert written.later == entry.seq - 1 - before
    says(Path(written.page).read_text(), f"entry {before}")
    told = good(labbook("report", at=whole.folder))
    assert "came in" not in told.out
    with whole.open() as book, book.reading() as connection:
        first, second = (report_named(connection, name) for name in ("last-1", "last"))
        assert (first.as_of, second.as_of) == (before, entry.seq)
        moved = compare_reports(book, connection, first, second)
        assert moved.moved
        assert "misread" in {moved.causes[place].reason for item in moved.moved for place in item.causes}
        asked = [find_number(book, connection, item.now.id) for item in moved.moved[:2]]
        asked += [find_number(book, connection, item.was.id) for item in moved.moved[:2]]
    with whole.open() as book:
        assert [one.stands for one in recompute(book, asked, lambda _step: None)] == [True] * len(asked)
    assert health(whole, deep=True).problems == ()
    rebuilt_alike(whole)


def test_two_reports_of_one_second_have_a_folder_each(whole: SmallBook) -> None:
    with ThreadPoolExecutor(3) as pool:
        answers = list(pool.map(lambda _n: process("report", "--json", at=whole.folder), range(3)))
    folders = {good(answer).json["folder"] for answer in answers}
    assert len(folders) == 3
    assert health(whole).problems == ()
