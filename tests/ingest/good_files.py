"""A small good file of every format, synthetic: what truncation and fuzzing start from.

A format joins with a line in `GOOD_FILES`: its name, and a function that returns the bytes. Keep them near 1 kB.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from tests.ingest.synthetic import LOG_HEADER, SHEET, bertec_acquire, icharger_rows, robot_rows, text

GOOD_FILES: Mapping[str, Callable[[], bytes]] = {
    "delimited_log": lambda: text(LOG_HEADER, robot_rows(24)),
    "bertec_text": lambda: bertec_acquire(n=12),
    "charger_sheet": SHEET.encode,
    "icharger_log": lambda: ("\n".join(icharger_rows(14)) + "\n").encode(),
}
