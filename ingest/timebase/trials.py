"""Several trials in one file, told apart by the value of a column: each is a recording of its own."""

from __future__ import annotations

import numpy as np

from ingest.channels.declared import positions_of
from ingest.findings import FILE, FindingCollector
from ingest.model import BoolArray
from ingest.tables.header_cells import clean_name
from ingest.tables.table import Block, Table

MOST_TRIALS = 500


def trial_position(column: str | None, table: Table, findings: FindingCollector) -> int | None:
    """Return where the column stands that tells trials apart; a column that is not there refuses the file."""
    if column is None:
        return None
    positions = positions_of(column, table.names)
    if positions:
        return positions[0]
    listed = ", ".join(map(repr, table.names[:12]))
    message = f"The trials are told apart by column {column!r}, which the file does not have: it has {listed}."
    findings.add(FILE, "trial_column_absent", message, column=column)
    return None


def trials(block: Block, position: int | None, findings: FindingCollector) -> list[tuple[str | None, BoolArray]]:
    """Return the name of each trial and its rows, shape (n_rows,), in order of their first row; one where none are told
    apart.
    """
    if position is None:
        return [(None, np.ones(block.n_rows, dtype=np.bool_))]
    if position in block.clocks:
        values = np.array([cell.decode("utf-8", errors="replace").strip() for cell in block.clocks[position]])
    else:
        values = np.array([f"{value:.15g}" for value in np.asarray(block.numbers[position]).tolist()])
    found, first, which = np.unique(values, return_index=True, return_inverse=True)
    if len(found) > MOST_TRIALS:
        message = f"The column has {len(found)} values, more than the {MOST_TRIALS} trials allowed: name another one."
        findings.add(FILE, "too_many_trials", message)
        return []
    names: list[str] = []
    for value in found.tolist():
        name = clean_name(value) or "without_name"
        names.append(name if name not in names else f"{name}_{len(names)}")
    return [(names[trial], which == trial) for trial in np.argsort(first).tolist()]
