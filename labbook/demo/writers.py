"""Files in the instruments' own formats, each writer of which returns bytes, and what is written of a campaign.

What they write is synthetic. None of the formats but `labbook.toml` and the run sheet has a place to say so, so
the names of the files do.
"""

from __future__ import annotations

import csv
import datetime as dt
import functools
import io
import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from data_schema.vocabulary import RunKind

Column = tuple[NDArray[np.float64] | NDArray[np.int64], int]
"""Values of one column, shape (n,), and its decimals; integers are written without a point."""


def delimited_text(header: str, columns: Sequence[Column], *, line_end: str = "\n") -> bytes:
    """Return `header` and the rows as ASCII; values must be finite and below 1e12."""
    import pyarrow as pa
    import pyarrow.csv

    table = pa.table({str(number): _column(values, decimals) for number, (values, decimals) in enumerate(columns)})
    stream = io.BytesIO()
    stream.write(header.encode("ascii") + b"\n")
    options = pa.csv.WriteOptions(include_header=False, quoting_style="none")
    pa.csv.write_csv(table, stream, options)
    text = stream.getvalue()
    return text if line_end == "\n" else text.replace(b"\n", line_end.encode("ascii"))


def _column(values: NDArray[np.float64] | NDArray[np.int64], decimals: int) -> object:
    import pyarrow as pa

    if np.issubdtype(values.dtype, np.integer):
        return pa.array(values)
    # A decimal is printed with all its places and never in scientific notation, unlike a double.
    decimal = pa.decimal128(12 + decimals, decimals)
    if values.size and values[0] == values[-1] and np.all(values == values[0]):
        return pa.repeat(pa.scalar(float(values[0])).cast(decimal), values.size)
    return pa.array(values).cast(decimal)


DEFAULT_DECIMALS = 6


def string_pot_log(
    time_ms: NDArray[np.int64],
    channels: Mapping[str, NDArray[np.float64]],
    decimals: Mapping[str, int] = MappingProxyType({}),
) -> bytes:
    """Return the log; `time_ms` and every channel have shape (n,), a channel's key is its header cell.

    The unit stands in the key where there is one, as in `body_height [m]`; `decimals` names the channels that are
    not written with six. Time is whole milliseconds since boot.
    """
    header = ",".join(["time [ms]", *channels])
    columns = [(values, decimals.get(name, DEFAULT_DECIMALS)) for name, values in channels.items()]
    return delimited_text(header, [(time_ms, 0), *columns])


FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PlateRecord:
    """Force-plate samples: `time_ms` (n,), force and moment (n, 3), centre of pressure (n, 2); z down."""

    time_ms: FloatArray
    force_n: FloatArray
    moment_nm: FloatArray
    cop_m: FloatArray


COLUMNS = ("Seq", "Timestamp", "Sync", "Aux", "Fx", "Fy", "Fz", "Mx", "My", "Mz", "COPx", "COPy")


def bertec_text(plate: PlateRecord) -> bytes:
    """Return the export."""
    n = plate.time_ms.size
    zeros = np.zeros(n, dtype=np.int64)
    return delimited_text(
        ",".join(COLUMNS),
        [
            (np.arange(n, dtype=np.int64), 0),
            (plate.time_ms, 5),
            (zeros, 0),
            (zeros, 0),
            *((plate.force_n[:, axis], 4) for axis in range(3)),
            *((plate.moment_nm[:, axis], 5) for axis in range(3)),
            *((plate.cop_m[:, axis], 6) for axis in range(2)),
        ],
        line_end="\r\n",
    )


CHARGING = 1
"""Mode number of a charge."""
CELLS = 10
"""Cell columns of the DUO."""
_DATA_PACKET = 1


@dataclass(frozen=True, slots=True, eq=False)
class Recharge:
    """One recharge sampled in time: arrays of shape (n,), cells of shape (n, cells); charge counts up from 0."""

    time_s: FloatArray
    current_a: FloatArray
    input_v: FloatArray
    pack_v: FloatArray
    charge_mah: FloatArray
    internal_c: FloatArray
    external_c: FloatArray
    cell_v: FloatArray


def icharger_log(recharge: Recharge) -> bytes:
    """Return the log of channel 1 of the charger, LF line ends."""
    cells = np.zeros((recharge.time_s.size, CELLS))
    cells[:, : recharge.cell_v.shape[1]] = recharge.cell_v
    columns = np.column_stack(
        [
            recharge.time_s * 1000,
            np.full(recharge.time_s.size, _DATA_PACKET),
            np.zeros(recharge.time_s.size),
            recharge.current_a * 100,
            recharge.input_v * 1000,
            recharge.pack_v * 1000,
            recharge.charge_mah,
            recharge.internal_c * 10,
            recharge.external_c * 10,
            cells * 1000,
        ]
    )
    counts = np.rint(columns).astype(np.int64)
    lines = [f"$1;{CHARGING};{';'.join(map(str, row))};".encode() for row in counts.tolist()]
    return b"".join(line + b"%d\n" % checksum(line) for line in lines)


def checksum(line: bytes) -> int:
    """Exclusive or of all bytes of a line, `$` to the last `;`, both included."""
    return functools.reduce(operator.xor, line, 0)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SheetRun:
    """One run as people write it down, on the run sheet and from the charger's display; times are local.

    `levels` maps factor names to levels and is empty for an idle run.
    """

    name: str
    started: dt.datetime
    position: int
    kind: RunKind
    levels: Mapping[str, Any]
    battery: str = "A"
    robot: str = "hopper"
    duration_s: int
    jumps_made: int
    starts: int = 1
    note: str = ""
    charge_mah: int = 0
    recharge_minutes: int = 25
    recharge_ended: dt.datetime
    end_voltage_v: float = 16.8

    @property
    def date(self) -> dt.date:
        """The day on which it was made."""
        return self.started.date()


def charger_sheet(runs: Iterable[SheetRun]) -> bytes:
    """Return the sheet of recharges, one row a run, in the order given."""
    return _sheet(
        ["run", "mAh", "minutes", "end_voltage", "pack", "ended"],
        (
            [
                run.name,
                run.charge_mah,
                run.recharge_minutes,
                f"{run.end_voltage_v:.2f}",
                run.battery,
                f"{run.recharge_ended:%Y-%m-%d %H:%M}",
            ]
            for run in runs
        ),
    )


def run_sheet(factors: Sequence[str], runs: Iterable[SheetRun]) -> bytes:
    """Return the sheet of runs with a column for each of `factors`, in the order given."""
    before, after = ["run", "date", "position", "kind"], ["battery", "robot", "started", "duration_s"]
    return _sheet(
        [*before, *factors, *after, "jumps_made", "starts", "note"],
        (
            [
                run.name,
                run.date,
                run.position,
                run.kind.value,
                *(run.levels.get(factor, "") for factor in factors),
                run.battery,
                run.robot,
                f"{run.started:%H:%M}",
                run.duration_s,
                run.jumps_made,
                run.starts,
                run.note,
            ]
            for run in runs
        ),
    )


def _sheet(head: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows([head, *rows])
    return stream.getvalue().encode()


MARK = "synthetic"
"""Part of the name of every instrument's file."""
PlannedRun: TypeAlias = tuple[str, int, str, Mapping[str, str] | None]
"""Name, number of the day, block, and levels, which an idle run lacks."""


@dataclass(frozen=True, slots=True)
class Record:
    """What an instrument wrote, its path below `instruments`, and what is true of it, if that is told."""

    path: str
    content: bytes
    truth: Mapping[str, Any] | None = None


@dataclass(frozen=True, slots=True)
class Correction:
    """A fact that was written down wrong and put right later."""

    run: str
    field: str
    written: str
    right: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignFiles:
    """What is written of a campaign: its configuration, its sheets and records, and what is true.

    `records` are made one after the other. `runs`, if there are any, are made with `factors`, as `planned` from a seed
    where they were; `corrections` are stated after all is ingested.
    """

    configuration: str
    records: Iterable[Record]
    truth: Mapping[str, Any]
    runs: Sequence[SheetRun] = ()
    factors: tuple[str, ...] = ()
    planned: tuple[int, Sequence[PlannedRun]] | None = None
    corrections: Sequence[Correction] = ()
