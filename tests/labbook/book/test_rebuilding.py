"""Raw copies and journal are the truth: from them the same database is made again, to the row."""

from __future__ import annotations

import os
import re
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pyarrow as pa
import pytest
import sqlalchemy as sa

from data_schema.engine import postgres_engine, sqlite_engine, writing
from data_schema.errors import BookBusy, BookDamaged, UsageError
from data_schema.journal_file import NOTHING
from labbook.book.altered import Differences
from labbook.book.making import make_sqlite
from labbook.book.rebuilding import Place, Rebuilt, rebuild_database, replace_postgres, replace_sqlite
from tests.helpers.books import SmallBook, small_book
from tests.helpers.commands import KILLED, Commands, Running
from tests.helpers.databases import Rows, all_rows_by_name, server_in_a_soak
from tests.helpers.postgres import Cluster
from tests.helpers.statements import note, notes, said_alike, state
from tests.helpers.upkeep import rebuilt, rows_by_name, rows_with_keys
from tests.helpers.whole_book import judged_book
from tests.helpers.wording import refuses

SERVER_IN_A_SOAK = server_in_a_soak("book")
"""For what is settled by the journal before the engine matters."""


def test_everything_is_there_again_to_the_row_and_its_keys_and_the_book_goes_on(whole: SmallBook) -> None:
    before = rows_with_keys(whole.database)
    empty = {name for name, rows in before.items() if not rows}
    assert empty == {"instrument"}  # a table that nothing is written to proves nothing
    done = rebuilt(whole)
    assert (done.entries, done.differences) == (len(before["journal"]), Differences())
    assert rows_with_keys(whole.database) == before
    assert done.old is not None  # and the old one is kept
    assert rows_with_keys(whole.folder / done.old) == before
    with whole.open() as book:
        state(book, note, "afterwards")
        assert notes(book)[-1] == "afterwards"
        said_alike(book)


def test_a_book_moves_to_postgresql_and_back_and_every_row_is_the_same(postgres_url: str, whole: SmallBook) -> None:
    on_sqlite = rows_by_name(whole.folder)
    toml = whole.toml.read_text()
    there = rebuilt(whole, Place(postgres_url))
    assert there == Rebuilt(len(on_sqlite["journal"]), there.old, Differences(), NOTHING)
    assert rows_by_name(whole.folder, postgres_url) == on_sqlite
    assert not whole.database.exists()
    assert there.old is not None
    assert rows_with_keys(whole.folder / there.old)["journal"]
    with whole.open() as book:
        assert book.engine.dialect.name == "postgresql"
        state(book, note, "said on the server")
    assert rebuilt(whole, Place(None)).old is None
    with whole.open() as book:
        assert book.engine.dialect.name == "sqlite"
        assert notes(book)[-1] == "said on the server"
        assert len(said_alike(book)) == len(on_sqlite["journal"]) + 2  # and each labbook.toml in between
    assert whole.toml.read_text().split() == toml.split()


SCHEMA = """
SELECT format('column %%s.%%s %%s%%s', c.relname, a.attname, format_type(a.atttypid, a.atttypmod),
              CASE WHEN a.attnotnull THEN ' NOT NULL' ELSE '' END)
  FROM pg_attribute a JOIN pg_class c ON c.oid = a.attrelid
 WHERE c.relnamespace = 'labbook'::regnamespace AND c.relkind = 'r' AND a.attnum > 0 AND NOT a.attisdropped
UNION ALL
SELECT format('rule %%s.%%s %%s', conrelid::regclass, conname, pg_get_constraintdef(oid))
  FROM pg_constraint WHERE connamespace = 'labbook'::regnamespace AND contype IN ('p', 'u', 'c', 'f')
UNION ALL
SELECT format('index %%s', indexdef) FROM pg_indexes WHERE schemaname = 'labbook'
UNION ALL
SELECT pg_get_triggerdef(oid) FROM pg_trigger WHERE NOT tgisinternal
UNION ALL
SELECT pg_get_functiondef(oid) FROM pg_proc WHERE pronamespace = 'labbook'::regnamespace
"""


def schema_lines(connection: sa.Connection) -> list[str]:
    """What a PostgreSQL database is made of, one line a column, rule, index, trigger or function."""
    found = connection.exec_driver_sql(SCHEMA).scalars().all()
    return sorted(re.sub(r"\s+", " ", line).strip() for line in found)


def schema_and_rows(url: str) -> tuple[list[str], dict[str, Rows]]:
    """What the book is made of and holds; what lies in the schemas of rebuilds is left out."""
    engine = postgres_engine(url)
    try:
        with engine.connect() as connection:
            own = [line for line in schema_lines(connection) if "rebuil" not in line]
            return own, all_rows_by_name(engine)
    finally:
        engine.dispose()


def schemas(engine: sa.Engine) -> list[str]:
    with engine.connect() as connection:
        return [name for name in sa.inspect(connection).get_schema_names() if "rebuil" in name]


def execute(engine: sa.Engine, statements: str) -> None:
    with engine.begin() as connection:
        connection.exec_driver_sql(statements, execution_options={"no_parameters": True})


GUEST = """
CREATE TABLE public.run (theirs TEXT);
DROP ROLE IF EXISTS guest;
CREATE ROLE guest;
GRANT USAGE ON SCHEMA labbook TO guest;
GRANT SELECT, REFERENCES ON run TO guest;
GRANT SELECT ON report TO PUBLIC
"""


def test_what_was_lived_on_postgresql_is_made_again_in_its_own_database(tmp_path: Path, postgres_url: str) -> None:
    book = judged_book(tmp_path, postgres_url)
    before = schema_and_rows(postgres_url)
    with book.open() as standing:  # open meanwhile, and usable afterwards
        execute(standing.engine, GUEST)
        done = rebuilt(book)
        assert done.old is not None
        assert schemas(standing.engine) == [done.old]
        with standing.reading() as connection:
            old = connection.exec_driver_sql(f"SELECT count(*) FROM {done.old}.journal").scalar_one()
            rights = [
                connection.exec_driver_sql(f"SELECT has_{kind}_privilege('guest', '{of}', '{right}')").scalar_one()
                for kind, of, right in (
                    *(("table", "run", "SELECT"), ("table", "run", "REFERENCES"), ("table", "report", "SELECT")),
                    *(("schema", "labbook", "USAGE"), ("table", "run", "INSERT")),
                )
            ]
            assert connection.exec_driver_sql("SELECT count(*) FROM public.run").scalar_one() == 0
        assert old == done.entries
        assert rights == [True, True, True, True, False]
        assert schema_and_rows(postgres_url) == before
        for schema in ("labbook", done.old):
            with pytest.raises(sa.exc.DBAPIError, match="only ever added"):
                execute(standing.engine, f"DELETE FROM {schema}.journal")
        state(standing, note, "afterwards")
        said_alike(standing)
        assert notes(standing)[-1] == "afterwards"
        rebuilt(book)
        assert len(schemas(standing.engine)) == 2


@pytest.mark.parametrize(
    ("made", "named"),
    [
        ("CREATE VIEW public.remark AS SELECT text FROM note", "view public.remark"),
        ("CREATE TABLE theirs (x TEXT)", "table theirs"),
        (
            "CREATE TABLE public.photo (run INTEGER CONSTRAINT of_run REFERENCES run (id))",
            "of_run on table public.photo",
        ),
        (
            "CREATE FUNCTION how_many() RETURNS bigint LANGUAGE sql BEGIN ATOMIC SELECT count(*) FROM note; END",
            "function how_many()",
        ),
        ("CREATE FUNCTION shout(note) RETURNS text LANGUAGE sql AS 'SELECT upper($1.text)'", "function shout(note)"),
        ("CREATE POLICY own ON note USING (true)", "policy own on table note"),
        ("CREATE PUBLICATION out FOR TABLE note", "publication of table note in publication out"),
    ],
)
def test_what_cannot_follow_to_new_tables_is_named_before_anything_is_done(
    cluster: Cluster, postgres_book: Path, made: str, named: str
) -> None:
    url = cluster.url(cluster.fresh("finished_book"))
    engine = postgres_engine(url)
    execute(engine, made)
    before = schema_and_rows(url)
    with refuses(UsageError, named, "labbook", "drop it"):
        replace_postgres(url, lambda _engine: pytest.fail("begun"), lambda _engine, _standing: pytest.fail("begun"))
    assert schema_and_rows(url) == before
    assert schemas(engine) == []
    engine.dispose()


def test_on_postgresql_one_who_keeps_reading_stops_it(tmp_path: Path, postgres_url: str) -> None:
    book = small_book(tmp_path, ingested=False, database_url=postgres_url)
    before = schema_and_rows(postgres_url)
    with book.open() as standing, standing.reading() as connection:
        connection.exec_driver_sql("SELECT count(*) FROM run").scalar_one()
        with pytest.raises(BookBusy, match="another program"):
            replace_postgres(postgres_url, lambda _engine: None, lambda _engine, _standing: None, busy_timeout_s=0.1)
        assert schemas(standing.engine) == []
    assert schema_and_rows(postgres_url) == before


def test_a_role_without_rights_is_told_what_a_rebuild_needs(postgres_url: str, judged: SmallBook) -> None:
    engine = postgres_engine(postgres_url)
    execute(engine, "DROP ROLE IF EXISTS visitor; CREATE ROLE visitor LOGIN")
    engine.dispose()
    url = postgres_url.replace("labbook@", "visitor@")
    judged.toml.write_text(f'{judged.toml.read_text()}\n[database]\nurl = "{url}"\n')
    with pytest.raises(UsageError, match=r"permission denied.*GRANT CREATE"):
        rebuilt(judged)


# --- others at the same time


@SERVER_IN_A_SOAK
def test_what_is_said_while_a_book_is_rebuilt_is_in_it(book: SmallBook, commands: Commands) -> None:
    """One speaks when all that was there is applied, others at any moment."""
    running: list[Running] = []

    def speak(step: str) -> None:
        seq, last = step.split(" ")[0].split("/")
        if seq == last and not running:
            code, said = commands.run("note", "r001", "said last", "--book", book.folder)
            assert code == 0, said
            words = [("note", "r001", f"said {number}", "--book", book.folder) for number in range(4)]
            running.extend(commands.start(*some) for some in words)

    rebuild_database(book.folder, speak)
    assert [one.wait() for one in running] == [0] * 4
    with book.open() as standing:
        said_alike(standing)
        assert sorted(notes(standing)[-5:]) == ["said 0", "said 1", "said 2", "said 3", "said last"]
        rows = all_rows_by_name(standing.engine)
    assert rebuilt(book).differences == Differences()
    with book.open() as standing:
        assert all_rows_by_name(standing.engine) == rows


@SERVER_IN_A_SOAK
def test_a_second_rebuild_is_refused_while_one_runs(book: SmallBook) -> None:
    told: list[object] = []

    def again(_step: str) -> None:
        if not told:
            with refuses(BookBusy, "program is rebuilding") as caught:
                rebuilt(book)
            told.append(caught)

    rebuild_database(book.folder, again)
    assert len(told) == 1


def test_one_who_keeps_writing_stops_it(judged: SmallBook) -> None:
    before = rows_with_keys(judged.database)
    fresh = judged.folder.parent / "fresh.db"
    shutil.copy(judged.database, fresh)
    with closing(sqlite3.connect(judged.database, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with refuses(BookBusy, "is writing to", "labbook.db", "labbook rebuild"):
            replace_sqlite(judged.folder, fresh, lambda: pytest.fail("not alone"), busy_timeout_s=0.05)
    assert rows_with_keys(judged.database) == before


KILLED_WHILE_ALONE = """
import os, signal, sys
from pathlib import Path
from labbook.book.rebuilding import replace_sqlite

replace_sqlite(Path(sys.argv[1]), Path(sys.argv[2]), lambda: os.kill(os.getpid(), signal.SIGKILL))
"""


@pytest.mark.soak
def test_a_rebuild_that_is_killed_while_it_replaces_leaves_the_old_database(judged: SmallBook) -> None:
    before = rows_with_keys(judged.database)
    fresh = judged.folder / ".labbook.db.rebuild.fresh"
    make_sqlite(fresh)
    root = Path(__file__).parents[3]
    done = subprocess.run(
        [sys.executable, "-c", KILLED_WHILE_ALONE, judged.folder, fresh],
        env={**os.environ, "PYTHONPATH": str(root)},
        check=False,
    )
    assert done.returncode == KILLED
    assert rows_with_keys(judged.database) == before
    rebuilt(judged)
    assert rows_with_keys(judged.database) == before
    assert list(judged.folder.glob(".labbook*")) == []


def test_a_rebuild_that_is_killed_at_any_rename_keeps_the_old_database_for_good(
    tmp_path: Path, commands: Commands
) -> None:
    """Whatever the old one alone held is found again, also after the next rebuild has cleaned up."""
    for number in range(1, 10):
        book = small_book(tmp_path / str(number), ingested=False)
        with closing(sqlite3.connect(book.database)) as old:
            old.execute("CREATE TABLE theirs (x TEXT)")
        code, said = commands.run("rebuild", "--book", book.folder, die_before_rename=number)
        assert code in (0, KILLED), said
        rebuilt(book)
        tables = []
        for path in sorted(book.folder.glob("labbook.db*")):
            with closing(sqlite3.connect(path)) as database:
                tables += database.execute("SELECT name FROM sqlite_master").fetchall()
        assert ("theirs",) in tables
        assert list(book.folder.glob(".labbook*")) == []
        if code == 0:
            break
    assert code == 0
    assert number > 1


def test_a_move_to_postgresql_that_is_killed_at_any_rename_leaves_the_old_database_or_the_new(
    tmp_path: Path, postgres_url: str, commands: Commands
) -> None:
    book = small_book(tmp_path, ingested=False)
    engines = []
    for number in range(1, 10):
        code, said = commands.run(
            "rebuild", "--database", postgres_url, "--book", book.folder, die_before_rename=number
        )
        assert code in (0, KILLED), said
        with book.open() as standing:
            engines.append(standing.engine.dialect.name)
            state(standing, note, f"after {number}")
            said_alike(standing)
            assert notes(standing)[-number:] == [f"after {one}" for one in range(1, number + 1)]
        if code == 0:
            break
    assert code == 0
    assert engines == sorted(engines, reverse=True)
    assert set(engines) == {"sqlite", "postgresql"}


# --- what is not as it was


@pytest.mark.parametrize("how", ["changed", "removed", pytest.param("cut", marks=pytest.mark.soak)])
def test_a_raw_copy_that_is_not_what_was_kept_stops_it(judged: SmallBook, how: str) -> None:
    before, files = rows_with_keys(judged.database), sorted(judged.folder.rglob("*"))
    raw = sorted((judged.folder / "raw").rglob("*.zst"))[3]
    content = raw.read_bytes()
    raw.unlink()
    if how != "removed":
        raw.write_bytes(content[:-20] if how == "cut" else pa.Codec("zstd").compress(b"other bytes").to_pybytes())
    with refuses(BookDamaged, "raw copy raw/", raw.parent.name, raw.name, "from a backup", "--keep-going"):
        rebuilt(judged)
    raw.unlink(missing_ok=True)
    raw.write_bytes(content)
    assert rows_with_keys(judged.database) == before
    assert sorted(judged.folder.rglob("*")) == files


def test_a_database_that_is_no_longer_one_is_set_aside(judged: SmallBook) -> None:
    before = rows_with_keys(judged.database)
    judged.database.write_bytes(b"not a database " * 1000)
    old = rebuilt(judged).old
    assert old is not None
    assert (judged.folder / old).read_bytes() == b"not a database " * 1000
    assert rows_with_keys(judged.database) == before


def test_the_log_of_a_lost_database_is_not_read_into_the_new_one(judged: SmallBook) -> None:
    """`rm labbook.db` leaves labbook.db-wal, which SQLite would play back into whatever lies beside it next."""
    before, log = rows_with_keys(judged.database), judged.folder / "labbook.db-wal"
    engine = sqlite_engine(judged.database)
    with writing(engine) as connection:
        connection.exec_driver_sql("UPDATE note SET text = 'never said'")
    kept = log.read_bytes()
    engine.dispose()
    assert kept
    judged.database.unlink()
    log.write_bytes(kept)
    rebuilt(judged)
    assert rows_with_keys(judged.database) == before


@pytest.mark.parametrize(
    "most", [*(pytest.param(most, marks=pytest.mark.soak) for most in (100, 5_000, 60_000)), 150_000]
)
def test_a_rebuild_without_space_is_a_sentence_and_leaves_the_book(
    most: int, tmp_path: Path, commands: Commands
) -> None:
    book = small_book(tmp_path)
    before = book.database.read_bytes()
    code, said = commands.run("rebuild", "--book", book.folder, largest_file=most)
    assert (code, said.count("labbook: ")) == (3, 1), said
    assert "Traceback" not in said
    assert book.database.read_bytes() == before
    assert commands.run("db", "check", "--book", book.folder)[0] == 0
