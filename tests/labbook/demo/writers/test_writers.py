import csv
import datetime as dt
import io
from pathlib import Path

import numpy as np
import pytest

from data_schema.vocabulary import RunKind
from labbook.demo.files import recharge_course
from labbook.demo.writers import (
    COLUMNS,
    RunRow,
    bertec_text,
    checksum,
    icharger_log,
    run_sheet,
)

SAMPLE = Path(__file__).parents[5] / "shared" / "samples" / "charger" / "LiPo[Storage_952_CH1].txt"


def rows_of(text: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text.decode())))


def test_run_sheet_has_empty_factors_for_an_idle_run_and_quotes_notes() -> None:
    started = dt.datetime.fromisoformat("2021-06-14 17:05")
    idle = RunRow("r016", started, 16, RunKind.IDLE, {}, "A", "hopper", 1199, 0, 1, 'hung, "still"')
    made = RunRow("r017", started, 17, RunKind.JUMPS, {"foot": "small", "k_gain": 400}, "B", "hopper", 720, 25, 2, "")
    first, second = rows_of(run_sheet(("foot", "k_gain"), [idle, made]))
    assert (first["foot"], first["k_gain"], first["note"]) == ("", "", 'hung, "still"')
    assert (second["date"], second["started"], second["kind"]) == ("2021-06-14", "17:05", "jumps")
    assert (second["foot"], second["k_gain"], second["starts"]) == ("small", "400", "2")


def test_icharger_lines_have_22_fields_a_valid_checksum_and_the_charge() -> None:
    course = recharge_course(4, 150, 15.4)
    lines = icharger_log(course).splitlines()
    assert len(lines) == course.time_s.size
    for line in lines:
        body, _, xor = line.rpartition(b";")
        assert line.count(b";") == 21
        assert int(xor) == checksum(body + b";")
    fields = [line.split(b";") for line in lines]
    assert [int(field[2]) for field in fields[:3]] == [0, 1000, 2000]
    assert int(fields[-1][8]) == 150
    current_10ma = np.array([int(field[5]) for field in fields])
    assert np.trapezoid(current_10ma) / 360 == pytest.approx(150, rel=0.01)
    assert all(field[15:21] == [b"0"] * 6 for field in fields)


@pytest.mark.skipif(not SAMPLE.exists(), reason="the public charger log is not beside this checkout")
def test_checksum_is_the_one_of_a_public_log() -> None:
    for line in SAMPLE.read_bytes().splitlines():
        body, _, xor = line.rpartition(b";")
        assert int(xor) == checksum(body + b";")


def test_bertec_text_has_the_columns_of_acquire() -> None:
    n = 4
    text = bertec_text(np.linspace(0, 3.00006, n), np.ones((n, 3)), np.full((n, 3), -2.0), np.full((n, 2), 0.25))
    assert text.endswith(b"\r\n")
    rows = rows_of(text)
    assert tuple(rows[0]) == COLUMNS
    assert [row["Timestamp"] for row in rows] == ["0.00000", "1.00002", "2.00004", "3.00006"]
    assert [row["Seq"] for row in rows] == ["0", "1", "2", "3"]
    assert rows[3] | {"Seq": "", "Timestamp": ""} == {
        "Seq": "",
        "Timestamp": "",
        "Sync": "0",
        "Aux": "0",
        **dict.fromkeys(("Fx", "Fy", "Fz"), "1.0000"),
        **dict.fromkeys(("Mx", "My", "Mz"), "-2.00000"),
        **dict.fromkeys(("COPx", "COPy"), "0.250000"),
    }
