"""The samples of a run's log as an `xarray.Dataset`, with units, and NaN where samples are missing."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import GapRow, SignalRow, channels_of, gaps_of, signals_of_runs
from data_schema.vocabulary import FileRole
from ingest.store import Store

if TYPE_CHECKING:
    import xarray as xr

    from ingest.model import FloatArray

CONVENTIONS = "CF-1.11"


def signals_named(
    connection: sa.Connection, run: RunRow, role: FileRole | None = None, file: str | None = None
) -> list[SignalRow]:
    """Return the signals in use of a run, all or those of a role or a file; raises `UsageError` where there is none."""
    every = signals_of_runs(connection, run_uids=[run.uid])
    found = [one for one in every if role in (None, one.role) and file in (None, one.file_name)]
    if not found:
        named = ", ".join(f"{one.role} {one.file_name}" for one in every) or "nothing"
        asked = " ".join(filter(None, ("no", role, file or "signal")))
        raise UsageError(f"run {run.name} has {asked} in use: it has {named} (`labbook show {run.name}`).")
    return found


def dataset(connection: sa.Connection, store: Store, run: RunRow, signal: SignalRow) -> xr.Dataset:
    """Return the samples of a signal of a run by the time in s from its first one, shape (n_samples,), in SI.

    Within gaps every channel is NaN; where a gap has no sample left, one stands at its middle. The attributes follow
    the CF conventions; `start_utc` is the instant of the first sample, "" where the file does not say.
    """
    import xarray as xr

    channels, gaps = channels_of(connection, signal.uid), gaps_of(connection, signal.uid)
    samples = store.samples(signal.store_path, [one.name for one in channels])
    time_s = samples.pop("time")
    inside, middles_s = _missing(time_s, gaps)
    places = np.searchsorted(time_s, middles_s)
    data = {}
    for one in channels:
        values = np.where(inside, np.nan, samples[one.name])
        about = {"long_name": one.name.replace("_", " "), "source_column": one.source_name}
        about |= {"comment": "nothing says its unit"} if one.unit is None else {"units": one.unit}
        data[one.name] = ("time", np.insert(values, places, np.nan), about)
    time_about = {"units": "s", "long_name": "time from the first sample", "axis": "T"}
    return xr.Dataset(
        data,
        coords={"time": ("time", np.insert(time_s, places, middles_s), time_about)},
        attrs={
            "Conventions": CONVENTIONS,
            "title": f"run {run.name}, {signal.role} {signal.file_name}",
            "run": run.name,
            "day": run.day,
            "condition": run.condition_key,
            "robot": run.robot,
            "start_utc": signal.start_utc or "",
            "rate_hz": np.nan if signal.rate_hz is None else signal.rate_hz,
            "file": signal.file_name,
            "file_sha256": signal.file_sha256,
            "gaps": json.dumps([[gap.start_s, gap.length_s, str(gap.kind)] for gap in gaps]),
        },
    )


def _missing(time_s: FloatArray, gaps: Sequence[GapRow]) -> tuple[np.ndarray, FloatArray]:
    """Return which samples lie strictly within a gap, and the middles in s of the gaps that have none."""
    inside, middles_s = np.zeros(time_s.shape, dtype=bool), []
    for gap in gaps:
        first = int(np.searchsorted(time_s, gap.start_s, side="right"))
        last = int(np.searchsorted(time_s, gap.start_s + gap.length_s, side="left"))
        inside[first:last] = True
        if last <= first:
            middles_s.append(gap.start_s + gap.length_s / 2.0)
    return inside, np.array(middles_s, dtype=float)
