"""A run's log as `labbook plot` draws it; the logs of a run that was started again stand one after the other."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np
import sqlalchemy as sa
from matplotlib.figure import Figure
from numpy.typing import NDArray

from data_schema.queries.signals import SignalRow, gaps_of
from labbook.actions.runs.jump_review import RunReview, review
from labbook.analysis.outcomes.detection import Detections, Log, detect, detection_row, rest_length_m
from labbook.analysis.outcomes.run_apexes import JudgedJump, anchor_of
from labbook.book.opening import Book
from reports.display import LogGap, LogJump, RunLog, count_text
from reports.figures.kind import FORMS, check_form, svg_bytes, write_figure
from reports.figures.log import draw_log, draw_logs_overlaid
from reports.page.writing import figure_page

PICTURES = (*FORMS, ".html")
"""Endings of the files that logs are drawn to."""

_NOT_IN_NAMES = re.compile(r'[\x00-\x1f\x7f/\\:*?"<>|]')
"""What no file's name may hold on some system."""
_LONGEST_BYTES = 200
"""Of a file's name without its ending; most systems allow 255 bytes with it."""

_BREAK_SHARE = 0.04
"""Width of the break drawn between two logs without a clock, of what was logged before."""


@dataclass(frozen=True, slots=True)
class PlottedRun:
    """Where a run's picture is, and that the jump asked for has no apex, "" where it has one."""

    path: Path
    remark: str


def picture_named(run: str) -> Path:
    """Return the name of a run's picture where none was given: the run's, as far as a file can be called so."""
    name = _NOT_IN_NAMES.sub("_", run).encode(errors="ignore")[:_LONGEST_BYTES].decode(errors="ignore")
    return Path(f"{name}.png")


def plot_run(book: Book, connection: sa.Connection, name: str, jump: int | None, out: Path) -> PlottedRun:
    """Draw a run's logs to a file in the form of its ending; `jump` is the one that is shown enlarged."""
    check_form("--out", out, PICTURES)
    picture, remark = drawn_log(book, connection, review(book, connection, name), jump)
    left = sum(1 for one in picture.jumps if one.excluded)
    shows = f"Body height over time, with {count_text(len(picture.jumps), 'jump')}, {left} of them left out"
    write_picture(draw_log(picture), out, f"Run {name}: {picture.title}", shows)
    return PlottedRun(out, remark)


def write_picture(figure: Figure, out: Path, title: str, shows: str) -> None:
    """Write a figure to a file in the form of its ending; a page says its title, and what it shows."""
    if out.suffix.lower() == ".html":
        out.write_text(figure_page(svg_bytes(figure), title, f"{title}. {shows}."), encoding="utf-8")
    else:
        write_figure(figure, out)


def drawn_log(book: Book, connection: sa.Connection, found: RunReview, jump: int | None) -> tuple[RunLog, str]:
    """Return what is drawn of a run's logs, and that the jump asked for has no apex, "" where it has one.

    A log begins as long after the one before as their instants say; where one has none, the axis is broken.
    Raises `UsageError` for a jump that the run does not have.
    """
    name = found.run.name
    asked = None if jump is None else found.jump(jump).jump
    detections = Detections(connection, book.store)
    pieces: list[_Piece] = []
    logs: dict[str, Log] = {}
    restarts: list[LogGap] = []
    for signal in found.signals:
        log = logs[signal.sha256] = detections.log(signal)
        restarts += [_restart(pieces[-1], signal)] if pieces else []
        offset_s = restarts[-1].end_s - float(log.time_s[0]) if restarts else 0.0
        pieces.append(_Piece(signal, log.time_s + offset_s, log.body_height_m, log.leg_length_m, offset_s))
    misfires = _misfires(book, connection, found, logs)
    offsets = {piece.signal.sha256: piece.offset_s for piece in pieces}
    gaps = [
        LogGap(gap.start_s + piece.offset_s, gap.start_s + gap.length_s + piece.offset_s, str(gap.kind))
        for piece in pieces
        for gap in gaps_of(connection, piece.signal.uid)
    ]
    picture = RunLog(
        run=name,
        title=f"{found.run.condition_key or found.run.kind}, {found.run.day}",
        time_s=np.concatenate([piece.time_s for piece in pieces]),
        body_height_m=np.concatenate([piece.body_height_m for piece in pieces]),
        jumps=tuple(_jump(item, offsets[item.signal_sha256], misfires) for item in found.jumps),
        gaps=tuple(sorted([*restarts, *gaps], key=lambda gap: gap.start_s)),
        panel_jump=jump,
        leg_length_m=_leg_length(pieces),
    )
    if asked is None or asked.undefined_reason is None:
        return picture, ""
    kind = "was a misfire" if asked.uid in misfires else "has no apex"
    return picture, f"jump {jump} of run {name} {kind}: {asked.undefined_reason}."


def _misfires(book: Book, connection: sa.Connection, found: RunReview, logs: Mapping[str, Log]) -> set[str]:
    """Return the uids of jumps that are misfires, found again: stored jumps have their reasons in words only."""
    lost = {item.signal_sha256 for item in found.jumps if item.jump.apex_height_m is None}
    length_m, detector = rest_length_m(connection, found.run.robot_uid), book.configuration.protocol.detector
    uids = set()
    for sha256 in lost:
        detection = detect(logs[sha256], detector, length_m)
        for row, jump in zip(detection_row(detection, sha256).jumps, detection.found.jumps, strict=True):
            if jump.misfired:
                uids.add(row.uid)
    return uids


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """One log of a run on the run's time: what was logged between two starts."""

    signal: SignalRow
    time_s: NDArray[np.float64]
    body_height_m: NDArray[np.float64]
    leg_length_m: NDArray[np.float64] | None
    offset_s: float


def _leg_length(pieces: list[_Piece]) -> NDArray[np.float64] | None:
    """Join the logs' leg lengths, NaN where one has none; None where none has any."""
    if all(piece.leg_length_m is None for piece in pieces):
        return None
    lengths = (
        np.full(piece.time_s.size, np.nan) if piece.leg_length_m is None else piece.leg_length_m for piece in pieces
    )
    return np.concatenate(list(lengths))


def _restart(last: _Piece, signal: SignalRow) -> LogGap:
    """Return the gap from the end of a log to the next one's first sample: by the instants of both, or a break."""
    end_s = float(last.time_s[-1])
    if last.signal.start_utc is not None and signal.start_utc is not None:
        passed = datetime.fromisoformat(signal.start_utc) - datetime.fromisoformat(last.signal.start_utc)
        start_s = float(last.time_s[0]) + passed.total_seconds()
        if start_s > end_s:
            return LogGap(end_s, start_s, "restart")
    return LogGap(end_s, end_s + max(_BREAK_SHARE * end_s, 1.0), "restart, of unknown length", length_known=False)


def _jump(item: JudgedJump, offset_s: float, misfires: set[str]) -> LogJump:
    jump = item.jump
    return LogJump(
        number=jump.number,
        at_s=anchor_of(jump) + offset_s,
        apex_height_m=jump.apex_height_m,
        touchdown_s=None if jump.touchdown_s is None else jump.touchdown_s + offset_s,
        lift_off_s=None if jump.liftoff_s is None else jump.liftoff_s + offset_s,
        excluded=item.excluded or "",
        misfire=jump.uid in misfires and jump.apex_height_m is None,
    )


def plot_runs(book: Book, connection: sa.Connection, names: tuple[str, str], out: Path) -> None:
    """Draw the body heights of two runs over each other, to a file in the form of its ending."""
    first, second = (drawn_log(book, connection, review(book, connection, name), None)[0] for name in names)
    figure = draw_logs_overlaid(first, second)
    shows = f"Body heights over time, of {first.title}, and of {second.title}"
    write_picture(figure, out, f"Runs {first.run} and {second.run}", shows)
