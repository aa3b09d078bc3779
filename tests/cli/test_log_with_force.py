"""A log that also holds the vertical force is a log, whose jumps count, and a record of force."""

from __future__ import annotations

from pathlib import Path

from tests.cli.shell import good, labbook
from tests.helpers.attention import told
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.hopping_log import hopping_log
from tests.helpers.web import served

_WEIGHT_N = 19.6


def book_with_force(folder: Path) -> SmallBook:
    """A book whose run r001 has such a log: on the ground the force is about the weight, in the air nothing."""
    book = small_book(folder)
    good(labbook("files", "withdraw", "r001.csv", "--why", "the plate was not read", at=book.folder))
    head, *rows = hopping_log(3).decode().splitlines()
    place = head.split(",").index(next(name for name in head.split(",") if "height" in name))
    forces = (0.0 if float(row.split(",")[place]) > 0.27 else 2 * _WEIGHT_N for row in rows)
    lines = (f"{row},{force:.1f}" for row, force in zip(rows, forces, strict=True))
    log = folder / "both.csv"
    log.write_text("\n".join([f"{head},force_z [N]", *lines, ""]))
    good(labbook("ingest", log, "--run", "r001", "--axes", "z up", at=book.folder))
    return book


def test_its_jumps_and_its_force_count(tmp_path: Path) -> None:
    book = book_with_force(tmp_path)
    shown = good(labbook("show", "r001", "--json", at=book.folder)).json
    assert [one["role"] for one in shown["files"] if one["name"] == "both.csv"] == ["log"]
    assert shown["jumps_found"] == 3
    assert shown["mean_apex_height"]["value"] is not None
    assert shown["from_plate"]
    assert "log_missing" not in told(book.folder)


def test_its_force_stands_below_its_jumps(tmp_path: Path) -> None:
    book = book_with_force(tmp_path)
    with served(book.folder, "--as", ADA) as server:
        beside = {run: server.json(f"/api/runs/{run}/log") for run in ("r001", "r002")}
        samples = {run: server.ask(f"/api/runs/{run}/samples")[1] for run in beside}
    assert {run: log["beside"] for run, log in beside.items()} == {"r001": ["force (N)"], "r002": ["leg (mm)"]}
    for run, log in beside.items():
        assert len(samples[run]) == (8 + 4 + 4) * log["samples"]
