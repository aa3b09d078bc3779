"""A small but whole book for tests, made by the demonstration's own writers.

Two days, two feet, one extension gain, the control and one active-damping gain: twelve jump runs of three jumps, four
idle runs, a charger sheet a day. The finished book is made once a test run and copied, so that asking for it is quick.
"""

from __future__ import annotations

import contextlib
import datetime as dt
import functools
import os
import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from data_schema.vocabulary import RunKind
from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.files.named_files import files_of
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import state_check
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.making import make_book
from labbook.book.opening import Book, opened
from labbook.demo.campaign import DemoRun
from labbook.demo.files import FACTORS, book_toml
from labbook.demo.logger import DECIMALS, run_log
from labbook.demo.truth import Condition
from labbook.demo.writers import charger_sheet, run_sheet, string_pot_log
from tests.helpers.once import made_once
from tests.helpers.postgres import cluster_of
from tests.helpers.stated_campaign import GROUPS, STATED

ADA = "Ada Nwosu"
BEN = "Ben Ode"
SEED = 3
JUMPS = 3
TRUTH = replace(
    STATED,
    # Ten times the energy of a jump, so that three of them stand out from a charger's whole mAh.
    groups=tuple(replace(group, control_joules_per_jump=10 * group.control_joules_per_jump) for group in GROUPS[::2]),
    ad_gains=(100,),
)
DAYS = (dt.date(2021, 6, 14), dt.date(2021, 6, 16))

_SMALL, _LARGE = "small", "large"
_ORDER = ((_SMALL, 0), (_SMALL, 100), (_LARGE, 0), (_SMALL, 100), (_LARGE, 100), (_SMALL, 0))
"""The jump runs of a day as (foot, active-damping gain); two idle runs follow."""
_IDLE_MINUTES = ((20, 40), (30, 60))


@dataclass(frozen=True, slots=True)
class SmallBook:
    """Where a small book and the files of its instruments lie.

    `instruments` holds `runs.csv`, `logs/rNNN.csv` and `charger/DATE.csv`; r001 to r006 are the jump runs of the first
    day, r007 and r008 its idle runs, r009 to r016 the same on the second day.
    """

    folder: Path
    instruments: Path

    def open(self) -> contextlib.AbstractContextManager[Book]:
        return opened(self.folder)

    @property
    def toml(self) -> Path:
        return self.folder / "labbook.toml"

    @property
    def journal(self) -> Path:
        return self.folder / "journal.jsonl"

    @property
    def database(self) -> Path:
        """The SQLite file; absent in a book on PostgreSQL."""
        return self.folder / "labbook.db"

    def log(self, run: str) -> Path:
        return self.instruments / "logs" / f"{run}.csv"

    def rewrite(self, old: str, new: str) -> None:
        """Change the one place of labbook.toml that says `old`."""
        text = self.toml.read_text(encoding="utf-8")
        assert text.count(old) == 1
        self.toml.write_text(text.replace(old, new), encoding="utf-8")


def small_book(
    folder: Path, *, runs: bool = True, ingested: bool = True, two_people: bool = False, database_url: str | None = None
) -> SmallBook:
    """Make `folder/book` and `folder/instruments`.

    `runs`: the run sheet is imported and each day's rail checked; `ingested`: so are all logs and charger sheets;
    `two_people`: Ben Ode (BO) may speak beside Ada Nwosu (AN); `database_url`: on PostgreSQL.
    """
    name = f"small-book-{runs:d}{ingested:d}{two_people:d}"
    if database_url is not None:
        return on_server(
            name, lambda above: _make(above, runs, ingested, two_people, database_url), folder, database_url
        )
    return copy_of(name, lambda above: _make(above, runs, ingested, two_people, None), folder)


def reported_book(folder: Path, *selections: str | None) -> SmallBook:
    """Make the finished book with a report on all of its runs, or one on each of these selections."""

    def made(above: Path) -> SmallBook:
        book = small_book(above)
        with book.open() as opened_book:
            for where in selections or (None,):
                state_report(opened_book, where, ADA, lambda _step: None)
        return book

    return copy_of("-".join(["small-book-reported", *map(str, selections)]), made, folder)


def copy_of(name: str, make: Callable[[Path], SmallBook], folder: Path) -> SmallBook:
    """Copy the book that `make` makes in a folder, once a test run, with its instruments' files to another folder."""
    made = made_once(name, make)
    shutil.copytree(made.folder.parent, folder, dirs_exist_ok=True, copy_function=shutil.copyfile)
    return SmallBook(folder / "book", folder / "instruments")


def on_server(name: str, make: Callable[[Path], SmallBook], folder: Path, database_url: str) -> SmallBook:
    """Make a book on a PostgreSQL database, or copy to there the one that this process has made at the same address."""
    cluster, database = cluster_of(database_url)
    template = f"{database} {name}"

    def make_and_keep(above: Path) -> SmallBook:
        made = make(above)
        cluster.make(template, database)
        return made

    book = copy_of(f"{name}-on-{database}-{os.getpid()}", make_and_keep, folder)
    cluster.drop(database)
    cluster.make(database, template)
    return book


@functools.cache
def instrument_files() -> Mapping[str, bytes]:
    """What the instruments wrote, by path below `instruments`; the same bytes in every process."""
    made = small_runs()
    files = {"runs.csv": run_sheet(FACTORS, made)}
    for date in DAYS:
        files[f"charger/{date:%Y-%m-%d}.csv"] = charger_sheet(run for run in made if run.date == date)
    for run in made:
        if run.kind is RunKind.JUMPS:
            log = run_log(SEED, TRUTH, run)
            files[f"logs/{run.name}.csv"] = string_pot_log(log.time_ms, log.channels, DECIMALS)
    return files


@functools.cache
def small_runs() -> tuple[DemoRun, ...]:
    """The runs as they truly were: apexes about their truth, charges from joules and the passive drain."""
    rng = np.random.default_rng(SEED)
    made: list[DemoRun] = []
    for day, date in enumerate(DAYS):
        clock = dt.datetime.combine(date, dt.time(9, 30))
        slots = [(RunKind.JUMPS, Condition(foot, 400, gain), 12) for foot, gain in _ORDER]
        idle = [(RunKind.IDLE, None, minutes) for minutes in _IDLE_MINUTES[day]]
        for position, (kind, condition, minutes) in enumerate([*slots, *idle], start=1):
            made.append(_run(rng, len(made) + 1, clock, position, kind, condition, minutes))
            clock += dt.timedelta(minutes=minutes + 12)
    return tuple(made)


def short_log(number: int, rows: int = 60) -> bytes:
    """A piece of a log; pieces of other numbers hold other rows."""
    header, *lines = instrument_files()["logs/r001.csv"].split(b"\n")
    first = number % (len(lines) - rows - 2)
    return b"\n".join([header, *lines[first : first + rows], b""])


def small_toml(*, two_people: bool = False, database_url: str | None = None) -> str:
    """The `labbook.toml` of the small book: no scene, so that its reports need no simulator, and no `[analysis]`."""
    text = book_toml(TRUTH, predicted=False, decided=False).decode()
    if two_people:
        text = text.replace('"Ada Nwosu" = "AN"', '"Ada Nwosu" = "AN"\n"Ben Ode" = "BO"')
    if database_url is not None:
        text += f'\n[database]\nurl = "{database_url}"\n'
    return text


def write_instruments(folder: Path) -> Path:
    """Write the instruments' files below `folder/instruments`; returns that folder."""
    for name, content in instrument_files().items():
        path = folder / "instruments" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return folder / "instruments"


def import_sheet(book: Book, sheet: Path, person: str = ADA) -> None:
    """Import a run sheet and record that each of its days' rails were checked."""
    with book.session(person) as session:
        import_runs(book, session, SheetFile(sheet.name, sheet.read_bytes()))
        for date in DAYS:
            state_check(session, book.configuration, "rail_angle", 0.4, "deg", passed=True, day=date.isoformat())


def ingest_all(book: Book, instruments: Path, person: str = ADA) -> None:
    """Ingest everything that the instruments wrote."""
    for path in files_of([instruments / "charger", instruments / "logs"], book.folder).files:
        ingest_file(book, path, IngestRequest(person=person))


def _make(folder: Path, runs: bool, ingested: bool, two_people: bool, database_url: str | None) -> SmallBook:
    instruments = write_instruments(folder)
    made = SmallBook(folder / "book", instruments)
    made.folder.mkdir()
    made.toml.write_text(small_toml(two_people=two_people, database_url=database_url), encoding="utf-8")
    make_book(made.folder, ADA)
    with made.open() as book:
        if runs:
            import_sheet(book, instruments / "runs.csv")
        if ingested:
            ingest_all(book, instruments)
    return made


def _run(
    rng: np.random.Generator,
    number: int,
    started: dt.datetime,
    position: int,
    kind: RunKind,
    condition: Condition | None,
    minutes: int,
) -> DemoRun:
    jumps = JUMPS if condition else 0
    charge_mah = TRUTH.drain.charge_mah(60 * minutes) + rng.normal(0, 1.5)
    apexes_m = np.zeros(jumps)
    if condition:
        charge_mah += jumps * TRUTH.jump_charge_mah(TRUTH.joules_per_jump(condition))
        apexes_m = TRUTH.apex_height_m(condition) + rng.normal(0, 0.003, jumps)
    return DemoRun(
        name=f"r{number:03d}",
        position=position,
        kind=kind,
        levels={} if condition is None else asdict(condition),
        condition=condition,
        battery="ABC"[(position - 1) % 3],
        started=started,
        duration_s=60 * minutes,
        jumps_made=jumps,
        note="rail within 1 degree" if position == 1 else "",
        charge_mah=round(charge_mah),
        recharge_minutes=10,
        recharge_ended=started + dt.timedelta(minutes=minutes + 11),
        apex_heights_m=apexes_m,
        misfired=np.zeros(jumps, dtype=np.bool_),
    )
