"""A book from Python: frames, samples and results as on the command line, and nothing written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import labbook as package
from data_schema.errors import BookMissing, UnknownName, UsageError
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, reported_book, small_book


def test_the_report_from_python_is_that_of_the_command(tmp_path: Path) -> None:
    small = reported_book(tmp_path)
    (written,) = (small.folder / "reports").glob("*/numbers.json")
    printed = set(json.loads(written.read_text())["numbers"])
    with package.open(small.folder) as book:
        report = book.report()
        assert {one.id for one in report.results.provenance} == printed
        assert report.claims[0] in report._repr_html_()
        headlines = report.frame("joules_by_condition")
        assert len(headlines) == len(report.tables["joules_by_condition"].rows)
        assert report.figure("passive_drain").axes
        with pytest.raises(UnknownName, match="headlines"):
            report.frame("headline")
        with pytest.raises(UnknownName, match="savings"):
            report.figure("saving")


def test_reading_changes_nothing(book: SmallBook) -> None:
    before = sorted((path, path.stat().st_mtime_ns) for path in (book.folder / "raw").rglob("*"))
    with package.open(book.folder) as opened:
        text = repr(opened)
        assert "16 runs" in text
        for ask in (opened.runs, opened.jumps, opened.charges, opened.conditions, opened.findings, opened.verdicts):
            ask()
            ask("run=r001")
        opened.report("b_ad_gain=0")
    assert sorted((path, path.stat().st_mtime_ns) for path in (book.folder / "raw").rglob("*")) == before


def test_a_frame_shows_what_was_said_meanwhile(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    with package.open(small.folder) as opened:
        before = opened.runs()
        assert opened.jumps().loc[("r001", 2), "counted"]
        good(labbook("jumps", "reject", "r001", "2", "--reason", "misfire", at=small.folder))
        assert not opened.jumps().loc[("r001", 2), "counted"]
        assert opened.runs().loc["r001", "jumps_counted"] == before.loc["r001", "jumps_counted"] - 1


def test_samples_have_units_and_nan_within_gaps(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    with package.open(small.folder / "raw") as book:  # a folder within it
        found = book.signal("r002")
        assert found.attrs["run"] == "r002"
        assert found["body_height"].attrs["units"] == "m"
        assert found["time"].attrs["units"] == "s"
        assert found["time"].to_index().is_monotonic_increasing
        for start_s, length_s, _kind in json.loads(found.attrs["gaps"]):
            within = found.sel(time=slice(start_s + 1e-9, start_s + length_s - 1e-9))
            assert within.sizes["time"] >= 1
            assert np.isnan(within["body_height"]).all()
        with pytest.raises(UsageError, match="r002"):
            book.signal("r002", role="force")
        with pytest.raises(UnknownName, match="r001"):
            book.signal("r0001")
        with pytest.raises(UnknownName, match="log"):
            book.signal("r002", role="logs")


def test_of_several_signals_one_is_named(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    path = tmp_path / "r002_more.csv"
    path.write_text("time [ms],body_height [m]\n" + "".join(f"{4 * n},{0.4 + n * 1e-4:.4f}\n" for n in range(400)))
    good(labbook("ingest", path, "--run", "r002", at=small.folder))
    with package.open(small.folder) as book:
        with pytest.raises(UsageError, match="r002_more"):
            book.signal("r002")
        assert book.signal("r002", file="r002_more.csv").sizes["time"] == 400
        assert len(book.signals().loc[["r002"]]) == 2


def test_netcdf_of_a_run_is_read_as_it_was(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    with package.open(small.folder) as book:
        samples = book.signal("r001")
    samples.to_netcdf(tmp_path / "r001.nc")
    with xr.open_dataset(tmp_path / "r001.nc") as back:
        xr.testing.assert_identical(back.load(), samples)


def test_a_folder_without_a_book(tmp_path: Path) -> None:
    with pytest.raises(BookMissing, match="no book"):
        package.open(tmp_path)


def test_a_closed_book_says_so_and_results_are_short(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    with package.open(small.folder) as opened:
        report = opened.report()
        assert len(repr(report)) < 5000
        assert report.claims[0] in repr(report)
    for ask in (opened.runs, opened.report, lambda: opened.signal("r001")):
        with pytest.raises(UsageError, match="closed"):
            ask()
    assert "closed" in repr(opened)
