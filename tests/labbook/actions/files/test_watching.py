"""When a watched file is complete: properties of the pure core, on a clock of the test's own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labbook.actions.files.watching import (
    RESTART_S,
    RHYTHM,
    STILL_S,
    UNENDED_S,
    End,
    Followed,
    Seen,
    due,
    is_unfinished,
    look,
)

LOOK_S = 0.05
LOG = Path("r001.csv")


@dataclass(frozen=True)
class Taken:
    """When a file was handed out, and with how many bytes."""

    at_s: float
    size_bytes: int


def followed(sizes: Sequence[int], end: End = End.UNKNOWN, look_s: float = LOOK_S) -> list[Taken]:
    """Look at a file that has these sizes, one a look; returns when it was handed out."""
    files: dict[Path, Followed] = {}
    handed = []
    for number, size in enumerate(sizes):
        now_s = number * look_s
        files = look(files, {LOG: Seen(size, size, end)}, now_s)
        for path in due(files, now_s):
            files[path] = files[path].as_taken()
            handed.append(Taken(now_s, size))
    return handed


def after(seconds: float, size: int) -> list[int]:
    """The sizes of looks at a file that stays as it is for so long."""
    return [size] * (math.ceil(seconds / LOOK_S) + 1)


growing = st.lists(st.tuples(st.integers(1, 1000), st.floats(0.0, RESTART_S - 1.0)), min_size=1, max_size=12)
"""A file that grows by so many bytes, then pauses for so many seconds, and so on."""


def sizes_of(pieces: list[tuple[int, float]]) -> list[int]:
    sizes, size = [], 0
    for more, pause_s in pieces:
        size += more
        sizes += after(pause_s, size)
    return sizes


@given(growing)
def test_every_file_is_handed_out_once_it_is_whole_and_the_last_time_whole(pieces: list[tuple[int, float]]) -> None:
    sizes = sizes_of(pieces)
    longest_s = max(STILL_S, UNENDED_S, RHYTHM * RESTART_S)
    handed = followed([*sizes, *after(longest_s + 1, sizes[-1])])
    assert handed[-1].size_bytes == sizes[-1]
    assert [one.size_bytes for one in handed] == sorted({one.size_bytes for one in handed})  # each state once


@given(growing)
def test_a_file_written_in_blocks_is_mistaken_for_whole_a_few_times_at_most(pieces: list[tuple[int, float]]) -> None:
    sizes = sizes_of(pieces)
    handed = followed([*sizes, *after(RHYTHM * RESTART_S + 1, sizes[-1])])
    assert len(handed) <= 2 + math.log(RESTART_S / STILL_S, RHYTHM)


@given(growing)
def test_no_file_is_handed_out_that_changed_less_than_the_time_before(pieces: list[tuple[int, float]]) -> None:
    sizes = sizes_of(pieces)
    for one in followed(sizes):
        before = [size for number, size in enumerate(sizes) if one.at_s - STILL_S <= number * LOOK_S <= one.at_s]
        assert set(before) == {one.size_bytes}


@given(st.integers(1, 100), st.floats(0.01, 0.5))
def test_one_written_at_once_waits_for_its_time_and_a_look(size: int, look_s: float) -> None:
    (one,) = followed([size] * 200, look_s=look_s)
    assert STILL_S - 1e-9 <= one.at_s <= STILL_S + look_s + 1e-9


@given(st.integers(1, 100))
def test_a_certain_end_waits_for_nothing_and_a_missing_one_longer(size: int) -> None:
    assert followed([size], End.THERE) == [Taken(0.0, size)]
    (one,) = followed(after(2 * UNENDED_S, size), End.MISSING)
    assert one.at_s == pytest.approx(UNENDED_S, abs=2 * LOOK_S)
    (late,) = followed([*after(1.0, size), *after(2 * UNENDED_S, size + 1)], End.MISSING)
    assert late.size_bytes == size + 1


@given(st.lists(st.sampled_from([0, 5]), min_size=1, max_size=100))
def test_an_empty_file_is_never_handed_out(sizes: list[int]) -> None:
    assert all(one.size_bytes == 5 for one in followed(sizes))


@given(st.floats(0.3, 30.0), st.floats(0.01, 10.0))
def test_time_in_which_nobody_looked_is_no_pause_of_the_file(away_s: float, later_s: float) -> None:
    files = look({}, {LOG: Seen(1, 1)}, 0.0)
    files = look(files, {LOG: Seen(2, 2)}, away_s)  # it may have grown all the while
    now_s = away_s + STILL_S + later_s
    assert due(look(files, {LOG: Seen(2, 2)}, now_s), now_s) == [LOG]


def test_a_stick_that_comes_back_has_nothing_new() -> None:
    files = look({}, {LOG: Seen(1, 1)}, 0.0)
    files = look(files, {LOG: Seen(1, 1)}, 1.0)
    files = {LOG: files[LOG].as_taken()}
    files = look(files, {}, 2.0)
    assert due(files, 2.0) == []
    files = look(files, {LOG: Seen(1, 1)}, 60.0)
    assert due(files, 60.0) == []
    files = look(files, {LOG: Seen(1, 7)}, 61.0)  # the same length, written anew
    assert due(look(files, {LOG: Seen(1, 7)}, 62.0), 62.0) == [LOG]


def test_what_is_to_be_tried_again_comes_again_unchanged() -> None:
    files = look({}, {LOG: Seen(1, 1)}, 0.0)
    files = {LOG: look(files, {LOG: Seen(1, 1)}, 1.0)[LOG].as_taken(again_s=5.0)}
    assert due(look(files, {LOG: Seen(1, 1)}, 4.9), 4.9) == []
    assert due(look(files, {LOG: Seen(1, 1)}, 5.0), 5.0) == [LOG]


def test_the_one_that_ended_first_comes_first() -> None:
    late, early = Path("a.csv"), Path("b.csv")
    files = look({}, {early: Seen(1, 1)}, 0.0)
    files = look(files, {early: Seen(1, 1), late: Seen(1, 1)}, 0.1)
    assert due(look(files, {early: Seen(1, 1), late: Seen(1, 1)}, 1.0), 1.0) == [early, late]


@pytest.mark.parametrize("name", [".hidden.csv", "r1.csv.part", "r1.CRDOWNLOAD", "r1.csv~", "~$sheet.xlsx", "x.tmp"])
def test_names_of_unfinished_files(name: str) -> None:
    assert is_unfinished(name)


@pytest.mark.parametrize("name", ["r1.csv", "part.csv", "tmp", "a~b.csv", "r1.partial.csv"])
def test_names_of_files(name: str) -> None:
    assert not is_unfinished(name)
