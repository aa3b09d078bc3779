"""Minitaur logs of both layouts: values, rates, spacing of records, lost bytes, restarts, false headers."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.model import ColumnDeclaration, Declarations, Profile
from tests.ingest.formats import synthetic_minitaur as made
from tests.ingest.formats.synthetic_minitaur import SYNC, new_log, old_header, old_log, old_records, times_ms
from tests.ingest.reading import counts, read, values


def test_the_old_layout_keeps_records_that_hold_the_sync_bytes() -> None:
    data = old_log()
    assert len(data[len(old_header()) :].split(SYNC)) - 1 > 400  # what splitting at every AA BB would give
    result = read(data)
    assert (result.format, result.refused, result.rows_kept) == ("minitaur_log", False, 400)
    expected = [struct.unpack("<" + made.OLD_FORMAT, record[2:]) for record in old_records(times_ms(400))]
    found = values(result)
    assert found["q0"].tolist() == [row[4] for row in expected]
    assert found["controller_state"].tolist() == [row[-1] for row in expected]
    units = {channel.name: channel.unit for channel in result.parts[0].channels}
    assert (units["q7"], units["u0"]) == ("rad", None)
    assert result.parts[0].start_original == "36548 ms"


@pytest.mark.parametrize("rate_hz", [300.0, 1000.0 / 3.0, 100.0])
def test_the_rate_is_counted_from_end_to_end(rate_hz: float) -> None:
    (part,) = read(old_log(1200, rate_hz)).parts
    assert part.rate_hz == pytest.approx(rate_hz, rel=1e-3)


@pytest.mark.parametrize("trailing", [0, 6, 8])
def test_the_new_layout_in_the_scales_of_the_sdk(trailing: int) -> None:
    result = read(new_log(trailing=trailing))
    assert (result.refused, result.rows_read, result.rows_kept) == (False, 400, 400)
    assert ("stride_differs" in counts(result)) == (trailing > 0)
    found = values(result)
    assert (found["pos0"][0], found["torq0"][0], found["eul2"][0]) == pytest.approx((1.571, -0.25, 0.03))
    assert (found["acc2"][0], found["battery_voltage"][0], found["current"][0]) == pytest.approx((9.81, 15.8, -1.25))
    assert (found["xdot"][0], found["controller_state"][3]) == pytest.approx((0.5, 3.0))
    assert not any(name.startswith("up") for name in found)
    assert "user_bytes" in counts(result)
    assert result.parts[0].rate_hz == pytest.approx(90.0, rel=1e-2)


@pytest.mark.parametrize("by_profile", [True, False])
def test_user_bytes_are_read_as_declared(by_profile: bool) -> None:
    columns = {
        "UP.f32.0": ColumnDeclaration("k_gain", "1"),
        "UP.f32.2": ColumnDeclaration("body_height", "m"),
        "UP.f32.8": ColumnDeclaration("leg_length", "m"),
    }
    profile = Profile("minitaur", ("t", "behavMo"), columns=columns)
    declared = Declarations(profiles=(profile,)) if by_profile else Declarations(columns=columns)
    result = read(new_log(100), declared)
    found = values(result)
    assert found["k_gain"][0] == 400.0
    assert found["body_height"][50] == pytest.approx(0.5)
    assert "leg_length" not in found  # beyond the 32 bytes
    assert "declared_column_absent" in counts(result)


LAYOUTS = {
    "old": (old_header(), old_records(times_ms(300))),
    "new": (made.NEW_HEADER, made.new_records(times_ms(300), 8)),
}


@pytest.mark.parametrize("layout", LAYOUTS)
@given(st.integers(5, 290), st.integers(0, 80), st.integers(1, 120))
def test_lost_bytes_cost_the_records_they_cut_and_are_said(layout: str, record: int, place: int, n_bytes: int) -> None:
    header, records = LAYOUTS[layout]
    start = len(header) + sum(map(len, records[:record])) + place
    data = header + b"".join(records)
    result = read(data[:start] + data[start + n_bytes :])
    found = counts(result)
    assert "record_cut" in found or "packets_dropped" in found  # whole records that vanish show in t only
    assert 295 <= result.rows_kept < 300
    stamps = set(times_ms(300))
    assert not result.parts or all(
        round(stamp * 1000) + 36_548 in stamps for part in result.parts for stamp in part.time_s[:10]
    )


@pytest.mark.parametrize("layout", LAYOUTS)
def test_bytes_lost_at_either_end_cost_one_record(layout: str) -> None:
    header, records = LAYOUTS[layout]
    for kept in (slice(5, None), slice(-1)):
        result = read(header + b"".join(records)[kept])
        assert (result.refused, result.rows_kept, result.rows_rejected) == (False, 299, 1)
        assert counts(result)["record_cut"] == 1


def test_a_reboot_is_a_segment_and_the_counter_wraps_on() -> None:
    reboot = read(old_header() + b"".join(old_records([*times_ms(200), *times_ms(200, start_ms=500)])))
    assert [len(part.time_s) for part in reboot.parts] == [200, 200]
    wrapped = read(old_header() + b"".join(old_records(times_ms(200, start_ms=2**32 - 1000))))
    (part,) = wrapped.parts
    assert part.rate_hz == pytest.approx(100.0)
    assert "time_wrapped" in counts(wrapped)


def test_a_card_that_was_written_on_again_gives_two_parts() -> None:
    result = read(old_log(150) + old_log(100))
    assert (result.refused, result.rows_kept) == (False, 250)
    assert [(part.part, len(part.time_s)) for part in result.parts] == [("log", 150), ("log_2", 100)]
    assert "header_repeated" in counts(result)


@pytest.mark.parametrize(
    "header",
    [
        old_header(made.OLD_NAMES[:-1]),
        old_header(made.OLD_NAMES, "I" + "f" * 20 + "s"),
        old_header(made.OLD_NAMES, "I" + "f" * 20 + "x"),
        old_header(made.OLD_NAMES, "If999999999B"),
        old_header(made.OLD_NAMES, "I" + "9999d" * 20 + "B"),
        old_header(made.OLD_NAMES, ">" + made.OLD_FORMAT),
        old_header(["t"] * 22),
        made.NEW_HEADER.replace(b"/1/", b"/2/"),
        made.NEW_HEADER.replace(b"torq8h", b"torq9h"),
        made.NEW_HEADER.replace(b"torq8h", b"torq"),
        made.NEW_HEADER.replace(b"30h", b"30q"),
    ],
)
def test_a_header_that_describes_no_record_is_refused(header: bytes) -> None:
    result = read(header + b"".join(old_records(times_ms(50))))
    assert (result.format, result.refused) == ("minitaur_log", True)
    assert "record_layout_unreadable" in counts(result)


def test_records_shorter_than_the_header_says_are_refused_never_zero_rows() -> None:
    names = [f"a{n}" for n in range(200)]
    header = old_header(["t", *names], "I" + "d" * 200)
    result = read(header + b"".join(SYNC + bytes(10) for _ in range(20)) + SYNC)
    assert result.refused
    empty = read(old_header() + SYNC)
    assert empty.refused
