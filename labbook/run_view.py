"""Everything the book knows of one run."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.charges import ChargeOfRun, charges_by_run
from data_schema.queries.history import HistoryRow, NoteRow, RunFileRow, files_of_run, history_of, notes_of
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import GapRow, SignalRow, gaps_of, signals_of_runs
from labbook.naming import run_named


@dataclass(frozen=True, slots=True)
class RunView:
    """A run with all that belongs to it."""

    run: RunRow
    files: tuple[RunFileRow, ...]
    signals: tuple[tuple[SignalRow, tuple[GapRow, ...]], ...]
    charges: tuple[ChargeOfRun, ...]
    notes: tuple[NoteRow, ...]
    history: tuple[HistoryRow, ...]


def run_view(connection: sa.Connection, name: str) -> RunView:
    """Collect what belongs to a run."""
    run = run_named(connection, name)
    signals = [signal for signal in signals_of_runs(connection) if signal.run_uid == run.uid]
    return RunView(
        run=run,
        files=tuple(files_of_run(connection, run.uid)),
        signals=tuple((signal, gaps_of(connection, signal.uid)) for signal in signals),
        charges=tuple(charges_by_run(connection).get(run.uid, [])),
        notes=tuple(notes_of(connection, run.uid)),
        history=tuple(history_of(connection, run.uid)),
    )


def view_lines(view: RunView) -> list[str]:
    """Write it for people."""
    run = view.run
    lines = [
        f"run {run.name} ({run.kind}, {run.state}) on {run.day}, position {run.position_in_day}",
        f"  condition: {run.condition_key or 'none'}{' (control)' if run.is_control else ''}",
        f"  robot {run.robot}, battery {run.battery}, {run.starts} start{'' if run.starts == 1 else 's'}, "
        f"{run.jumps_made} jumps made",
        f"  started {run.started_utc or 'unknown'}, duration "
        f"{'unknown' if run.duration_s is None else f'{run.duration_s:g} s'}",
    ]
    lines += [
        f"  file {item.name} ({item.role}, {item.n_bytes} bytes, sha256 {item.sha256[:12]})" for item in view.files
    ]
    for signal, gaps in view.signals:
        rate = "unknown rate" if signal.rate_hz is None else f"{signal.rate_hz:.1f} Hz"
        lines.append(f"  signal {signal.uid}: {signal.n_samples} samples, {rate}: {', '.join(signal.channels)}")
        lines += [
            f"    gap ({gap.kind}) at {gap.start_s:.3f} s, {gap.length_s * 1e3:.0f} ms, {gap.samples_missing} of "
            f"{gap.samples_expected} samples missing"
            for gap in gaps
        ]
    lines += [
        f"  charge {charge.uid}: {charge.charge_mah:g} mAh (steps of {charge.resolution_mah:g})"
        f"{'' if charge.stated_pack is None else f', pack {charge.stated_pack}'}"
        for charge in view.charges
    ]
    lines += [f"  note by {note.person} on {note.at_utc}: {note.text}" for note in view.notes]
    lines += [_statement(item) for item in view.history]
    return lines


def _statement(item: HistoryRow) -> str:
    before = "" if item.old_json is None else f", before {item.old_json}"
    reason = f" ({item.reason})" if item.reason else ""
    return f"  {item.at_utc} {item.person}: {item.action} {item.new_json or ''}{before}{reason}"
