"""A file that was taken in half-written is withdrawn for the whole one: in one command, and nothing is lost."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from data_schema import journal
from data_schema.vocabulary import Action, IngestStatus
from ingest.store import Store
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import FileOutcome, IngestRequest, ingest_file
from labbook.actions.files.stored_files import restore, withdraw
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.jump_review import decide
from labbook.actions.runs.rig_line import rig_lines_of
from labbook.book.opening import Book
from tests.helpers.books import ADA, SmallBook, instrument_files, small_book
from tests.helpers.statements import in_table, state
from tests.helpers.upkeep import health, rebuilt_alike
from tests.helpers.wording import says

LOG = instrument_files()["logs/r001.csv"]
HALF = LOG[: LOG.index(b"\n", len(LOG) // 2) + 1]
WATCHED = IngestRequest(person=ADA, batch="abcdefabcdef", replace_beginnings=True)


@pytest.fixture
def small(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path, ingested=False)


@pytest.fixture
def book(small: SmallBook) -> Iterator[Book]:
    with small.open() as book:
        yield book


def take(book: Book, folder: Path, content: bytes, name: str = "r001.csv", **asked: object) -> FileOutcome:
    path = folder / name
    path.write_bytes(content)
    return ingest_file(book, path, replace(WATCHED, **asked))  # type: ignore[arg-type]


def in_use(book: Book) -> dict[str, tuple[str, ...]]:
    """The files in use by the beginnings of their hashes, with their runs."""
    query = (
        "SELECT f.sha256, r.name FROM file f JOIN ingest i ON i.file = f.id AND i.status IN ('imported', 'waiting') "
        "LEFT JOIN run_file l ON l.file = f.id LEFT JOIN run r ON r.id = l.run ORDER BY r.name"
    )
    found: dict[str, tuple[str, ...]] = {}
    with book.reading() as connection:
        for sha256, run in connection.exec_driver_sql(query):
            found[sha256] = (*found.get(sha256, ()), *([run] if run else []))
    return found


def test_the_whole_log_takes_the_place_of_its_half_in_one_command(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        half = take(book, tmp_path, HALF)
        before = len(in_table(book))
        whole = take(book, tmp_path, LOG)
        assert (half.status, whole.status) == (IngestStatus.IMPORTED, IngestStatus.IMPORTED)
        assert in_use(book) == {whole.sha256: ("r001",)}
        ((withdrawn, ingested),) = journal.commands(in_table(book)[before:])
        assert (withdrawn.action, ingested.action) == (Action.EXCLUDE, Action.INGEST)
        says(withdrawn.reason, "r001.csv", whole.sha256[:12])
        assert whole.replaced == (withdrawn.entity_uid,)
        ((line,),) = rig_lines_of(book, [whole])
        assert (line.jumps_found, line.jumps_made) == (3, 3)
        assert book.store.has_raw(half.sha256)
    assert health(small, deep=True).problems == ()
    rebuilt_alike(small)


def test_without_being_asked_both_stay_and_none_counts(book: Book, tmp_path: Path) -> None:
    take(book, tmp_path, HALF, replace_beginnings=False)
    whole = take(book, tmp_path, LOG, replace_beginnings=False)
    (lines,) = rig_lines_of(book, [whole])
    assert {line.concern for line in lines} == {"logs_too_many"}


def test_it_keeps_the_run_and_what_was_declared(book: Book, tmp_path: Path) -> None:
    def bare(content: bytes) -> bytes:
        return content.replace(b"body_height [m]", b"h")

    half = take(
        book, tmp_path, bare(HALF), "log.csv", options={"columns": {"h": {"channel": "body_height", "unit": "m"}}}
    )
    assert half.runs == ()
    state(book, assign, "log.csv", "r002", None)
    whole = take(book, tmp_path, bare(LOG), "log.csv")
    assert in_use(book) == {whole.sha256: ("r002",)}
    ((line,),) = rig_lines_of(book, [whole])
    assert line.jumps_found == 3


def test_one_that_a_person_took_off_its_run_stays_off(book: Book, tmp_path: Path) -> None:
    take(book, tmp_path, HALF)
    state(book, assign, "r001.csv", "none", "of another robot")
    whole = take(book, tmp_path, LOG)
    assert in_use(book) == {whole.sha256: ()}


def test_one_that_a_person_withdrew_stays_withdrawn_and_is_no_beginning(book: Book, tmp_path: Path) -> None:
    half = take(book, tmp_path, HALF)
    state(book, withdraw, "r001.csv", "the wrong robot")
    whole = take(book, tmp_path, LOG)
    assert whole.replaced == ()
    assert half.sha256 not in in_use(book)
    state(book, restore, half.sha256[:12], None)
    assert len(in_use(book)) == 2


def test_a_log_that_only_has_the_name_replaces_nothing(book: Book, tmp_path: Path) -> None:
    other = take(book, tmp_path, instrument_files()["logs/r002.csv"], "LOG.csv", run="r002")
    one = take(book, tmp_path, LOG, "LOG.csv", run="r001")
    assert in_use(book) == {other.sha256: ("r002",), one.sha256: ("r001",)}


def test_a_beginning_that_comes_after_the_whole_is_nothing_new(book: Book, tmp_path: Path) -> None:
    whole = take(book, tmp_path, LOG)
    before = in_table(book)
    for _again in range(2):
        half = take(book, tmp_path, HALF)
        assert half.status is IngestStatus.DUPLICATE
        assert half.first is not None
        assert half.first.original_name == "r001.csv"
    assert in_table(book) == before
    assert in_use(book) == {whole.sha256: ("r001",)}


def test_a_half_that_was_replaced_and_comes_again_is_nothing_new(book: Book, tmp_path: Path) -> None:
    take(book, tmp_path, HALF)
    take(book, tmp_path, LOG)
    again = take(book, tmp_path, HALF)
    assert again.status is IngestStatus.DUPLICATE
    assert not any("restore" in message for message in again.messages)


def test_space_allocated_beforehand_is_filled(book: Book, tmp_path: Path) -> None:
    half = take(book, tmp_path, HALF + bytes(len(LOG) - len(HALF)))
    assert half.status is IngestStatus.IMPORTED
    whole = take(book, tmp_path, LOG)
    assert in_use(book) == {whole.sha256: ("r001",)}


def test_a_whole_that_is_refused_leaves_its_half_in_use(book: Book, tmp_path: Path) -> None:
    half = take(book, tmp_path, HALF)
    refused = take(book, tmp_path, HALF + bytes(range(256)) * 4000)
    assert refused.status is IngestStatus.REFUSED
    assert in_use(book) == {half.sha256: ("r001",)}


def test_verdicts_on_jumps_of_the_half_are_named(book: Book, tmp_path: Path) -> None:
    take(book, tmp_path, HALF)
    state(book, decide, "r001", [1], "reject", "touched_by_hand", None)
    whole = take(book, tmp_path, LOG)
    says(whole.messages, "1 verdict", "labbook show r001")


def test_a_sheet_of_recharges_that_grows_keeps_what_people_corrected(book: Book, tmp_path: Path) -> None:
    sheet = instrument_files()["charger/2021-06-14.csv"]
    shorter = sheet[: sheet.index(b"r004")]
    take(book, tmp_path, shorter, "charges.csv")
    state(book, correct, "r002", ["mah=123"], "misread")
    whole = take(book, tmp_path, sheet, "charges.csv")
    assert whole.replaced == ()
    with book.reading() as connection:
        charges = dict(
            connection.exec_driver_sql("SELECT r.name, c.charge_mah FROM charge c JOIN run r ON r.id = c.run").all()
        )
    assert len(charges) == 8
    assert charges["r002"] == 123


def test_what_another_command_left_in_the_journal_alone_is_replaced_too(small: SmallBook, tmp_path: Path) -> None:
    """A half whose ingest was killed between journal and commit is a beginning all the same."""
    with small.open() as book:
        untouched = small.database.read_bytes()
        half = take(book, tmp_path, HALF)
    for path in small.folder.glob("labbook.db*"):
        path.unlink()
    small.database.write_bytes(untouched)
    with small.open() as book:
        assert in_use(book) == {}
        whole = take(book, tmp_path, LOG)
        assert in_use(book) == {whole.sha256: ("r001",)}
        assert whole.replaced
        assert book.store.has_raw(half.sha256)


def begins_with(copy: bytes, data: bytes) -> bool | None:
    if data.startswith(copy):
        return True
    if copy.startswith(data):
        return False
    written = copy.rstrip(b"\0")
    return True if written and data.startswith(written) else None


PIECE = st.binary(min_size=1, max_size=4)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(PIECE, st.sampled_from([1, 5000]), st.integers(0, 3), st.sampled_from([0, 1, 5000]), PIECE, st.booleans())
def test_which_begins_with_which(
    tmp_path: Path, piece: bytes, times: int, cut: int, nuls: int, more: bytes, shorter: bool
) -> None:
    written = piece * times
    copy = written + bytes(nuls)
    data = written[: len(written) - cut] if shorter else written[: len(written) - cut] + more
    store = Store(tmp_path)
    path = store.put_raw(copy, hashlib.sha256(copy).hexdigest()).path
    if data:
        assert store.is_beginning(path, data) is begins_with(copy, data)
