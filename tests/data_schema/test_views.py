"""The views that people query: on both engines, with every example of docs/schema.md, and after a rebuild."""

from __future__ import annotations

import contextlib
import json
import re
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest
import sqlalchemy as sa

from data_schema.views import VIEWS
from scripts.schema_document import described
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import small_book
from tests.helpers.hopping_log import hopping_log
from tests.helpers.wording import says

COUNTS = {"v_run": 16, "v_level": 36, "v_charge": 16, "v_signal": 12, "v_jump": 36, "v_verdict": 0}
"""Rows of the small book."""
PAGE = Path(__file__).parents[2] / "docs" / "schema.md"


def examples(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def ran(words: list[str], at: Path) -> str:
    done = subprocess.run(words, cwd=at, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def queried(book: Path, query: str) -> list[tuple[object, ...]]:
    with contextlib.closing(sqlite3.connect(book / "labbook.db")) as connection:
        return connection.execute(query).fetchall()


def test_the_page_describes_the_views_as_they_are() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert described(text) == text


ROWS = {"v_run": 16, "v_level": 36, "v_charge": 16, "v_signal": 12, "v_jump": 36, "v_finding": 5, "v_note": 2}


@pytest.mark.parametrize("on", ["sqlite", "postgresql"])
def test_a_view_has_the_columns_that_are_described(on: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    url = request.getfixturevalue("postgres_url") if on == "postgresql" else None
    with small_book(tmp_path, database_url=url).open() as book, book.reading() as connection:
        for name, view in VIEWS.items():
            found = connection.execute(sa.text(f"SELECT * FROM {name}"))
            assert list(found.keys()) == list(view.columns)
            assert len(found.all()) == ROWS.get(name, 0)


def test_they_say_what_the_commands_say(tmp_path: Path) -> None:
    at = small_book(tmp_path).folder
    good(labbook("jumps", "reject", "r001", "2", "--reason", "misfire", at=at))
    good(labbook("jumps", "accept", "r001", "3", at=at))
    good(labbook("jumps", "clear", "r001", "3", at=at))
    good(labbook("correct", "r002", "mah=150", "--why", "misread", at=at))
    good(labbook("files", "withdraw", "r003.csv", "--why", "a copy", at=at))
    listed = good(labbook("jumps", "list", "r001", "--json", at=at)).json["jumps"]
    heights = queried(at, "SELECT jump, apex_height_m, verdict, reason FROM v_jump WHERE run = 'r001' ORDER BY jump")
    assert [(number, height) for number, height, _verdict, _reason in heights] == [
        (one["jump"]["number"], one["jump"]["apex_height_m"]) for one in listed
    ]
    assert [(verdict, reason) for _number, _height, verdict, reason in heights] == [
        (None, None),
        ("reject", "misfire"),
        (None, None),
    ]
    assert len(queried(at, "SELECT * FROM v_verdict")) == 3
    assert queried(at, "SELECT charge_mah FROM v_charge WHERE run = 'r002'") == [(150.0,)]
    assert queried(at, "SELECT * FROM v_signal WHERE run = 'r003'") == []
    assert queried(at, "SELECT * FROM v_jump WHERE run = 'r003'") == []


def test_a_verdict_is_on_the_stance_that_was_judged(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    good(labbook("files", "withdraw", "r001.csv", "--why", "another", at=book.folder))
    log = tmp_path / "hops.csv"
    log.write_bytes(hopping_log(8))
    good(labbook("ingest", log, "--run", "r001", at=book.folder))
    for said in (("reject", "9", "--reason", "other"), ("reject", "8", "--reason", "misfire"), ("clear", "9")):
        good(labbook("jumps", said[0], "r001", *said[1:], at=book.folder))
        listed = good(labbook("jumps", "list", "r001", "--json", at=book.folder)).json["jumps"]
        expected = [one["decision"] and one["decision"]["verdict"] for one in listed]
        assert len(expected) == 9
        found = queried(book.folder, "SELECT verdict FROM v_jump WHERE run = 'r001' ORDER BY jump")
        assert [verdict for (verdict,) in found] == expected


def test_a_view_that_cannot_be_made_again_is_named(tmp_path: Path) -> None:
    at = small_book(tmp_path).folder
    with contextlib.closing(sqlite3.connect(at / "labbook.db")) as connection:
        connection.execute("DROP VIEW v_run")
        for name in ("first_one", "V_Run", "last_one"):
            connection.execute(f"CREATE VIEW {name} AS SELECT name FROM run")
        connection.commit()
    says(good(labbook("rebuild", at=at)).out, "V_Run")
    assert len(queried(at, "SELECT * FROM first_one")) == len(queried(at, "SELECT * FROM last_one")) == 16


def test_ones_own_views_are_there_after_a_rebuild(tmp_path: Path) -> None:
    at = small_book(tmp_path).folder
    with contextlib.closing(sqlite3.connect(at / "labbook.db")) as connection:
        connection.execute("CREATE VIEW mine AS SELECT run, jumps_made FROM v_run WHERE kind = 'jumps'")
        connection.execute("CREATE TABLE shoe_sizes AS SELECT name FROM run")
        connection.commit()
    before = queried(at, "SELECT * FROM mine")
    says(good(labbook("rebuild", at=at)).out, "table shoe_sizes")
    says(good(labbook("db", "prune", at=at)).out, "shoe_sizes")
    good(labbook("db", "prune", "--yes", at=at))
    assert len(list(at.glob("labbook.db.before-rebuild.*"))) == 1
    assert queried(at, "SELECT * FROM mine") == before
    good(labbook("db", "check", at=at))


def test_on_postgresql_ones_own_view_on_a_view_is_named(tmp_path: Path, postgres_url: str) -> None:
    book = small_book(tmp_path, database_url=postgres_url)
    good(labbook("rebuild", at=book.folder))
    with book.open() as opened, opened.engine.begin() as connection:
        connection.exec_driver_sql("CREATE VIEW public.mine AS SELECT run FROM v_run")
    try:
        refused(labbook("rebuild", at=book.folder), 2, "mine")
    finally:
        with book.open() as opened, opened.engine.begin() as connection:
            connection.exec_driver_sql("DROP VIEW public.mine")
    good(labbook("rebuild", at=book.folder))


def test_with_sqlites_shell(tmp_path: Path) -> None:
    if shutil.which("sqlite3") is None:
        pytest.skip("sqlite3 is not installed: its example is not run")
    (line,) = re.findall(r"^ {4}(sqlite3 .*)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    rows = ran(["bash", "-c", line], small_book(tmp_path).folder).splitlines()
    assert len(rows) == 16
    assert rows[0].split("|")[:2] == ["r001", "2021-06-14"]


def test_with_datasette(tmp_path: Path) -> None:
    pytest.importorskip("datasette", reason="datasette is not installed: its example is not run")
    at = small_book(tmp_path).folder
    out = ran([sys.executable, "-m", "datasette", "labbook.db", "--get", "/labbook/v_charge.json?_shape=array"], at)
    assert {row["run"] for row in json.loads(out)} == {f"r{number:03d}" for number in range(1, 17)}


@pytest.mark.parametrize(("place", "facts"), [(0, ["samples", "signals/"]), (1, ["small", "large", "count"])])
def test_with_python(place: int, facts: list[str], tmp_path: Path) -> None:
    pytest.importorskip("duckdb", reason="duckdb is not installed: its example is not run")
    out = ran([sys.executable, "-c", examples("python")[place]], small_book(tmp_path).folder)
    assert [fact for fact in facts if fact not in out] == []


def test_with_r(tmp_path: Path) -> None:
    asked = ["Rscript", "-e", "stopifnot(requireNamespace('RSQLite', quietly = TRUE))"]
    if shutil.which("Rscript") is None or subprocess.run(asked, capture_output=True, check=False).returncode:
        pytest.skip("R with RSQLite is not installed: its example is not run")
    out = ran(["Rscript", "-e", examples("r")[0]], small_book(tmp_path).folder)
    assert "foot=small k_gain=400 b_ad_gain=0" in out
