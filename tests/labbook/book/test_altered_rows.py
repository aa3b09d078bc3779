"""Whatever is altered in the database outside labbook is found, named with what should stand there, and mended."""

from __future__ import annotations

import contextlib
import random
import sqlite3
import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import sqlalchemy as sa

from data_schema.engine import postgres_engine, sqlite_engine
from data_schema.errors import BookDamaged
from data_schema.journal import Entry
from data_schema.queries.history import list_reports
from data_schema.tables import METADATA
from labbook.actions.report_command import state_report
from labbook.actions.upkeep.tracing import ReportOfNumber, recompute
from labbook.book.altered import Misfit, altered_rows
from labbook.book.opening import Book
from labbook.book.rebuilding import rewrite_journal
from labbook.book.replaying import replayed
from labbook.book.report_numbers import NUMBERS, numbers_path, read_numbers
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.databases import server_in_a_soak
from tests.helpers.statements import note, state
from tests.helpers.upkeep import health, rebuilt, rebuilt_as_said
from tests.helpers.whole_book import copy_of_whole_book, whole_book
from tests.helpers.wording import refuses, says


def engine_of(book: SmallBook, url: str | None = None) -> sa.Engine:
    return postgres_engine(url) if url else sqlite_engine(book.database)


def execute(engine: sa.Engine, *statements: str) -> None:
    """As another program would; a statement that changes rows has to find some."""
    try:
        with engine.connect().execution_options(labbook_writes=True) as connection, connection.begin():
            for statement in statements:
                changed = connection.exec_driver_sql(statement).rowcount
                assert changed > 0 or statement.startswith(("ALTER", "CREATE", "DROP"))
    finally:
        engine.dispose()


SEVERE = "SELECT min(id) FROM finding WHERE severity <> 'note'"
ALL_WELL = "SELECT 'abc', target_kind, target_uid, 'all went well', person, at_utc FROM note WHERE id = 1"
ALTERATIONS = (
    ("UPDATE charge SET charge_mah = charge_mah * 0.8 WHERE id = 2", "altered in", "charge ", "charge_mah is "),
    ("UPDATE run_file SET run = 3 - run WHERE run IN (1, 2)", "altered in", "run_file ", "run is "),
    (f"UPDATE finding SET severity = 'note' WHERE id = ({SEVERE})", "altered in", "finding ", "'note' and should be "),
    ("UPDATE report SET selection = 'foot=large' WHERE id = 1", "altered in", "report ", "should be ''"),
    ("DELETE FROM decision WHERE id = 1", "removed from", "decision ", "is missing"),
    (f"INSERT INTO note (uid, target_kind, target_uid, text, person, at_utc) {ALL_WELL}", "added to", "note abc", ""),
)
"""What is done to rows, and what a check says of it."""


@server_in_a_soak("database_url")
def test_all_altered_rows_are_named_and_a_rebuild_says_and_mends_them(tmp_path: Path, database_url: str | None) -> None:
    book = whole_book(tmp_path, database_url) if database_url else copy_of_whole_book(tmp_path)
    execute(engine_of(book, database_url), *(statement for statement, *_said in ALTERATIONS))
    problems = health(book).problems
    for _statement, how, row, said in ALTERATIONS:
        says(problems, f"{how} the database: {row}", said)
    done = rebuilt(book)
    assert done.n_altered >= len(ALTERATIONS)
    assert {rows.sentence for rows in done.altered} <= {problem.partition(" Run `")[0] for problem in problems}
    assert health(book, deep=True).problems == ()


@server_in_a_soak("database_url")
def test_a_value_altered_in_any_column_and_a_row_deleted_from_any_table_is_named(
    tmp_path: Path, database_url: str | None
) -> None:
    made = whole_book(tmp_path, database_url) if database_url else copy_of_whole_book(tmp_path)
    tables = [table for table in METADATA.sorted_tables if table.name not in ("labbook", "journal", "instrument")]
    with (
        made.open() as book,
        replayed(book.store, book.mirror, 10**6, lambda _step: None, use_cache=True) as (engine, _replay),
        engine.connect() as fresh,
        (book.engine if database_url else sa.create_engine(f"sqlite:///{made.database}")).connect() as connection,
    ):
        assert altered_rows(connection, fresh) == []
        for table in tables:
            for column in (column for column in table.c if column.name != "id"):
                with altering(connection, table) as first_row:
                    value = connection.execute(sa.select(column).where(first_row)).scalar_one()
                    other = f"{value}x" if isinstance(column.type, sa.Text) else (value or 0) + 10**6
                    connection.execute(table.update().where(first_row).values({column: other}))
                    found = [row for row in altered_rows(connection, fresh) if row.table == table.name]
                assert any(
                    row.columns == [column.name] if row.how is Misfit.ALTERED else row.how is Misfit.REMOVED
                    for row in found
                ), column
            with altering(connection, table) as first_row:
                connection.execute(table.delete().where(first_row))
                found = [row for row in altered_rows(connection, fresh) if row.table == table.name]
            assert Misfit.REMOVED in [row.how for row in found], table


@contextlib.contextmanager
def altering(connection: sa.Connection, table: sa.Table) -> Iterator[sa.ColumnElement[bool]]:
    """Let the first row of a table be altered against all its rules; all is as it was afterwards."""
    keys = table.primary_key.columns
    if connection.dialect.name == "postgresql":
        rules = [rule.name for rule in table.constraints if isinstance(rule, sa.CheckConstraint)]
        lifted = [f"ALTER TABLE {table.name} DROP CONSTRAINT {rule}" for rule in rules]
        lifted.append("SET LOCAL session_replication_role = replica")
    else:
        lifted = ["PRAGMA ignore_check_constraints = 1"]  # foreign keys are off where nothing is said
    for statement in lifted:
        connection.exec_driver_sql(statement)
    first = connection.execute(sa.select(*keys).order_by(*keys)).first()
    assert first is not None, table
    yield sa.and_(*(key == value for key, value in zip(keys, first, strict=True)))
    connection.rollback()


def test_the_reports_that_rest_on_an_altered_row_are_named(whole: SmallBook) -> None:
    with whole.open() as book, book.reading() as connection:
        made = [report.called for report in list_reports(connection)]
    execute(engine_of(whole), "UPDATE charge SET charge_mah = charge_mah + 1 WHERE run = 2")
    (problem,) = health(whole).problems
    named = problem.partition("reports that rest on it: ")[2].partition(". ")[0].split(", ")
    assert named == made


def test_a_flipped_bit_of_a_stored_value_is_found(judged: SmallBook) -> None:
    """In the file itself, where SQLite sees nothing wrong: a REAL is eight bytes there, the highest first."""
    engine = engine_of(judged)
    with engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
        values = connection.exec_driver_sql("SELECT apex_height_m FROM jump WHERE apex_height_m > 0").scalars().all()
    engine.dispose()
    content = bytearray(judged.database.read_bytes())
    value = next(value for value in values if content.count(struct.pack(">d", value)) == 1)
    content[content.find(struct.pack(">d", value)) + 4] ^= 0x10
    judged.database.write_bytes(content)
    (problem,) = health(judged).problems
    says(problem, "in the database")
    assert f"and should be {value!r}" in problem


def test_rows_that_other_versions_made_are_no_alterations(judged: SmallBook) -> None:
    """As if an earlier version of a reader had read every log: journal and tables say so alike."""

    def earlier(entry: Entry) -> Entry:
        return replace(entry, new={**(entry.new or {}), "reader_version": 1}) if entry.reads else entry

    rebuilt_as_said(judged, earlier)
    execute(
        engine_of(judged),
        "UPDATE ingest SET reader_version = 1 WHERE status <> 'refused'",
        "UPDATE run SET jumps_made = 7 WHERE name = 'r001'",
    )
    anew, altered = health(judged).problems
    says(anew, "come out otherwise")
    says(altered, "run ", "r001", "jumps_made is 7 and should be")
    rebuilt(judged)
    assert health(judged).whole


@pytest.mark.parametrize("table", ["decision", pytest.param("config", marks=pytest.mark.soak)])
def test_an_order_that_was_turned_round_is_found(judged: SmallBook, table: str) -> None:
    """The last verdict on a jump counts, and the last configuration: no value of a row says which one that is."""
    if table == "config":
        with (judged.folder / "labbook.toml").open("a") as text:
            text.write("\n# another day\n")
        state_note(judged, "takes the change over")
    with contextlib.closing(sqlite3.connect(judged.database)) as connection, connection:
        (first, last) = connection.execute(f"SELECT min(id), max(id) FROM {table}").fetchone()
        assert first < last
        for old, new in ((first, -1), (last, first), (-1, last)):
            connection.execute(f"UPDATE {table} SET id = ? WHERE id = ?", (new, old))
    problems = health(judged).problems
    says(problems, "moved", table)
    rebuilt(judged)
    assert health(judged, deep=True).whole


def mean_of_r002(book: Book, connection: sa.Connection) -> ReportOfNumber:
    """The mean joules of this run's condition as the newest report has them."""
    condition = "condition_summary/quantity=joules a jump,condition=foot=small k_gain=400 b_ad_gain=100,"
    return next(
        ReportOfNumber(one, numbers, (report,))
        for report in reversed(list_reports(connection))
        for numbers in [read_numbers(book.store.root, report)]
        for one in numbers.numbers.values()
        if one.path.startswith(condition) and one.name == "mean"
    )


def test_a_number_of_a_forged_fact_does_not_stand_and_one_printed_before_is_told_so(whole: SmallBook) -> None:
    with whole.open() as book:
        with book.reading() as connection:
            honest = mean_of_r002(book, connection)
        execute(engine_of(whole), "UPDATE charge SET charge_mah = charge_mah + 5 WHERE stated_run = 'r002'")
        state_report(book, None, ADA, lambda _step: None)
        with book.reading() as connection:
            forged = mean_of_r002(book, connection)
        before, after = recompute(book, [honest, forged], lambda _step: None)
    assert (before.differs, before.stands, after.stands) == ((), False, False)
    assert "value" in after.differs
    says(before.sentence, "the same to the last digit", "charge_mah", "`labbook rebuild`")
    says(after.sentence, "does not stand", "value is")
    assert labbook("why", forged.number.id, "--check", at=whole.folder).code == 3
    rebuilt(whole)
    told = good(labbook("why", honest.number.id, "--check", at=whole.folder)).out
    says(told, "the same to the last digit")


TRIGGERS = {
    "sqlite": (
        "CREATE TRIGGER tt AFTER INSERT ON note BEGIN UPDATE charge SET charge_mah = 1; END",
        "DROP TRIGGER journal_never_changed",
    ),
    "postgresql": (
        "ALTER TABLE journal DISABLE TRIGGER journal_never_changed",
        "CREATE TRIGGER tt BEFORE UPDATE ON charge FOR EACH ROW EXECUTE FUNCTION journal_is_append_only()",
    ),
}


@server_in_a_soak("database_url")
def test_triggers_that_are_not_those_of_labbook_are_named(tmp_path: Path, database_url: str | None) -> None:
    book = small_book(tmp_path, ingested=False, database_url=database_url)
    assert health(book).whole
    execute(engine_of(book, database_url), *TRIGGERS["postgresql" if database_url else "sqlite"])
    problems = health(book).problems
    assert ["trigger tt " in problems[0], "journal_never_changed" in problems[1]] == [True, True]
    rebuilt(book)
    assert health(book).whole


def test_a_journal_cut_behind_its_guard_shows_in_the_rows(judged: SmallBook) -> None:
    """Who drops the guard can cut table and file alike; the rows of what was cut are still there."""
    path = judged.folder / "journal.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    execute(
        engine_of(judged), "DROP TRIGGER journal_never_deleted", f"DELETE FROM journal WHERE seq > {len(lines) - 2}"
    )
    path.write_text("".join(lines[:-2]))
    problems = health(judged).problems
    assert problems[0].startswith("trigger journal_never_deleted")
    says(problems[1:], "to the database")


def test_an_entry_whose_effect_is_there_already_names_the_remedy(judged: SmallBook) -> None:
    execute(
        engine_of(judged),
        "DROP TRIGGER journal_never_deleted",
        "DELETE FROM journal WHERE seq = (SELECT max(seq) FROM journal)",
    )
    with refuses(BookDamaged, "cannot take effect", "labbook rebuild"), judged.open() as book:
        state_report(book, None, ADA, lambda _step: None)


def test_no_damage_ends_a_check_without_a_sentence(judged: SmallBook) -> None:
    execute(engine_of(judged), "DROP TRIGGER journal_never_changed", "UPDATE journal SET new_json = '{' WHERE seq = 5")
    says(health(judged).problems, "5", "database was changed")
    lines = judged.journal.read_text(encoding="utf-8").splitlines(keepends=True)
    lines[3] = lines[3].replace('"new":{', '"new":{"x":NaN,', 1)
    judged.journal.write_text("".join(lines), encoding="utf-8")
    problems = health(judged).problems
    says(problems, "labbook restore")


def test_a_damaged_journal_that_holds_more_than_the_database_is_not_written_over(judged: SmallBook) -> None:
    kept = judged.database.read_bytes()
    state_note(judged, "said later")
    for piece in judged.folder.glob("labbook.db*"):
        piece.unlink()
    judged.database.write_bytes(kept)
    judged.journal.write_text(judged.journal.read_text(encoding="utf-8").replace("Nwosu", "Nwoso", 1), encoding="utf-8")
    before = judged.journal.read_bytes()
    with refuses(BookDamaged, "1", "entries that can"):
        rewrite_journal(judged.folder)
    assert judged.journal.read_bytes() == before


@pytest.mark.parametrize("many", [2, pytest.param(50, marks=pytest.mark.soak)])
def test_any_number_of_any_report_comes_out_again_to_the_last_digit(many: int, whole: SmallBook) -> None:
    with whole.open() as book:
        with book.reading() as connection:
            of_reports = [(each, read_numbers(book.store.root, each)) for each in list_reports(connection)]
        every = [
            ReportOfNumber(one, numbers, (report,))
            for report, numbers in of_reports
            for one in numbers.numbers.values()
        ]
        picked = random.Random(4).sample(every, many)
        assert [
            (found.anew is not None, found.differs, found.stands)
            for one in picked
            for found in recompute(book, [one], lambda _step: None)
        ] == [(True, (), True)] * many


def test_an_altered_numbers_json_is_damage_and_a_lost_one_is_said(whole: SmallBook) -> None:
    with whole.open() as book, book.reading() as connection:
        (first, *others) = list_reports(connection)
        elsewhere = {uid for each in others for uid in read_numbers(book.store.root, each).numbers}
        uid = next(uid for uid in read_numbers(book.store.root, first).numbers if uid not in elsewhere)
    path = numbers_path(whole.folder, first.files[NUMBERS])
    written = path.read_text(encoding="utf-8")
    good(labbook("why", uid, "--check", at=whole.folder))
    path.write_text(written.replace('"value":', '"value":1', 1), encoding="utf-8")
    for words in (("why", uid), ("why", uid, "--check"), ("reports", "show", "1"), ("reports", "diff", "1", "last")):
        refused(labbook(*words, at=whole.folder), 3, path.name)
    says(health(whole).problems, str(path), "altered")
    path.unlink()
    refused(labbook("why", uid, at=whole.folder), 2, f"1 of the {1 + len(others)} reports")
    refused(labbook("reports", "show", "1", at=whole.folder), 2, path.name, "numbers.json")
    found = health(whole)
    assert found.whole
    says(found.missing_numbers, str(path))
    good(labbook("reports", "show", "last", at=whole.folder))


def test_a_command_that_writes_warns_where_the_end_of_the_table_was_edited(
    judged: SmallBook, caplog: pytest.LogCaptureFixture
) -> None:
    state_note(judged, "before")
    assert caplog.messages == []
    execute(
        engine_of(judged),
        "DROP TRIGGER journal_never_changed",
        "UPDATE journal SET new_json = replace(new_json, 'before', 'after') WHERE seq = (SELECT max(seq) FROM journal)",
    )
    state_note(judged, "and another")
    (said,) = caplog.messages
    says(said, "database was changed")
    assert "`labbook rebuild`" in said


def state_note(book: SmallBook, text: str) -> None:
    with book.open() as standing:
        state(standing, note, text)
