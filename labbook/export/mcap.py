"""A run as an MCAP file, which PlotJuggler and Lichtblick open: a topic a signal, and one with the marks of its jumps.

Messages are JSON objects, whose JSON schema has the unit of each channel in its description.
"""

from __future__ import annotations

import datetime
import itertools
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from data_schema.columns import Column, ValueKind
from data_schema.disk import partial_path, path_in_errors, put_in_place
from data_schema.errors import UsageError
from data_schema.libraries import optional
from labbook.book.naming import run_named
from labbook.export.signals import dataset, signals_named
from labbook.export.tables import ExportTable, Selection, jumps
from labbook.export.writing import EXTRA

if TYPE_CHECKING:
    import xarray as xr
    from mcap.writer import Writer

MARKS = "/jumps"
_MARKED_AT = ("apex_s", "lift_off_s", "touchdown_s")
"""At which of a jump's instants its mark stands: the first that it has."""
_TYPES = {ValueKind.NUMBER: "number", ValueKind.COUNT: "integer", ValueKind.FLAG: "boolean"}


def write_mcap(selection: Selection, name: str, path: Path) -> int:
    """Write all signals of the run of this name, which is the selection, and its jumps; returns how many messages.

    Times are those of the first sample's instant; where the file does not say it, from 1970 on. A message leaves out
    what is not a number. Raises `UsageError` where the file is there, and for a run without signals.
    """
    writer_of = optional("mcap.writer", "--mcap", EXTRA)
    if path.exists():
        raise UsageError(f"{str(path)!r} is there already: name a new file.")
    run = run_named(selection.connection, name)
    found = signals_named(selection.connection, run)
    part, count = partial_path(path), 0
    with path_in_errors(path):
        try:
            with part.open("wb") as stream:
                writer: Writer = writer_of.Writer(stream)
                writer.start(profile="", library="labbook")
                names = itertools.count(2)
                topics: set[str] = set()
                for signal in found:
                    selection.step(f"samples of {signal.file_name}")
                    topic = f"/{signal.role}" if f"/{signal.role}" not in topics else f"/{signal.role}_{next(names)}"
                    topics.add(topic)
                    samples = dataset(selection.connection, selection.store, run, signal)
                    channels = {
                        str(name): Column(values.attrs["long_name"], ValueKind.NUMBER, values.attrs.get("units", ""))
                        for name, values in samples.data_vars.items()
                    }
                    count += _write(writer, topic, channels, _messages(samples), signal.start_utc)
                marks = jumps(selection)
                count += _write(writer, MARKS, marks.columns, _marks(marks), found[0].start_utc)
                writer.add_metadata("labbook", {"run": run.name, "day": run.day, "condition": run.condition_key})
                writer.finish()  # type: ignore[no-untyped-call]
            put_in_place(path)
        finally:
            part.unlink(missing_ok=True)
    return count


def _messages(samples: xr.Dataset) -> Iterator[tuple[float, dict[str, Any]]]:
    """Give the time in s of each sample and its channels."""
    names = [str(name) for name in samples.data_vars]
    columns = [samples[name].to_numpy().tolist() for name in names]
    for time_s, *values in zip(samples["time"].to_numpy().tolist(), *columns, strict=True):
        yield time_s, dict(zip(names, values, strict=True))


def _marks(table: ExportTable) -> Iterator[tuple[float, dict[str, Any]]]:
    """Give the time in s of each jump's mark, and its row."""
    for row in table.rows:
        mark = dict(zip(table.columns, row, strict=True))
        time_s = next((mark[name] for name in _MARKED_AT if mark[name] is not None), None)
        if time_s is not None:
            yield time_s, mark


def _write(
    writer: Writer,
    topic: str,
    columns: Mapping[str, Column],
    messages: Iterator[tuple[float, dict[str, Any]]],
    start_utc: str | None,
) -> int:
    """Write messages of a topic, at times in s from an instant; returns how many."""
    start_ns = 0
    if start_utc is not None:
        since = datetime.datetime.fromisoformat(start_utc) - datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)
        start_ns = (since // datetime.timedelta(microseconds=1)) * 1000
    properties = {
        name: {"type": _TYPES.get(column.kind, "string"), "description": column.text}
        for name, column in columns.items()
    }
    schema = json.dumps({"type": "object", "properties": properties}).encode()
    schema_id = writer.register_schema(name=topic.strip("/"), encoding="jsonschema", data=schema)
    channel_id = writer.register_channel(topic=topic, message_encoding="json", schema_id=schema_id)
    count = 0
    for time_s, message in messages:
        count += 1
        at_ns = start_ns + round(time_s * 1e9)
        there = {name: value for name, value in message.items() if value is not None and value == value}
        data = json.dumps(there).encode()
        writer.add_message(channel_id=channel_id, log_time=at_ns, publish_time=at_ns, data=data)
    return count
