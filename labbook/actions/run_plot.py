"""A run's log as `labbook plot` draws it."""

from __future__ import annotations

from pathlib import Path

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.queries.signals import gaps_of
from labbook.actions.jump_review import review
from labbook.analysis.detections import Detections
from labbook.analysis.judging import JudgedJump, anchor_of
from labbook.book.opening import Book
from reports.figures.log import draw_log
from reports.run_log import LogGap, LogJump, RunLog

KINDS = (".png", ".svg", ".pdf")


def plot_run(book: Book, connection: sa.Connection, name: str, jump: int | None, out: Path) -> Path:
    """Draw a run's log to a file; the file's ending says in which form."""
    if out.suffix not in KINDS:
        raise UsageError(f"--out {out} does not say which form: end it in {', '.join(KINDS)}.")
    found = review(book, connection, name)
    numbers = {item.jump.number for item in found.jumps}
    if jump is not None and jump not in numbers:
        raise UsageError(f"run {name} has no jump {jump}: it has {len(numbers)}.")
    log = Detections(connection, book.store).log(found.signal)
    picture = RunLog(
        run=name,
        title=found.run.condition_key or str(found.run.kind),
        time_s=log.time_s,
        body_height_m=log.body_height_m,
        jumps=tuple(_jump(item) for item in found.jumps if item.jump.apex_height_m is not None),
        gaps=tuple(
            LogGap(gap.start_s, gap.start_s + gap.length_s, str(gap.kind))
            for gap in gaps_of(connection, found.signal.uid)
        ),
        panel_jump=jump,
    )
    draw_log(picture).savefig(out)
    return out


def _jump(item: JudgedJump) -> LogJump:
    jump = item.jump
    return LogJump(
        number=jump.number,
        apex_s=anchor_of(jump),
        apex_height_m=jump.apex_height_m or 0.0,
        touchdown_s=jump.touchdown_s,
        lift_off_s=jump.liftoff_s,
        rejected=item.excluded or "",
    )
