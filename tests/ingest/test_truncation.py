"""A file cut anywhere, and bytes of any sort: one-sentence refusals, no crash, never a number that was not written."""

from __future__ import annotations

import gzip

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from ingest.model import Declarations, ReadFile
from ingest.read import read_file
from tests.ingest.formats.test_archive import LOG, same, zipped
from tests.ingest.formats.test_excel import LOG as ROWS
from tests.ingest.formats.test_matlab import HEIGHT_M, METRES, SECONDS, TIME_S, mat
from tests.ingest.good_files import DECLARED, GOOD_FILES
from tests.ingest.reading import check_invariants
from tests.ingest.synthetic_workbooks import workbook

CUTS, LAST_CUTS = 8, 12
"""So many over a file, and so many bytes off its end; a soak cuts everywhere."""


def read(data: bytes, name: str = "") -> ReadFile:
    result = read_file(data, DECLARED.get(name, Declarations()))
    check_invariants(result)
    return result


def check_cut(name: str, whole: bytes, clean: ReadFile, end: int) -> None:
    """What is left of a cut file is a beginning of it; a line that was begun is remarked on."""
    cut = read(whole[:end], name)
    if cut.refused or cut.format != clean.format:
        assert cut.findings
        return
    for part, original in zip(cut.parts, clean.parts, strict=False):
        n = len(part.time_s)
        assert np.array_equal(part.time_s, original.time_s[:n])
        values = {channel.source_name: channel.values for channel in original.channels}
        for channel in part.channels:
            assert np.array_equal(channel.values, values[channel.source_name][:n], equal_nan=True)
    assert len(cut.parts) <= len(clean.parts)
    if not clean.parts:  # the charge of a charger's log is the last that its counter showed
        assert [row.charge_mah for row in cut.charges] == [row.charge_mah for row in clean.charges][: len(cut.charges)]
    lost = clean.rows_kept - cut.rows_kept
    in_a_line = whole[end - 1 : end] not in (b"\n", b"\r") and whole[end : end + 1] not in (b"\n", b"\r")
    if lost and in_a_line and end > 0:
        assert cut.findings, end


@pytest.mark.parametrize("everywhere", [False, pytest.param(True, marks=pytest.mark.soak)])
@pytest.mark.parametrize("name", GOOD_FILES)
def test_a_cut_file_is_reported_or_whole(name: str, everywhere: bool) -> None:
    whole = GOOD_FILES[name]()
    clean = read(whole, name)
    assert (clean.format, clean.refused) == (name, False)
    first = max(0, len(whole) - LAST_CUTS)
    for end in {*range(0, first, 1 if everywhere else max(1, first // CUTS)), *range(first, len(whole))}:
        check_cut(name, whole, clean, end)


IN_THREE = b"".join(gzip.compress(piece) for piece in (LOG[:1000], LOG[1000:2000], LOG[2000:]))
VECTORS: dict[str, object] = {"time": TIME_S[:9], "height": HEIGHT_M[:9]}
PACKED = {
    "zip": zipped({"a.csv": LOG}),
    "gzip": gzip.compress(LOG),
    "gzip in three": IN_THREE,
    "gzip in gzip": gzip.compress(IN_THREE),
    "workbook": workbook({"a": ROWS}),
    "mat, packed": mat(VECTORS, packed=True),
    "mat 5": mat(VECTORS),
    "mat 4": mat(VECTORS, "4"),
}


@pytest.mark.parametrize("name", PACKED)
def test_no_cut_and_no_flipped_byte_of_what_is_packed_gives_other_values(name: str) -> None:
    """A MAT file that is not packed has no checksum: its values may be others, and nothing breaks."""
    data, noise = PACKED[name], np.random.default_rng(7)
    declared = Declarations(**SECONDS, **METRES) if name.startswith("mat") else Declarations()
    whole = read_file(data, declared)
    assert not whole.refused
    for share in range(20):
        assert read_file(data[: len(data) * share // 20], declared).refused
    for _ in range(60):
        mutant = bytearray(data)
        mutant[int(noise.integers(len(data)))] ^= 1 << int(noise.integers(8))
        result = read_file(bytes(mutant), declared)
        assert result.refused or name in ("mat 4", "mat 5") or same(whole, result)


TOKENS = st.sampled_from(
    [
        *(bytes(512), b"\0", b'"', b",", b";", b"\n", b"\r", b"#", b"\x1a", b"\xb5", b".", b"-", b" ", b"\t", b"nan"),
        *(b"inf", b"1e999", b"9" * 20, b"1" * 17, b"12:30:00", b"2021-06-05 14:30:00", b"[m]", b"time", b"$1;"),
    ]
)
EDITS = st.lists(st.tuples(st.floats(0, 1), st.integers(0, 60), st.binary(max_size=40) | TOKENS), max_size=6)


def edited(whole: bytes, edits: list[tuple[float, int, bytes]]) -> bytes:
    for place, removed, inserted in edits:
        at = int(place * len(whole))
        whole = whole[:at] + inserted + whole[at + removed :]
    return whole


@pytest.mark.parametrize("name", GOOD_FILES)
@settings(max_examples=4, derandomize=True, suppress_health_check=list(HealthCheck))
@given(edits=EDITS)
@example(edits=[(0.25, 26, b'"'), (0.13352092079026615, 2, b'"')])  # a quote that spans lines, an IndexError once
def test_any_damage_ends_in_sentences(name: str, edits: list[tuple[float, int, bytes]]) -> None:
    read(edited(GOOD_FILES[name](), edits), name)


@pytest.mark.soak
@pytest.mark.parametrize("name", GOOD_FILES)
@settings(max_examples=3000, suppress_health_check=list(HealthCheck))
@given(edits=EDITS)
def test_any_damage_ends_in_sentences_at_length(name: str, edits: list[tuple[float, int, bytes]]) -> None:
    read(edited(GOOD_FILES[name](), edits), name)
