"""Bertec text exports: columns, plates, sign, axes, arrival times; all synthetic, after published columns."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from ingest.model import Declarations
from tests.helpers.wording import says
from tests.ingest.reading import channel, only_part, read, rules, values
from tests.ingest.synthetic import bertec_acquire, text


def test_acquire_is_recognised_and_its_units_are_marked_as_assumed() -> None:
    result = read(bertec_acquire())
    part = only_part(result)
    assert (result.format, result.role, part.part) == ("bertec_text", "force", "force")
    assert part.rate_hz == pytest.approx(1000 / 1.00002, rel=1e-9)
    force = channel(result, "force_z")
    assert (force.unit, force.source_name) == ("N", "Fz")
    says(force.assumed, "Bertec")
    assert "unit_assumed" in rules(result)


def table(data: bytes) -> list[list[str]]:
    return [line.split(",") for line in data.decode().split()]


def rewritten(change: Callable[[list[str]], list[str]]) -> bytes:
    head, *rows = table(bertec_acquire())
    return text(",".join(head), [",".join(change(row)) for row in rows])


def test_a_unit_in_the_header_stands_above_the_makers() -> None:
    data = rewritten(lambda row: [*row[:6], f"{float(row[6]) / 1000:.7f}", *row[7:]]).replace(b"Fz", b"Fz [kN]")
    assert np.median(values(only_part(read(data)))["force_z"][:400]) == pytest.approx(60.0, abs=0.5)


def drifting() -> bytes:
    head, *rows = table(bertec_acquire(load_n=0.0))
    moved = ([*row[:6], f"{float(row[6]) + n / 200:.4f}", *row[7:]] for n, row in enumerate(rows))
    return text(",".join(head), [",".join(row) for row in moved])


@pytest.mark.parametrize(
    ("data", "rule", "severity"),
    [
        (
            rewritten(lambda row: [*row[:7], *(f"{1000 * float(cell):.3f}" for cell in row[7:10]), *row[10:]]),
            "moment_unit_implausible",
            "file",
        ),
        (bertec_acquire().replace(b"Fx,Fy,Fz", b"Fz,Fy,Fx"), "force_axes_suspect", "note"),
        (drifting(), "force_zero_drift", "note"),
    ],
    ids=["newton millimetres", "load on the wrong axis", "drift of the unloaded plate"],
)
def test_what_no_plate_gives_is_found(data: bytes, rule: str, severity: str) -> None:
    assert (rule, severity) in {(found.rule, found.severity) for found in read(data).findings}


def test_a_balance_plate_is_read_once_its_maker_and_the_unit_of_its_time_are_said() -> None:
    columns = (1, 6, 7, 8, 10, 11)
    head, *rows = [[row[column] for column in columns] for row in table(bertec_acquire())]
    data = text("Time," + ",".join(head[1:]), [",".join(row) for row in rows])
    assert {"time_unit_missing", "unit_missing"} <= rules(read(data))
    part = only_part(read(data, Declarations(time_unit="ms", instrument="bertec_balance")))
    assert set(values(part)) == {"force_z", "moment_x", "moment_y", "cop_x", "cop_y"}


SDK_HEADER = "Timestamp;" + ";".join(
    f"{quantity}{plate}" for plate in (1, 2) for quantity in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
)
SDK_HEADER += ";Copx1;Copy1;Copxy1;Copx2;Copy2;Copxy2"


def sdk(stamp: Callable[[int], str], cop_scale: float, n: int = 2000, unloaded: str = "0") -> bytes:
    """A log of a program on the SDK: `;`, empty columns, CRLF, no final newline."""
    noise = np.random.default_rng(3).normal(0, 2, n)
    rows = []
    for number in range(n):
        fz = (600.0 if number % 1000 < 400 else 0.0) + noise[number]
        plate = [0.0, 0.0, fz, 0.05 * fz, -0.1 * fz, 0.0]
        cop = f"{0.1 * cop_scale:.5f};{0.05 * abs(cop_scale):.5f};" if fz > 20 else f"{unloaded};{unloaded};"
        rows.append(f"{stamp(number)};" + ";".join(f"{value:.4f}" for value in plate * 2) + f";{cop};{cop}")
    return "\r\n".join([SDK_HEADER, *rows]).encode()


def test_sdk_log_with_arrival_times_counts_samples_and_fits_the_centre_of_pressure() -> None:
    first = 133_500_000_000_000_000
    result = read(sdk(lambda number: str(first + (number - number % 8) * 10_000), -1000.0))
    part = only_part(result)
    assert "arrival_times" in rules(result)
    assert np.array_equal(part.time_s, np.arange(2000) / 1000.0)
    assert part.start_utc == "2024-01-17T21:20:00.000000Z"
    assert values(part)["cop_x"][0] == pytest.approx(0.1)  # written in mm with the other sign
    assert "cop_fitted" in rules(result)


@pytest.mark.parametrize("unloaded", ["-11000.5", "2.5e7", "inf", "1.#INF", "nan"])
def test_the_centre_of_pressure_of_an_unloaded_plate_rejects_no_rows(unloaded: str) -> None:
    """163 of 173 rejected rows of a plate's file were unloaded, their centre of pressure 11 m away."""
    result = read(sdk(lambda number: f"{number / 1000:.3f}", 1.0, unloaded=unloaded))
    assert (result.refused, result.rows_kept, result.rows_rejected) == (False, 2000, 0)
    assert np.abs(channel(result, "cop_x").values[:400]) == pytest.approx(np.full(400, 0.1), abs=1e-5)


def test_arrival_times_of_another_rate_are_refused() -> None:
    first = 133_500_000_000_000_000
    result = read(sdk(lambda number: str(first + (number - number % 8) * 20_000), 1.0))
    assert result.refused
    assert "rate_contradicts" in rules(result)


def test_sdk_log_with_a_byte_order_mark_and_a_leading_date() -> None:
    head, *rows = sdk(lambda number: f"{number / 1000:.3f}", 1.0).decode().split("\r\n")
    dated = [f"Date;{head}", *(f"2026-03-02 10:11:12.123;{row}" for row in rows)]
    result = read(b"\xef\xbb\xbf" + "\r\n".join(dated).encode())
    assert result.format == "bertec_text"
    assert only_part(result).rate_hz == pytest.approx(1000.0)
    assert values(only_part(result))["cop_x_2"][0] == pytest.approx(0.1)
    assert "empty_column" in rules(result)


def test_three_further_columns_a_plate_do_not_shift_the_second() -> None:
    head, *rows = table(bertec_acquire(plates=2))
    wider = [[*row[:12], "0.1", "0.2", "0.3", *row[12:], "0.4", "0.5", "0.6"] for row in rows]
    names = [*head[:12], "COPxy", "Sway", "Load", *head[12:], "COPxy", "Sway", "Load"]
    stored = values(only_part(read(text(",".join(names), [",".join(row) for row in wider]))))
    assert np.median(stored["force_z_2"][:400]) == pytest.approx(60.0, abs=0.5)
    assert np.median(stored["moment_x_2"][:400]) == pytest.approx(-3.0, abs=0.1)
