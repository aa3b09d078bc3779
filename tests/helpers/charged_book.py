"""A book of charges alone, whose runs cost the joules that a test gives them."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from data_schema.vocabulary import RunKind
from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.making import make_book
from labbook.demo.files import FACTORS, book_toml
from labbook.demo.writers import SheetRun, charger_sheet, run_sheet
from tests.helpers.books import ADA, TRUTH, SmallBook

_FIRST_DAY = dt.datetime.combine(dt.date(2021, 6, 14), dt.time(9, 30))
_MINUTES, _JUMPS = 12, 25


@dataclass(frozen=True, slots=True)
class Made:
    """A run of jumps on a day, counted from 0; `joules` a jump, None where its charge was not written down."""

    day: int
    foot: str
    gain: int
    joules: float | None


def charged_book(
    folder: Path, runs: Sequence[Made], analysis: str = "", exchanged: Mapping[str, str] | None = None
) -> SmallBook:
    """Make a book of these runs, r001 first, and of six idle runs on the first day.

    `exchanged` names the run in whose row of the sheet another's charge was written.
    """
    truth = replace(TRUTH, ad_gains=tuple(sorted({run.gain for run in runs} - {0})))
    rows: list[SheetRun] = []
    charges: dict[str, float] = {}

    def add(day: int, kind: RunKind, levels: dict[str, object], minutes: int, active_mah: float | None) -> None:
        started = _FIRST_DAY + dt.timedelta(days=day, minutes=15 * len(rows) % 720)
        run = SheetRun(
            name=f"r{len(rows) + 1:03d}",
            started=started,
            position=sum(row.date == started.date() for row in rows) + 1,
            kind=kind,
            levels=levels,
            duration_s=60 * minutes,
            jumps_made=_JUMPS if levels else 0,
            recharge_minutes=10,
            recharge_ended=started + dt.timedelta(minutes=70),
        )
        rows.append(run)
        if active_mah is not None:
            charges[run.name] = truth.drain.charge_mah(60 * minutes) + active_mah

    for run in runs:
        levels: dict[str, object] = {"foot": run.foot, "k_gain": 400, "b_ad_gain": run.gain}
        active = None if run.joules is None else _JUMPS * truth.jump_charge_mah(run.joules)
        add(run.day, RunKind.JUMPS, levels, _MINUTES, active)
    for minutes in (20, 24, 30, 40, 50, 60):
        add(0, RunKind.IDLE, {}, minutes, 0.0)
    taken = {name: round(charges[(exchanged or {}).get(name, name)]) for name in charges}
    made = SmallBook(folder / "book", folder / "instruments")
    made.folder.mkdir(parents=True)
    made.instruments.mkdir()
    made.toml.write_text(book_toml(truth, predicted=False, decided=False).decode() + analysis, encoding="utf-8")
    make_book(made.folder, ADA)
    sheet = [replace(row, charge_mah=taken[row.name]) for row in rows if row.name in taken]
    (made.instruments / "charges.csv").write_bytes(charger_sheet(sheet))
    with made.open() as book:
        with book.session(ADA) as session:
            import_runs(book, session, SheetFile("runs.csv", run_sheet(FACTORS, rows)))
        ingest_file(book, made.instruments / "charges.csv", IngestRequest(person=ADA))
    return made
