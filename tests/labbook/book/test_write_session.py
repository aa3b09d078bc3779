"""The session: what is stated stands in table and file, all of it or none, and said by somebody."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from data_schema.errors import BookDamaged, InputRefused, LabbookError, UsageError
from data_schema.journal import chain_entries
from data_schema.journal_file import NOTHING
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.study import config_in_force
from data_schema.vocabulary import Action
from labbook.actions.runs.correcting import correct
from labbook.book.opening import Book
from labbook.book.rebuilding import rewrite_journal
from labbook.book.write_session import Statement, WriteSession, new_uid
from labbook.cli.main import application
from tests.helpers.books import ADA, BEN, SmallBook, small_book
from tests.helpers.databases import all_rows, server_in_a_soak
from tests.helpers.folders import contents
from tests.helpers.statements import note, notes, said_alike, state
from tests.helpers.upkeep import backed_up, rebuilt, rebuilt_as_said
from tests.helpers.whole_book import PACK_D
from tests.helpers.wording import refuses, says

SERVER_IN_A_SOAK = server_in_a_soak("book")
"""For what is settled by the journal before the engine matters."""


def refused(book: Book, kind: type[LabbookError], says: str, say: Callable[[WriteSession], object]) -> None:
    """Stating this is refused with the sentence, and neither database nor journal nor store changes."""
    rows, files = all_rows(book.engine), contents(book.store.root)

    def after_another(session: WriteSession) -> None:
        note(session, "this comes first and must go too")
        say(session)

    with pytest.raises(kind, match=says):
        state(book, after_another)
    assert all_rows(book.engine) == rows
    after = contents(book.store.root)
    assert {name: digest for name, digest in after.items() if not name.startswith("labbook.db")} == {
        name: digest for name, digest in files.items() if not name.startswith("labbook.db")
    }


# --- the clock


def test_a_clock_that_went_back_is_told_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    book = small_book(tmp_path)
    with book.open() as standing:
        state(standing, note, "in time")
        assert not caplog.messages
        last = said_alike(standing)[-1]
    tomorrow = (datetime.now(UTC) + timedelta(days=1)).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    rebuilt_as_said(book, lambda entry: replace(entry, at_utc=tomorrow) if entry.seq == last.seq else entry)
    with book.open() as standing:
        state(standing, note, "a day too early")
        says(caplog.messages[-1], "clock", tomorrow)
        told = len(caplog.messages)
        state(standing, note, "after it")
        assert len(caplog.messages) == told


# --- all or nothing


def test_what_is_stated_stands_in_table_and_file(book: SmallBook) -> None:
    with book.open() as standing:
        before = said_alike(standing)
        with standing.session(ADA) as session:
            note(session, "left rail squeaked")
            note(session, "oiled")
            said = list(session.entries)
        entries = said_alike(standing)
        assert entries == [*before, *chain_entries(said, (before[-1].seq, before[-1].hash))]
        assert [entry.following for entry in entries[-2:]] == [1, 0]
        assert {entry.person for entry in entries} == {ADA}
        assert notes(standing)[-2:] == ["left rail squeaked", "oiled"]


WRONG_VERDICT = {"target_kind": "run", "target_uid": "x", "verdict": "maybe", "reason_code": "other", "blind": 0}


def test_what_the_tables_refuse_leaves_nothing_of_the_command(book: SmallBook) -> None:
    def pack(name: str, cells: int, capacity_mah: float) -> Callable[[WriteSession], object]:
        return lambda session: session.declare("battery", name=name, cells=cells, capacity_mah=capacity_mah)

    def verdict(session: WriteSession) -> None:
        session.state(Statement(Action.SET, "decision", new_uid(), new=WRONG_VERDICT))

    with book.open() as standing:
        for kind, says, state in (
            (InputRefused, "verdict must be one of", verdict),
            (InputRefused, "cells must be 1 or more", pack("Z", 0, 1.0)),
            (InputRefused, "battery A cannot be stored", pack("A", 4, 1.0)),
            (InputRefused, "NULL and a reason", pack("Z", 4, float("nan"))),
            (
                UsageError,
                "jumps_made=1e300 cannot be stored: a whole number goes from",
                lambda session: correct(standing, session, "r001", ["jumps_made=1e300"], "typed wrong"),
            ),
            (
                UsageError,
                "duration_s=1e300 is beyond",
                lambda session: correct(standing, session, "r001", ["duration_s=1e300"], "typed wrong"),
            ),
        ):
            refused(standing, kind, says, state)


@SERVER_IN_A_SOAK
@pytest.mark.parametrize("letter", ["\udcff", "\0"])
def test_a_text_that_no_journal_can_hold_is_refused(book: SmallBook, letter: str) -> None:
    with book.open() as standing:
        refused(standing, InputRefused, "holds a byte that is not text", lambda session: note(session, f"a{letter}b"))


# --- file and database disagree


def test_of_a_command_cut_off_anywhere_all_or_nothing_is_there_after_the_next(tmp_path: Path) -> None:
    """The file as a power cut before the commit leaves it; the database knows nothing of the command."""
    made = small_book(tmp_path, ingested=False)
    database = made.database.read_bytes()
    before = made.journal.read_bytes()
    with made.open() as book:
        known = notes(book)
        with book.session(ADA) as session:
            for number in range(3):
                note(session, f"n{number}")
    whole = made.journal.read_bytes()
    ends = [at for at, letter in enumerate(whole, start=1) if letter == 10 and at > len(before)]
    assert len(ends) == 3
    for left in sorted(
        {len(before), *(end + near for end in ends for near in (-40, -1, 0, 1) if end + near <= len(whole))}
    ):
        for piece in made.folder.glob("labbook.db*"):
            piece.unlink()
        made.database.write_bytes(database)
        made.journal.write_bytes(whole[:left])
        with made.open() as book:
            state(book, note, "afterwards")
            all_of_it = ["n0", "n1", "n2"] if left >= len(whole) - 1 else []  # a newline that lacks is no loss
            assert notes(book) == [*known, *all_of_it, "afterwards"]
            said_alike(book)
            rows = all_rows(book.engine)
        if left in ends:
            rebuilt(made)
            with made.open() as book:
                assert all_rows(book.engine) == rows
    made.database.unlink()
    made.journal.write_bytes(whole[:-1])
    assert rebuilt(made).left_out == NOTHING
    with made.open() as book:
        assert notes(book) == [*known, "n0", "n1", "n2"]


@SERVER_IN_A_SOAK
@pytest.mark.parametrize("how", ["cut", "emptied", "removed"])
def test_a_file_behind_the_database_is_refused_and_written_anew(book: SmallBook, how: str, tmp_path: Path) -> None:
    whole = book.journal.read_bytes()
    lines = whole.splitlines(keepends=True)
    if how == "removed":
        book.journal.unlink()
    else:
        book.journal.write_bytes(b"".join(lines[:-3]) if how == "cut" else b"")
    with book.open() as standing:
        rows = all_rows(standing.engine)
        ways: list[Callable[[], object]] = [lambda: state(standing, note, "too early")]
        if how == "cut":
            ways += [lambda: rebuilt(book), lambda: backed_up(book.folder, tmp_path / "backup")]
        for do in ways:
            with pytest.raises(BookDamaged, match="`labbook rebuild --journal`") as caught:
                do()
            assert caught.value.exit_code == 3
            assert all_rows(standing.engine) == rows
        assert not (tmp_path / "backup" / "journal.jsonl").exists()
        assert rewrite_journal(book.folder) == len(lines)
        assert book.journal.read_bytes() == whole
        state(standing, note, "now")
        assert said_alike(standing)[-1].new is not None


@SERVER_IN_A_SOAK
def test_the_file_of_another_book_is_refused(book: SmallBook, tmp_path: Path) -> None:
    other = small_book(tmp_path / "other")
    with book.open() as standing, other.open() as stranger:
        for desk_of in (standing, stranger, stranger):
            state(desk_of, note, "said in one book only")
        lines = other.journal.read_bytes().splitlines(keepends=True)
        for foreign in (lines[:-1], lines):  # as long as our own, and longer
            book.journal.write_bytes(b"".join(foreign))
            with refuses(BookDamaged, "belong to different"):
                state(standing, note, "to whom?")
            assert book.journal.read_bytes() == b"".join(foreign)


@SERVER_IN_A_SOAK
def test_a_damaged_journal_is_kept_beside_the_new_one(book: SmallBook) -> None:
    whole = book.journal.read_bytes()
    damaged = whole.replace(b"rail", b"nail", 1)
    assert damaged != whole
    book.journal.write_bytes(damaged)
    rewrite_journal(book.folder)
    assert book.journal.read_bytes() == whole
    (kept,) = book.folder.glob("journal.jsonl.before-rebuild.*")
    assert kept.read_bytes() == damaged


# --- labbook.toml proposes


@pytest.fixture
def made(tmp_path: Path) -> SmallBook:
    """A finished book on SQLite: what is compared with labbook.toml does not depend on the engine."""
    return small_book(tmp_path)


def test_what_labbook_toml_adds_is_journalled_by_the_next_speaker(made: SmallBook) -> None:
    made.rewrite('"Ada Nwosu" = "AN"', '"Ada Nwosu" = "AN"\n"Ben Ode" = "BO"')
    made.rewrite("[batteries.A]", PACK_D)
    made.rewrite("levels = [0, 100]", "levels = [0, 100, 300]")
    with made.open() as standing:
        before = len(said_alike(standing))
        state(standing, note, "first words", person="BO")
        added = said_alike(standing)[before:]
        assert {entry.person for entry in added} == {BEN}
        assert [(str(entry.action), entry.entity_kind) for entry in added] == [
            ("set", "person"),
            ("set", "level"),
            ("set", "battery"),
            ("set", "config"),
            ("note", "note"),
        ]
        with standing.reading() as connection:
            in_force = config_in_force(connection)
            assert in_force is not None
            assert in_force.text == made.toml.read_text()
            assert find_uid(connection, "battery", name="D") is not None
        with standing.session(ADA):
            pass
        assert len(said_alike(standing)) == before + len(added)


CHANGES: list[tuple[str, str, str, str, object]] = [
    ("reference_voltage_v = 15.4", "reference_voltage_v = 16.8", "study", "reference_voltage_v", 16.8),
    ("jumps_nominal = 25", "jumps_nominal = 80", "study", "jumps_nominal", 80),
    ('kind = "bed"', 'kind = "force_plate"', "study", "kind", "force_plate"),
    ('time_zone = "America/New_York"', 'time_zone = "Europe/Berlin"', "study", "time_zone", "Europe/Berlin"),
    ('name = "granular bed (synthetic)"', 'name = "sand; \\"wet\\" $HOME"', "study", "name", 'sand; "wet" $HOME'),
    ("body_mass_kg = 1.8", "body_mass_kg = 1.9", "robot", "body_mass_kg", 1.9),
    ("[batteries.A]\ncells = 4", "[batteries.A]\ncells = 6", "battery", "cells", 6),
    ('[factors.foot]\nkind = "label"', '[factors.foot]\nkind = "label"\nunit = "m m"', "factor", "unit", "m m"),
    ("radius_m = 0.038", "radius_m = 0.0385", "level", "attributes_json", '{"radius_m":0.0385}'),
]


NAMED = {"robot": {"name": "hopper"}, "battery": {"name": "A"}, "factor": {"name": "foot"}, "level": {"label": "small"}}


@pytest.mark.parametrize(("old", "new", "kind", "field", "value"), CHANGES, ids=[change[3] for change in CHANGES])
def test_a_contradiction_is_refused_with_the_command_that_settles_it(
    made: SmallBook, old: str, new: str, kind: str, field: str, value: object
) -> None:
    made.rewrite(old, new)
    made.rewrite("[batteries.A]", PACK_D)  # an addition waits with the contradiction
    with made.open() as standing:
        before = said_alike(standing)

        with pytest.raises(InputRefused, match=f"labbook.toml says .*{field}") as caught:
            state(standing, note, "unsettled")
        assert said_alike(standing) == before
        command = str(caught.value).split("`")[1].replace('"..."', '"typed wrong"')
        words = shlex.split(command)
        assert words[:2] == ["labbook", "correct"]
        application()([*words[1:], "--book", str(made.folder)], standalone_mode=False)
        with standing.reading() as connection:
            uid = find_uid(connection, kind, **NAMED.get(kind, {}))
            assert uid is not None
            assert read_fact(connection, kind, uid, [field]) == {field: value}
            in_force = config_in_force(connection)
            assert in_force is not None
            assert in_force.sha256 == standing.configuration.sha256
            assert find_uid(connection, "battery", name="D") is not None
        (corrected,) = [
            entry for entry in said_alike(standing)[len(before) :] if entry.action is Action.SET and entry.old
        ]
        assert corrected.reason == "typed wrong"
        state(standing, note, "settled")
        assert said_alike(standing)[-1].entity_kind == "note"
