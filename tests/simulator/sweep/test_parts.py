"""The unfinished sweep on disk."""

from __future__ import annotations

import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.sweep.chunks import Chunks
from simulator.sweep.parts import COLUMNS, DONE, LOCK, PLAN, Parts, open_parts, part_folder, remove_parts
from tests.helpers.scenes import is_sentence
from tests.helpers.wording import says

CHUNKS = Chunks(rows=10, rows_each=4)
IDENTITY: dict[str, str | float] = {"scene": "sim2", "accuracy": 1e-4}
SHAPE = (2, 3)


def block(number: int) -> NDArray[np.float64]:
    first, after = CHUNKS.bounds(number)
    return np.arange(60.0).reshape(10, *SHAPE)[first:after]


@pytest.fixture
def parts(tmp_path: Path) -> Iterator[Parts]:
    with open_parts(tmp_path / "out.nc", IDENTITY, CHUNKS, SHAPE) as opened:
        yield opened


def test_what_is_kept_is_read_back(parts: Parts) -> None:
    assert parts.missing() == [0, 1, 2]
    for number in (2, 0, 1):
        parts.keep(number, block(number))
    assert parts.missing() == []
    for place in range(3):
        assert parts.column(place).tolist() == np.arange(60.0)[place::3].tolist()


@pytest.mark.parametrize("lost", [COLUMNS, DONE])
def test_without_one_of_its_files_nothing_is_done(lost: str, tmp_path: Path) -> None:
    out = tmp_path / "out.nc"
    with open_parts(out, IDENTITY, CHUNKS, SHAPE) as parts:
        parts.keep(1, block(1))
    (part_folder(out) / lost).unlink()
    with open_parts(out, IDENTITY, CHUNKS, SHAPE) as parts:
        assert parts.missing() == [0, 1, 2]
        for number in range(3):
            parts.keep(number, block(number))
        assert parts.column(2).tolist() == np.arange(60.0)[2::3].tolist()


def test_a_chunk_is_marked_when_its_rows_are_on_disk(parts: Parts, monkeypatch: pytest.MonkeyPatch) -> None:
    def power_cut(_file: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("os.fsync", power_cut)
    with pytest.raises(KeyboardInterrupt):
        parts.keep(0, block(0))
    assert parts.missing() == [0, 1, 2]


def test_what_was_being_written_is_removed_and_what_was_done_is_kept(tmp_path: Path) -> None:
    out = tmp_path / "out.nc"
    with open_parts(out, IDENTITY, CHUNKS, SHAPE) as parts:
        parts.keep(1, block(1))
    (part_folder(out) / ".result.nc").write_bytes(b"half")
    (part_folder(out) / ".result.zarr").mkdir()
    with open_parts(out, IDENTITY, CHUNKS, SHAPE) as parts:
        assert parts.missing() == [0, 2]
    assert {entry.name for entry in part_folder(out).iterdir()} == {PLAN, LOCK, COLUMNS, DONE}
    remove_parts(part_folder(out))
    assert list(tmp_path.iterdir()) == []


def refusal(out: Path, identity: dict[str, str | float]) -> str:
    with (
        pytest.raises(UsageError) as refused,
        open_parts(out, identity, CHUNKS, SHAPE),
    ):
        pass
    assert is_sentence(str(refused.value))
    return str(refused.value)


def test_nobody_else_works_on_it_meanwhile(parts: Parts, tmp_path: Path) -> None:
    plan = json.loads((part_folder(tmp_path / "out.nc") / PLAN).read_text(encoding="utf-8"))
    assert plan == IDENTITY
    says(refusal(tmp_path / "out.nc", IDENTITY), "program is working")


@pytest.mark.parametrize("times", [60, pytest.param(600, marks=pytest.mark.soak)])
def test_programs_that_open_what_others_remove_wait_or_begin_anew(times: int, tmp_path: Path) -> None:
    out = tmp_path / "out.nc"

    said: list[str] = []

    def many_times(_program: int) -> None:
        for _ in range(times):
            try:
                with open_parts(out, IDENTITY, CHUNKS, SHAPE) as parts:
                    assert parts.missing() == [0, 1, 2]
                    parts.keep(0, block(0))
                    remove_parts(parts.folder)
            except UsageError as refused:
                said.append(str(refused))

    with ThreadPoolExecutor(4) as programs:
        list(programs.map(many_times, range(4)))
    assert len(said) < 4 * times
    assert all("another program" in sentence for sentence in said)
    with open_parts(out, IDENTITY, CHUNKS, SHAPE) as parts:
        remove_parts(parts.folder)
    assert list(tmp_path.iterdir()) == []


def test_what_differs_is_said(tmp_path: Path) -> None:
    out = tmp_path / "out.nc"
    with open_parts(out, IDENTITY, CHUNKS, SHAPE):
        pass
    said = refusal(out, {"scene": "sim2", "accuracy": 1e-6, "b_ad": 2.0})
    says(said, "differs in accuracy", "0.0001", "1e-06", "b_ad", "2 now")
    with open_parts(out, IDENTITY, CHUNKS, SHAPE) as parts:
        assert parts.missing() == [0, 1, 2]


def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    out = tmp_path / "out.nc"
    part_folder(out).mkdir()
    (part_folder(out) / "thesis.txt").write_text("mine", encoding="utf-8")
    says(refusal(out, IDENTITY), "no unfinished sweep")
    assert (part_folder(out) / "thesis.txt").read_text(encoding="utf-8") == "mine"
