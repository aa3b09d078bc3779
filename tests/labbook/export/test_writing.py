"""An export is what the frames are, in whatever form, and there whole or not at all."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest
import xarray as xr

import labbook as package
from data_schema.columns import ValueKind
from labbook.export.tables import TABLES, Selection, every_table
from tests.cli.shell import good, labbook, no_file_above, refused
from tests.helpers.books import SmallBook, small_book
from tests.helpers.commands import Commands


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    """A book in which somebody wrote what a spreadsheet would run."""
    made = small_book(tmp_path_factory.mktemp("export"))
    at = made.folder
    good(labbook("jumps", "reject", "r001", "2", "--reason", "other", "--note", "=HYPERLINK(1)", at=at))
    good(labbook("jumps", "accept", "r001", "3", at=at))
    return made


def tables_of(small: SmallBook) -> dict[str, pd.DataFrame]:
    with small.open() as book, book.reading() as connection:
        selection = Selection(connection, book.store, book.configuration)
        return {table.name: table.frame().reset_index() for table in every_table(selection)}


def kinds_of(small: SmallBook, name: str) -> dict[str, ValueKind]:
    with small.open() as book, book.reading() as connection:
        columns = TABLES[name](Selection(connection, book.store, book.configuration)).columns
        return {column: about.kind for column, about in columns.items()}


def exported(small: SmallBook, folder: Path, *words: str) -> Path:
    good(labbook("export", folder, *words, at=small.folder))
    return folder


def test_csv_is_what_a_frame_writes(small: SmallBook, tmp_path: Path) -> None:
    folder = exported(small, tmp_path / "tables")
    with package.open(small.folder) as book:
        frames = {name: getattr(book, name)() for name in TABLES}
    for name, frame in frames.items():
        text = (folder / f"{name}.csv").read_text(encoding="utf-8")
        assert text.replace("'=HYPERLINK(1)", "=HYPERLINK(1)") == frame.to_csv(), name
    for name, frame in tables_of(small).items():
        kinds = kinds_of(small, name)
        times = [column for column, kind in kinds.items() if kind in (ValueKind.TIME, ValueKind.DATE)]
        types = {column: str(frame[column].dtype) for column in frame if column not in times}
        back = pd.read_csv(folder / f"{name}.csv", dtype=types, parse_dates=times)
        for column, kind in kinds.items():
            if kind is not ValueKind.TEXT:
                pd.testing.assert_series_equal(back[column], frame[column], check_dtype=False, check_exact=True)


def test_no_cell_is_a_formula(small: SmallBook, tmp_path: Path) -> None:
    folder = exported(small, tmp_path / "tables")
    with (folder / "verdicts.csv").open(encoding="utf-8", newline="") as stream:
        notes = [row["note"] for row in csv.DictReader(stream)]
    assert sorted(notes) == ["", "'=HYPERLINK(1)"]
    book = openpyxl.load_workbook(exported(small, tmp_path / "book", "--format", "xlsx") / "tables.xlsx")
    cells = [cell for sheet in book for row in sheet.iter_rows() for cell in row]
    assert all(cell.data_type != "f" for cell in cells)
    assert "=HYPERLINK(1)" in {cell.value for cell in cells}


def test_a_dictionary_describes_every_column_of_every_file(small: SmallBook, tmp_path: Path) -> None:
    folder = exported(small, tmp_path / "tables")
    described: dict[str, list[str]] = {}
    with (folder / "data_dictionary.csv").open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            described.setdefault(row["table"], []).append(row["column"])
            assert row["meaning"]
    found = {path.stem: path for path in folder.glob("*.csv") if path.stem != "data_dictionary"}
    assert found.keys() == described.keys() == TABLES.keys()
    for name, path in found.items():
        assert next(csv.reader(io.StringIO(path.read_text(encoding="utf-8")))) == described[name]


def test_parquet_and_workbook_come_back(small: SmallBook, tmp_path: Path) -> None:
    parquet = exported(small, tmp_path / "parquet", "--format", "parquet")
    workbook = exported(small, tmp_path / "xlsx", "--format", "xlsx") / "tables.xlsx"
    for name, frame in tables_of(small).items():
        back = pd.read_parquet(parquet / f"{name}.parquet")
        pd.testing.assert_frame_equal(back, frame)
        assert back.attrs["columns"].keys() == set(frame.columns)
        sheet = pd.read_excel(workbook, sheet_name=name, engine="openpyxl")
        assert list(sheet.columns) == list(frame.columns)
        for column, kind in kinds_of(small, name).items():
            if kind is ValueKind.NUMBER:
                np.testing.assert_allclose(sheet[column].to_numpy(float), frame[column].to_numpy(), rtol=1e-15)


def test_netcdf_has_units_and_comes_back(small: SmallBook, tmp_path: Path) -> None:
    folder = exported(small, tmp_path / "netcdf", "--format", "netcdf", "--signals")
    runs = tables_of(small)["runs"]
    with xr.open_dataset(folder / "runs.nc") as back:
        assert back["joules_J"].attrs["units"] == "J"
        np.testing.assert_array_equal(back["joules_J"], runs["joules_J"])
        assert list(back["run"].to_numpy()) == list(runs["run"])
        np.testing.assert_array_equal(back["is_control"], runs["is_control"].astype("float64"))
        assert back["is_control"].sum() == runs["is_control"].sum()
    with xr.open_dataset(folder / "signals" / "r001_log.nc") as back, package.open(small.folder) as book:
        xr.testing.assert_identical(back.load(), book.signal("r001"))


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_samples_come_back_to_the_last_digit(small: SmallBook, tmp_path: Path, form: str) -> None:
    folder = exported(small, tmp_path / "tables", "--format", form, "--signals", "--where", "run=r002")
    signals = pd.read_csv(folder / "signals.csv") if form == "csv" else pd.read_parquet(folder / "signals.parquet")
    path = folder / signals.loc[0, "samples"]
    back = pd.read_csv(path) if form == "csv" else pd.read_parquet(path)
    with package.open(small.folder) as book:
        samples = book.signal("r002")
    np.testing.assert_array_equal(back["time [s]"], samples["time"])
    np.testing.assert_array_equal(back["body_height [m]"], samples["body_height"])
    assert back["body_height [m]"].isna().sum() == len(samples.attrs["gaps"].split("],")) > 0


def test_an_export_takes_no_folder_that_holds_something(small: SmallBook, tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "thesis.txt").write_text("years of work")
    refused(labbook("export", folder, at=small.folder), 2, "mine", "new")
    refused(labbook("export", folder / "thesis.txt", at=small.folder), 2, "thesis.txt")
    refused(labbook("export", tmp_path / "x", "--format", "docx", at=small.folder), 2, "docx", "parquet")
    refused(labbook("export", tmp_path / "x", "--format", "xlsx", "--signals", at=small.folder), 2, "--signals", "csv")
    refused(labbook("export", tmp_path / "x", "--where", "run=r900", at=small.folder), 2, "r900")
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]
    assert [path.name for path in folder.iterdir()] == ["thesis.txt"]
    refused(labbook("export", small.folder / "raw" / "mine", at=small.folder), 2, "raw")
    refused(labbook("export", tmp_path / "x.mcap", "--mcap", "r001", "--signals", at=small.folder), 2, "--signals")


def test_an_empty_folder_is_filled_and_stays_the_same(small: SmallBook, tmp_path: Path) -> None:
    folder = tmp_path / "empty"
    folder.mkdir(mode=0o750)
    beside = tmp_path / ".empty.part"
    beside.mkdir()
    (beside / "thesis.txt").write_text("years of work")
    before = folder.stat()
    exported(small, folder)
    after = folder.stat()
    assert (after.st_ino, after.st_mode) == (before.st_ino, before.st_mode)
    assert (folder / "runs.csv").is_file()
    assert (beside / "thesis.txt").read_text() == "years of work"
    assert sorted(path.name for path in tmp_path.iterdir()) == [".empty.part", "empty"]
    assert not [path for path in folder.iterdir() if path.name.startswith(".")]


def test_of_two_exports_into_one_folder_one_is_whole_and_the_other_refused(
    small: SmallBook, tmp_path: Path, commands: Commands
) -> None:
    for number, there in enumerate((False, True)):
        folder = tmp_path / f"both{number}"
        if there:
            folder.mkdir()
        words = ("export", folder, "--signals", "--book", small.folder)
        running = [commands.start(*words, "--format", form) for form in ("csv", "parquet")]
        codes = [one.wait() for one in running]
        assert sorted(codes) == [0, 2]
        endings = {path.suffix for path in (folder / "signals").iterdir()}
        assert endings == {[".csv", ".parquet"][codes.index(0)]}
        assert len(list(folder.glob("signals/*"))) == 12
        assert sum(path.name.startswith(".") for path in tmp_path.iterdir()) == 0


@pytest.mark.parametrize("form", ["csv", "parquet", "netcdf"])
def test_a_full_disk_leaves_no_half_export(small: SmallBook, tmp_path: Path, form: str) -> None:
    words = ("export", tmp_path / "tables", "--format", form, "--signals")
    with no_file_above(40_000):
        answer = labbook(*words, at=small.folder)
    assert answer.code != 0
    assert answer.err.startswith("labbook: ")
    assert "disk" in answer.err or "tables" in answer.err
    assert not any(tmp_path.iterdir())


def test_what_is_private_is_left_out_for_sharing(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    at = small.folder
    good(labbook("note", "r001", "Ada Nwosu dropped it", at=at))
    good(labbook("jumps", "reject", "r001", "2", "--reason", "other", "--note", "Ada was tired", at=at))
    refused(labbook("export", tmp_path / "public", "--for-sharing", at=at), 2, "[privacy]")
    assert not (tmp_path / "public").exists()
    small.toml.write_text(small.toml.read_text() + '\n[privacy]\nleave_out = ["people", "notes"]\n')
    folder = exported(small, tmp_path / "public", "--for-sharing")
    text = "".join(path.read_text(encoding="utf-8") for path in folder.iterdir())
    assert "Nwosu" not in text
    assert "tired" not in text
    assert "people, notes" in (folder / "README.md").read_text()
    assert "AN" in set(pd.read_csv(folder / "verdicts.csv")["person"])
    refused(labbook("export", tmp_path / "x.mcap", "--mcap", "r001", "--for-sharing", at=at), 2, "--for-sharing")
