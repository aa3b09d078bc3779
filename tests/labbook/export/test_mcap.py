"""An MCAP of a run has its samples and jumps at their instants, with the units of channels in the schema."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

import labbook as package
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import small_book


def test_a_run_comes_back(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    path = tmp_path / "r001.mcap"
    good(labbook("export", path, "--mcap", "r001", at=small.folder))
    with package.open(small.folder) as book:
        samples, jumps = book.signal("r001"), book.jumps("run=r001")
    times: dict[str, list[float]] = {}
    messages: dict[str, list[dict[str, object]]] = {}
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert channel.message_encoding == "json"
            assert schema is not None
            if channel.topic == "/log":
                described = json.loads(schema.data)["properties"]["body_height"]
                assert described == {"type": "number", "description": "body height, m"}
            times.setdefault(channel.topic, []).append(message.log_time / 1e9)
            messages.setdefault(channel.topic, []).append(json.loads(message.data))
    assert times.keys() == {"/log", "/jumps"}
    np.testing.assert_allclose(times["/log"], samples["time"], atol=1e-9)
    heights = [one.get("body_height", np.nan) for one in messages["/log"]]
    np.testing.assert_array_equal(heights, samples["body_height"])
    assert [one["jump"] for one in messages["/jumps"]] == list(jumps.loc["r001"].index)
    np.testing.assert_allclose(times["/jumps"], jumps["apex_s"].fillna(jumps["touchdown_s"]), atol=1e-9)
    refused(labbook("export", path, "--mcap", "r001", at=small.folder), 2, "r001.mcap")
    refused(labbook("export", tmp_path / "x.mcap", "--mcap", "r0011", at=small.folder), 2, "r001")
    assert not (tmp_path / "x.mcap").exists()
