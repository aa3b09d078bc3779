"""MAT files of versions 4 and 5: channels by name or number; damaged, packed too tight or of objects: refused."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
import scipy.io

from ingest.model import ColumnDeclaration
from tests.helpers.wording import says
from tests.ingest.reading import read, refusal, rules

N = 60
TIME_S = np.arange(N) / 300
HEIGHT_M = np.random.default_rng(6).normal(0.4, 0.01, N)


def mat(variables: dict[str, object], version: str = "5", packed: bool = False) -> bytes:
    target = io.BytesIO()
    scipy.io.savemat(target, variables, format=version, do_compression=packed)
    return target.getvalue()


SECONDS = {"time_unit": "s"}
METRES = {"columns": {"height": ColumnDeclaration("body_height", "m")}}


@pytest.mark.parametrize("version", ["4", "5"])
@pytest.mark.parametrize("packed", [False, True])
def test_vectors_of_one_length_are_channels(version: str, packed: bool) -> None:
    variables = {"time": TIME_S, "height": HEIGHT_M, "fs": 300.0, "name": "jump"}
    result = read(mat(variables, version, packed), **SECONDS, **METRES)
    assert not result.refused
    (part,) = result.parts
    assert (part.part, part.rate_hz) == ("log", pytest.approx(300.0))
    assert part.channels[0].values.tolist() == HEIGHT_M.tolist()
    assert "variable_ignored" in rules(result)


@pytest.mark.parametrize("version", ["4", "5"])
@pytest.mark.parametrize("turned", [False, True])
def test_a_matrix_has_columns_by_number_and_asks_for_its_rate(version: str, turned: bool) -> None:
    matrix = np.column_stack([TIME_S, HEIGHT_M])
    data = mat({"jump": matrix.T if turned else matrix}, version)
    assert "rate_missing" in rules(read(data))
    columns = {"1": ColumnDeclaration("time", "s"), "2": ColumnDeclaration("body_height", "m")}
    (part,) = read(data, columns=columns).parts
    assert (part.part, part.rate_hz) == ("jump", pytest.approx(300.0))
    assert part.channels[0].values.tolist() == HEIGHT_M.tolist()


def test_structs_of_vectors_are_parts() -> None:
    leg = {"time": TIME_S, "height": HEIGHT_M, "q": np.tile(TIME_S[:, None], 3)}
    data = mat({"left": leg, "right": {name: values[: N // 2] for name, values in leg.items()}})
    result = read(data, **SECONDS, **METRES)
    assert not result.refused
    left, right = result.parts
    assert [left.part, right.part] == ["left", "right"]
    assert [channel.name for channel in left.channels] == ["body_height", "q_1", "q_2", "q_3"]
    assert (len(left.time_s), len(right.time_s)) == (N, N // 2)


def test_big_endian_version_4() -> None:
    data = struct.pack(">5i", 1000, N, 1, 0, 7) + b"height\0" + HEIGHT_M.astype(">f8").tobytes()
    (part,) = read(data, rate_hz=300.0, **METRES).parts
    assert part.channels[0].values.tolist() == HEIGHT_M.tolist()


def test_long_integers_keep_their_digits_as_stamps() -> None:
    stamps = 132_000_000_000_000_000 + np.arange(N, dtype=np.int64) * 33_333
    result = read(mat({"time": stamps, "height": HEIGHT_M}), time_unit="filetime", **METRES)
    assert result.parts[0].rate_hz == pytest.approx(300.0, rel=1e-4)


@pytest.mark.parametrize(
    ("data", "rule", "facts"),
    [
        (mat({"x": np.zeros(2 << 20)}, packed=True), "mat_refused", ["variable at byte 128", "largest_expansion"]),
        (b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(600), "mat_refused", ["version 7.3"]),
        (b"\x89HDF\r\n\x1a\n" + bytes(600), "format_not_read", ["HDF5"]),
        (mat({"x": HEIGHT_M}, packed=True)[:-9], "mat_refused", ["variable at byte 128", "cut"]),
        (mat({"x": HEIGHT_M}, "4")[:-9], "mat_refused", ["matrix at byte 0", "cut"]),
        (struct.pack("<5i", 0, 2**30, 2**30, 0, 2) + b"x\0" + bytes(80), "mat_refused", ["matrix at byte 0", "cut"]),
        (mat({"x": HEIGHT_M * 1j}), "no_data_rows", ["no vector"]),
    ],
)
def test_what_is_refused_and_why(data: bytes, rule: str, facts: list[str]) -> None:
    found = refusal(read(data, rate_hz=300.0))
    assert found.rule == rule
    says(found.message, *facts)


def test_simulinks_structure_with_time_is_one_table() -> None:
    time = np.arange(400) / 100
    signals = {"values": 400.0 + np.arange(400) % 7, "dimensions": 1.0, "label": "body_height"}
    data = mat({"tout": time, "simout": {"time": time, "signals": signals, "blockName": "hopper/leg"}})
    result = read(data, time_unit="s", columns={"body_height": ColumnDeclaration(unit="mm")})
    assert (result.refused, result.rows_kept, [part.part for part in result.parts]) == (False, 400, ["simout"])
    assert result.parts[0].rate_hz == pytest.approx(100.0)
    assert result.parts[0].channels[0].values[:2].tolist() == [0.4, 0.401]
