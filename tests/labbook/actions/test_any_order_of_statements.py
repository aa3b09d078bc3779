"""Whatever is said of files and charges in whatever order: a run has one charge, and a replay makes the same book.

Sheets name a charge of each run twice over, by two columns of runs and two of amounts: another declaration has a row
name another run, another amount, or leaves the row out.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule, run_state_machine_as_test

from data_schema.errors import LabbookError
from data_schema.queries.files import find_files, last_readings, links_of_file, parts_of_file
from data_schema.vocabulary import FileRole, IngestStatus
from ingest.tables.sheet import SheetFile
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.files.rereading import RereadRequest
from labbook.actions.files.stored_files import dismiss, reread_named, restore, restore_item, withdraw
from labbook.actions.runs.correcting import correct, state_charge, state_check, unvoid, void
from labbook.actions.runs.jump_review import decide
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.opening import opened
from labbook.book.rebuilding import rebuild_database
from labbook.book.replaying import replayed
from tests.helpers.books import ADA, SmallBook, copy_of, instrument_files, on_server, small_book
from tests.helpers.databases import all_rows_by_name
from tests.helpers.statements import note, state

RUNS = ("r001", "r002", "r003")
SHEETS = ("s1.csv", "s2.csv", "s3.csv")
HEADER = "run_a,run_b,first,second,minutes"
ROWS = st.tuples(
    st.sampled_from(("r001", "r001", "r002", "r009", "")),
    st.sampled_from(("r001", "r002", "r003")),
    st.sampled_from(("150", "150", "99")),
    st.sampled_from(("150", "99", "")),
)
READINGS = tuple(itertools.product(("run_a", "run_b"), ("first", "second")))
LOG_ROWS = "".join(f"{4 * i},{0.4 + 0.001 * i:.4f}\n" for i in range(300))
LOGS = ("r003.csv", "both.csv")
FILES = st.sampled_from((*SHEETS, *LOGS))
SHEET_ROWS = st.builds("{}#{}".format, st.sampled_from(SHEETS), st.integers(1, 5))


def as_sheet(of_run: str, amount: str) -> dict[str, Any]:
    """What is declared: which column names the run, and which the charge."""
    return {"columns": {of_run: {"channel": "run"}, amount: {"channel": "charge", "unit": "mAh"}}}


def book_of_three_runs(folder: Path, database_url: str | None) -> SmallBook:
    """Make, or copy, a book with three runs and nothing of the instruments."""

    def make(above: Path) -> SmallBook:
        small = small_book(above, runs=False, ingested=False, database_url=database_url)
        sheet = (small.instruments / "runs.csv").read_text().splitlines(keepends=True)[: 1 + len(RUNS)]
        with small.open() as book:
            state(book, import_runs, SheetFile("runs.csv", "".join(sheet).encode()))
        return small

    if database_url is None:
        return copy_of("three-runs", make, folder)
    return on_server("three-runs", make, folder, database_url)


COUNTED = """
SELECT c.uid, c.state, c.line, c.mode, c.added, r.name AS run, c.repeats, c.file, i.status, i.uid AS reading
FROM charge c LEFT JOIN run r ON r.id = c.run
LEFT JOIN ingest i ON i.file = c.file AND i.status IN ('imported', 'withdrawn', 'waiting')
ORDER BY c.id
"""


class Statements(RuleBasedStateMachine):
    """A person at a book who may say anything at any time."""

    database_url: str | None = None
    replayed_at_each_step = False

    @initialize(rows=st.lists(ROWS, min_size=3, max_size=4), cut=st.integers(1, 3), more=ROWS)
    def begin(self, rows: list[tuple[str, ...]], cut: int, more: tuple[str, ...]) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="any-order-"))
        book_of_three_runs(self.folder, self.database_url)
        lines = [",".join((*row, "12")) for row in rows]
        sheets = (lines, [*lines, ",".join((*more, "12"))], [*lines[:cut], "# kept by another", *lines[cut + 1 :]])
        for name, content in zip(SHEETS, sheets, strict=True):
            (self.folder / name).write_text("\n".join([HEADER, *content]) + "\n")
        header, *jumps = instrument_files()["logs/r003.csv"].decode().splitlines(keepends=True)
        (self.folder / "r003.csv").write_text("".join([header, *jumps[::5]]))
        (self.folder / "both.csv").write_text(f"time [ms],z\n{LOG_ROWS}{LOG_ROWS}")
        self.on_book = contextlib.ExitStack()
        self.book = self.on_book.enter_context(opened(self.folder / "book"))
        for name in (*SHEETS[:2], *LOGS):
            options = as_sheet(*READINGS[0]) if name in SHEETS else {}
            taken = ingest_file(self.book, self.folder / name, IngestRequest(None, options, person=ADA))
            assert taken.status is IngestStatus.IMPORTED

    def teardown(self) -> None:
        if not hasattr(self, "book"):
            return
        try:
            before = all_rows_by_name(self.book.engine)
            self.on_book.close()
            rebuild_database(self.folder / "book", lambda _step: None)
            with opened(self.folder / "book") as book:
                after = all_rows_by_name(book.engine)
            for table, rows in before.items():
                assert after[table] == rows, table
        finally:
            self.on_book.close()
            shutil.rmtree(self.folder)

    @contextlib.contextmanager
    def may_be_refused(self) -> Iterator[None]:
        """A statement that has no meaning now is refused in one sentence."""
        try:
            yield
        except LabbookError as error:
            self.refused = str(error)
            assert "\n" not in self.refused

    def say(self, action: Callable[..., object], *given: object, **named: Any) -> None:
        with self.may_be_refused():
            state(self.book, action, *given, **named)

    def rows(self) -> list[dict[str, Any]]:
        with self.book.reading() as connection:
            return [dict(row) for row in connection.exec_driver_sql(COUNTED).mappings()]

    def charge(self, which: int) -> str | None:
        found = self.rows()
        return found[which % len(found)]["uid"] if found else None

    @rule(name=st.sampled_from(SHEETS), how=st.sampled_from(READINGS), run=st.sampled_from((None, None, "r002")))
    def ingest_sheet(self, name: str, how: tuple[str, str], run: str | None) -> None:
        with self.may_be_refused():
            ingest_file(self.book, self.folder / name, IngestRequest(run, as_sheet(*how), person=ADA))

    @rule(name=st.sampled_from(LOGS), run=st.sampled_from((None, "r001", "r003")))
    def ingest_log(self, name: str, run: str | None) -> None:
        with self.may_be_refused():
            ingest_file(self.book, self.folder / name, IngestRequest(run, {}, person=ADA))

    @rule(name=st.sampled_from(SHEETS), how=st.sampled_from(READINGS))
    def reread_sheet(self, name: str, how: tuple[str, str]) -> None:
        with self.may_be_refused():
            reread_named(self.book, name, RereadRequest(as_sheet(*how), ADA, "otherwise"))

    @rule(name=st.sampled_from(LOGS), sign=st.sampled_from((1, -1)))
    def reread_log(self, name: str, sign: int) -> None:
        column = {"r003.csv": "body_height [m]", "both.csv": "z"}[name]
        height = {"channel": "body_height", "unit": "m", "sign": sign}
        options = {"columns": {column: height}, "no_robot_check": True}
        with self.may_be_refused():
            reread_named(self.book, name, RereadRequest(options, ADA, "otherwise"))

    @rule(name=FILES)
    def withdraw_file(self, name: str) -> None:
        self.say(withdraw, name, "a draft")

    @rule(what=FILES | SHEET_ROWS, run=st.sampled_from((*RUNS, "none")))
    def assign_any(self, what: str, run: str) -> None:
        self.say(assign, what, run, "so it was")

    @rule(part=st.sampled_from(("both.csv#log", "both.csv#log_segment_2")), run=st.sampled_from((*RUNS, "none")))
    def assign_part(self, part: str, run: str) -> None:
        self.say(assign, part, run, "so it was")

    @rule(row=SHEET_ROWS, run=st.sampled_from(RUNS))
    def add_row(self, row: str, run: str) -> None:
        self.say(assign, row, run, None, add=True)

    @rule(which=st.integers(0, 20), said=st.sampled_from(("charge_mah=150", "charge_mah=77", "run=r003", "run=none")))
    def correct_charge(self, which: int, said: str) -> None:
        uid = self.charge(which)
        self.say(correct, f"charge:{uid}", [said], "misread")

    @rule(row=SHEET_ROWS)
    def dismiss_row(self, row: str) -> None:
        self.say(dismiss, row, "of another robot")

    @rule(what=FILES | SHEET_ROWS)
    def restore_any(self, what: str) -> None:
        self.say(restore_item if "#" in what else restore, what, None)

    @rule(run=st.sampled_from(RUNS), amount=st.sampled_from((150.0, 99.0)), add=st.booleans())
    def type_charge(self, run: str, amount: float, add: bool) -> None:
        self.say(state_charge, run, amount, None, None, add=add)

    @rule(jump=st.integers(1, 3), verdict=st.sampled_from(("accept", "reject", "clear")))
    def decide_on_jump(self, jump: int, verdict: str) -> None:
        self.say(decide, "r003", [jump], verdict, "touched_by_hand", None)

    @rule(
        run=st.sampled_from(RUNS),
        said=st.sampled_from(
            ("jumps=5", "minutes=14", "date=2021-06-15", "position=9", "battery=B", "starts=2", "b_ad_gain=100")
        ),
    )
    def correct_run(self, run: str, said: str) -> None:
        self.say(correct, run, [said], "misread")

    @rule(run=st.sampled_from(RUNS), again=st.booleans())
    def void_run(self, run: str, again: bool) -> None:
        self.say(unvoid if again else void, run, "a slip")

    @rule(run=st.sampled_from(RUNS))
    def write_note(self, run: str) -> None:
        self.say(note, "a cable came loose", run)

    @rule(kind=st.sampled_from(("rail_angle", "lubrication")), passed=st.booleans())
    def check_day(self, kind: str, passed: bool) -> None:
        self.say(state_check, kind, None, None, passed, "2021-06-14")

    @invariant()
    def a_run_has_one_charge_that_its_sheet_holds(self) -> None:
        if not hasattr(self, "book"):
            return
        found = self.rows()
        state = {row["uid"]: row["state"] for row in found}
        held = self.lines_held()
        of_runs = [row["run"] for row in found if row["state"] == "counted" and row["run"] and not row["added"]]
        assert len(of_runs) == len(set(of_runs)), found
        for row in found:
            if row["state"] == "counted" and row["file"] is not None:
                assert row["status"] == "imported", found
                assert row["line"] in held[row["reading"]], found
            assert row["run"] or not row["added"] or row["state"] == "gone", found
            if row["state"] == "known":
                assert state[row["repeats"]] in ("counted", "dismissed"), found
                assert row["run"] is None, found

    @invariant()
    def parts_that_belong_to_runs_are_parts_of_the_reading(self) -> None:
        if not hasattr(self, "book"):
            return
        with self.book.reading() as connection:
            for row in last_readings(connection):
                if row.role == FileRole.LOG and row.status is IngestStatus.IMPORTED:
                    (file,) = find_files(connection, row.file_uid or "")
                    linked = [link.part for link in links_of_file(connection, file.uid)]
                    assert len(linked) == len(set(linked))
                    assert set(linked) <= set(parts_of_file(connection, file.uid))

    @invariant()
    def a_replay_gives_the_same_rows(self) -> None:
        if not hasattr(self, "book") or not self.replayed_at_each_step:
            return
        last = self.book.mirror.last()
        assert last is not None
        with replayed(self.book.store, self.book.mirror, last.seq, lambda _step: None, use_cache=True) as (engine, _):
            assert all_rows_by_name(engine) == all_rows_by_name(self.book.engine)

    def lines_held(self) -> dict[str, list[int]]:
        """The lines of the charges that each reading gave, as the journal has it."""
        query = "SELECT entity_uid, new_json FROM journal JOIN ingest ON uid = entity_uid WHERE file IS NOT NULL"
        with self.book.reading() as connection:
            return {row[0]: json.loads(row[1])["charge_lines"] for row in connection.exec_driver_sql(query)}


@pytest.mark.parametrize(
    ("examples", "steps", "replayed_at_each_step"),
    [
        (3, 12, False),
        pytest.param(1000, 30, False, marks=pytest.mark.soak),
        pytest.param(100, 30, True, marks=pytest.mark.soak),
    ],
)
def test_any_order_of_statements(
    database_url: str | None, examples: int, steps: int, replayed_at_each_step: bool
) -> None:
    class OnThisEngine(Statements):
        pass

    OnThisEngine.database_url = database_url
    OnThisEngine.replayed_at_each_step = replayed_at_each_step
    run_state_machine_as_test(
        OnThisEngine,
        settings=settings(
            max_examples=examples,
            stateful_step_count=steps,
            derandomize=examples < 100,
            phases=(Phase.generate,),
            suppress_health_check=list(HealthCheck),
        ),
    )
