"""Hand-kept sheet of recharges as CSV: one row a recharge, in the charger's own units."""

from __future__ import annotations

import csv
import datetime as dt
import io
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SheetRow:
    """One recharge as typed from the charger's display; `ended` is local time."""

    run: str
    charge_mah: int
    minutes: int
    end_voltage_v: float
    pack: str
    ended: dt.datetime


def charger_sheet(rows: Iterable[SheetRow]) -> bytes:
    """Return the sheet, one row a recharge, in the order given."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["run", "mAh", "minutes", "end_voltage", "pack", "ended"])
    for row in rows:
        writer.writerow(
            [
                row.run,
                row.charge_mah,
                row.minutes,
                f"{row.end_voltage_v:.2f}",
                row.pack,
                f"{row.ended:%Y-%m-%d %H:%M}",
            ]
        )
    return stream.getvalue().encode()
