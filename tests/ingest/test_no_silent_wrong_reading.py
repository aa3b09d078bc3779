"""Files that were once read wrongly without a word: each test names the wrong answer that came of it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from data_schema.errors import UsageError
from ingest.model import ColumnDeclaration, Declarations, Profile, ReadFile, RobotFacts
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest import synthetic_plates as plates
from tests.ingest.reading import channel, finding, read, rules, values
from tests.ingest.synthetic import LOG_HEADER, robot_rows, text

ROWS = robot_rows()


TIME_IN_US = Profile("p", ("height [m]",), time_column="time [ms]", time_unit="us")


@pytest.mark.parametrize(
    ("declared", "column", "unit"),
    [
        (Declarations(columns={"height": ColumnDeclaration("body_height", "mm")}), "height [m]", "mm"),
        (Declarations(profile_columns={"height [m]": ColumnDeclaration(unit="mm")}), "height [m]", "mm"),
        (Declarations(profiles=(TIME_IN_US,)), "time [ms]", "us"),
    ],
    ids=["flag", "profile", "time"],
)
def test_a_declared_unit_against_the_header_was_read_as_declared(
    declared: Declarations, column: str, unit: str
) -> None:
    """0.42 m became 0.00042 m, and 300 Hz 300 kHz."""
    result = read(text(LOG_HEADER, ROWS), declared)
    assert result.refused
    says(finding(result, "unit_contradicts").message, repr(column), f"{unit} is declared", "--override-units")


def test_a_header_that_is_wrong_can_be_overridden_and_one_that_agrees_needs_no_flag() -> None:
    same = Declarations(columns={"height": ColumnDeclaration("body_height", "metre")})
    assert channel(read(text(LOG_HEADER, ROWS), same), "body_height").scale == 1.0
    over = Declarations(columns={"height": ColumnDeclaration("body_height", "mm")}, override_units=True)
    assert channel(read(text(LOG_HEADER, ROWS), over), "body_height").scale == 1e-3


@pytest.mark.parametrize("first", [900, 0, -20_000], ids=["at once", "later", "beyond the rows looked at first"])
@pytest.mark.parametrize(
    ("delimiter", "sign"), [(delimiter, sign) for delimiter in "\t;, |" for sign in ".," if delimiter != sign]
)
def test_thousands_points_were_read_as_decimals(delimiter: str, sign: str, first: int) -> None:
    """1.002 mm beside 999 mm became 1.002 mm, though the string pot stood at 1002 mm."""
    millimetres = [max(0, h) for h in range(first, 1100)]
    heights = [f"{h}" if h < 1000 else f"{h // 1000}{sign}{h % 1000:03d}" for h in millimetres]
    for unit, rate in (("s", 3e-3), ("ms", 3)):
        if unit == "ms" and sign == "," and first < 0:
            continue  # no comma among the rows looked at first: those with one are left out
        rows = [f"{rate * k:.{3 * (unit == 's')}f}".replace(".", sign) + delimiter + h for k, h in enumerate(heights)]
        data = text(f"time [{unit}]{delimiter}height [mm]", rows)
        message = finding(read(data), "decimal_sign_unclear").message
        assert f"--decimal {sign}" in message
        assert not read(data, Declarations(decimal_sign=sign)).refused


@pytest.mark.parametrize("values", [["320", "1.480", "300", "1.500"], ["100", "1.000", "999", "9.990"]])
def test_whole_numbers_beside_a_hundredth_of_them_in_three_decimals_are_asked_about(values: list[str]) -> None:
    rows = [f"{3 * k},{values[k % 4]}" for k in range(100)]
    assert finding(read(text("time [ms],height [mm]", rows)), "decimal_sign_unclear")


@pytest.mark.parametrize("values", [["250.5", "99", "100", "98.25"], ["0", "1.5", "2", "9.125"], ["999", "0.5"]])
def test_whole_numbers_beside_decimals_of_their_size_are_decimals(values: list[str]) -> None:
    rows = [f"{3 * k},{values[k % len(values)]}" for k in range(100)]
    read_as_written = channel(read(text("time [ms],height [mm]", rows)), "body_height").values[: len(values)]
    assert read_as_written == pytest.approx([float(value) / 1000 for value in values])


HEIGHTS = [f"{0.4 + k % 7 / 100:.3f}" for k in range(60)]


@pytest.mark.parametrize(
    "line",
    [
        "Filter frequency: 10 Hz",
        "cut-off frequency = 6 Hz",
        "Sampling rate of the display filter: 60 Hz",
        "Display update rate: 60 Hz",
        "Baud rate: 115200 Hz",
        "Low pass frequency 50 Hz",
        "frequency response: 200 Hz",
        "Sample rate divider: 4",
        "Sampling rate: 1,000 Hz",
        "heart rate: 60 Hz",
        "success rate: 75",
        "rate: 0 Hz",
    ],
)
def test_any_rate_above_the_table_was_taken_for_the_sampling_rate(line: str) -> None:
    """A filter at 10 Hz made a log of 300 Hz thirty times as long; 1,000 Hz became 1 Hz."""
    assert finding(read(text(f"# {line}\nheight [m]", HEIGHTS)), "rate_missing")


@pytest.mark.parametrize(
    "line",
    [
        "Cz\xeastotliwo\x9c\xe6 akwizycji: 100,00",
        "Abtastrate: 100",
        "Fr\xe9quence d'acquisition (Hz): 100",
        "Filter: none; sampling rate: 0.1 kHz",
        "Sampling rate of 2 channels: 100 Hz",
        "sample_rate,100",
        "SampleRate=100.000000",
        "Rate,100 Hz",
        "Rate (Hz):\t\t100.000",
    ],
)
def test_a_declared_rate_went_before_the_files_own_without_a_word(line: str) -> None:
    """1000 Hz declared for a file of 100 Hz: ten times too fast."""
    data = f"{line}\nheight [m]\n".encode("latin-1") + "\n".join([*HEIGHTS, ""]).encode()
    own = read(data)
    assert own.parts[0].rate_hz == 100.0
    assert line[3:10] in finding(own, "rate_from_header").message
    says(finding(read(data, Declarations(rate_hz=1000.0)), "rate_contradicts").message, "1000 Hz", " 100 Hz")
    for rate_hz, rule in ((110.0, "rate_contradicts"), (95.3, "rate_differs"), (101.0, "rate_differs")):
        assert finding(read(data, Declarations(rate_hz=rate_hz)), rule)
    for rate_hz in (100.0, 100.4):
        near = read(data, Declarations(rate_hz=rate_hz))
        assert finding(near, "rate_declared")
        assert "rate_differs" not in rules(near)


def test_the_first_of_two_sampling_rates_was_taken() -> None:
    """A camera at 100 Hz and an analog rate of 1000 Hz: whichever stood first."""
    data = text("# Sampling rate: 100 Hz\n# Acquisition rate: 1000 Hz\nheight [m]", HEIGHTS)
    assert "--rate" in finding(read(data), "rates_contradict").message


def coarse_log(n: int = 3600) -> list[str]:
    """Hops of 300 rows, the last 20 of each standing still, seen by sensors of coarse steps and little noise."""
    noise = np.random.default_rng(5)
    phase = np.arange(n) % 300
    hop = np.where(phase < 280, np.sin(phase * np.pi / 140.0), 0.0)
    height = np.rint(300 + 400 * hop + noise.normal(0, 0.2, n)).astype(int)
    leg = np.rint(200 + 300 * hop + noise.normal(0, 0.15, n)).astype(int)
    volts = np.rint(3000 - 300 * hop + noise.normal(0, 0.3, n)).astype(int) * 5
    return [f"{3 * k},{h},{x},{v}" for k, (h, x, v) in enumerate(zip(height, leg, volts, strict=True))]


COARSE_HEADER = "time [ms],height [mm],leg_length [mm],battery_voltage [mV]"


def test_repeats_by_chance_were_held_packets_and_packets_written_again_are_found() -> None:
    """A log of coarse steps had dozens of gaps that were none, and lost most of its jumps to them."""
    rows = coarse_log()
    assert read(text(COARSE_HEADER, rows)).parts[0].gaps == ()
    for k in range(1331, 1339):
        rows[k] = f"{3 * k},{rows[1330].split(',', 1)[1]}"
    (gap,) = read(text(COARSE_HEADER, rows)).parts[0].gaps
    assert (gap.kind, round(gap.start_s / 0.003), gap.samples_missing) == ("held", 1330, 8)


def plate_log(header: str) -> bytes:
    """Forces of any maker's plate: 4 N forward, a robot's stances of 40 N."""
    rows = [f"{k},4.0,1.0,{max(40 * np.sin(np.pi * k / 50), 0):.4f},2.0,-4.0,0.0" for k in range(400)]
    return text(header, rows)


ANY_PLATE = "time [ms],Fx [N],Fy [N],Fz [N],Mx [N*m],My [N*m],Mz [N*m]"


@pytest.mark.parametrize(
    "head",
    [f"# measured beside the Bertec plate of the other lab\n{ANY_PLATE}", ANY_PLATE.replace("time", "Timestamp")],
    ids=["a word", "columns of any maker"],
)
def test_the_word_bertec_turned_signs(head: str) -> None:
    """4 N forward became 4 N backward."""
    result = read(plate_log(head))
    assert channel(result, "force_x").values[0] == 4.0
    assert "--instrument" in finding(result, "force_sign_assumed").message


def test_an_instrument_is_declared_and_an_unknown_one_is_refused_with_the_nearest() -> None:
    result = read(plate_log(ANY_PLATE), Declarations(instrument="bertec_balance"))
    assert channel(result, "force_x").values[0] == -4.0
    assert "force_sign_assumed" not in rules(result)
    with pytest.raises(UsageError, match="'bertec_acquire'"):
        read(plate_log(ANY_PLATE), Declarations(instrument="bertec_aquire"))


def sheet(*lines: str, declared: Declarations | None = None, end: str = "\n") -> ReadFile:
    return read(("\n".join(lines) + end).encode(), declared)


CAPACITIES = ("run,capacity (mAh),charged (mAh)", "r1,6600,461", "r2,6600,470")


@pytest.mark.parametrize("order", [(0, 1, 2), (0, 2, 1)], ids=["capacity first", "charged first"])
def test_a_packs_capacity_was_what_was_charged(order: tuple[int, ...]) -> None:
    """6600 mAh for 461 mAh."""
    lines = [",".join(line.split(",")[place] for place in order) for line in CAPACITIES]
    assert [charge.charge_mah for charge in sheet(*lines).charges] == [461.0, 470.0]


def test_a_capacity_alone_is_asked_about_where_it_never_changes() -> None:
    message = finding(sheet("run,capacity (mAh)", "r1,6600", "r2,6600"), "charge_unclear").message
    assert "--column" in message
    assert not sheet("run,capacity (mAh)", "r1,461", "r2,470").refused
    declared = Declarations(columns={"capacity": ColumnDeclaration("charge")})
    assert not sheet("run,capacity (mAh)", "r1,6600", "r2,6600", declared=declared).refused


def test_the_first_of_two_charges_was_taken() -> None:
    lines = ("run,charged (mAh),mAh in", "r1,461,520")
    assert "'mAh in'" in finding(sheet(*lines), "column_ambiguous").message
    (charge,) = sheet(*lines, declared=Declarations(columns={"mAh in": ColumnDeclaration("charge", "mAh")})).charges
    assert charge.charge_mah == 520.0


def test_a_declared_unit_of_a_sheet_against_its_header_was_read_as_declared() -> None:
    """461 mAh became 461 000 mAh."""
    declared = Declarations(columns={"charged": ColumnDeclaration(unit="Ah")})
    assert finding(sheet("run,charged (mAh)", "r1,461", declared=declared), "unit_contradicts")


def test_a_charge_cut_in_the_last_line_was_taken() -> None:
    """79 mAh for 799 mAh."""
    lines = ("run,charged (mAh)", "r1,461", "r2,79")
    assert "--complete" in finding(sheet(*lines, end=""), "last_cell_cut").message
    assert not sheet(*lines).refused
    assert not sheet(*lines, end="", declared=Declarations(complete=True)).refused
    assert sheet("run,mAh,volts", "r1,461,16.80", "r2,799,16.8", end="").rows_kept == 1
    assert sheet("run,mAh,volts", "r1,461,16.80", "r2,799,16.81", end="").rows_kept == 2
    assert sheet("run,mAh,pack", "r1,461,A", "r2,799,B", end="").rows_kept == 2
    assert sheet("run,mAh,pack", "r1,461,old", "r2,799,ne", end="").rows_kept == 1
    assert sheet("mAh,run", "461,r9", "799,r1", end="").rows_kept == 1
    assert sheet("run,mAh,remark", "r1,461,all well", "r2,799,wi", end="").rows_kept == 2


def test_a_last_number_of_a_log_that_was_cut_was_taken() -> None:
    """79 mm for 799 mm in the last row, as there were numbers of two digits above."""
    heights = [f"{h}" for h in (*range(90, 150), *range(90, 150), *range(780, 800))]
    data = text("time [ms],height [mm]", [f"{3 * k},{h}" for k, h in enumerate(heights)])
    assert channel(read(data[:-1]), "body_height").values[-1] == pytest.approx(0.799)
    cut = read(data[:-2])
    assert channel(cut, "body_height").values[-1] == pytest.approx(0.798)
    assert (cut.rows_kept, cut.rows_rejected) == (len(heights) - 1, 1)


def in_bursts(
    n: int = 1600,
    size: int = 10,
    within_ms: int = 0,
    lost: tuple[int, int] = (0, 0),
    late_ms: Mapping[int, float] = MappingProxyType({}),
) -> bytes:
    """A log at 100 Hz whose rows come `size` at once, `within_ms` apart.

    Samples `lost` never came, and burst k came `late_ms[k]` late.
    """
    noise = np.random.default_rng(7)
    rows = []
    for k in range(n):
        height = 0.4 + 0.05 * np.sin(k / 15) + noise.normal(0, 1e-3)
        stamp = 10 * size * (k // size) + within_ms * (k % size) + late_ms.get(k // size, 0)
        if not lost[0] <= k < lost[1]:
            rows.append(f"{stamp:g},{height:.5f}")
    return text("time [ms],height [m]", rows)


@pytest.mark.parametrize("within_ms", [0, 1])
@pytest.mark.parametrize("size", [2, 10, 16])
def test_arrival_stamps_in_bursts_were_sample_times(size: int, within_ms: int) -> None:
    """Ten samples 1 ms apart and then 91 ms of nothing: 1000 Hz with nine of ten samples missing."""
    result = read(in_bursts(size=size, within_ms=within_ms))
    assert (result.refused, result.rows_kept) == (False, 1600)
    (part,) = result.parts
    assert part.rate_hz == pytest.approx(100.0)
    assert part.time_s == pytest.approx(np.arange(1600) / 100.0)
    assert part.gaps == ()
    assert "arrival stamps" in finding(result, "arrival_times").message


@pytest.mark.parametrize(
    "late_ms",
    [
        *({159: 60}, {159: 400}, {158: 60}, {157: 60, 158: 40}),
        *({40: 60}, {40: 300, 41: 225, 42: 150, 43: 75}, {40: 80, 41: 80, 42: 80}, {0: 60}),
    ],
    ids=["the last", "the last, very", "last but one", "last but two", "one", "over several", "three", "the first"],
)
def test_a_burst_that_came_late_was_lost_samples(late_ms: dict[int, float]) -> None:
    """A late last burst, and a delay that several bursts made up for, counted as samples that never came."""
    (part,) = read(in_bursts(late_ms=late_ms)).parts
    assert part.gaps == ()
    assert part.rate_hz == pytest.approx(100.0, rel=1e-3)
    assert part.time_s[-1] == pytest.approx(15.99, rel=1e-3)


@pytest.mark.parametrize(("bursts", "within"), [(30, 1e-3), (160, 3e-4)])
def test_jitter_of_bursts_does_not_lower_their_rate(bursts: int, within: float) -> None:
    """Lateness was counted from the least of the last burst alone, so that the rate came out low: by 0.3 % in 3 s."""
    rates = []
    for seed in range(20):
        late_ms = np.abs(np.random.default_rng(seed).normal(0, 3, bursts))
        (part,) = read(in_bursts(10 * bursts, late_ms=dict(enumerate(late_ms)))).parts
        assert part.gaps == ()
        rates.append(part.rate_hz)
    assert np.mean(rates) == pytest.approx(100.0, rel=within)
    assert np.max(np.abs(np.array(rates) - 100.0)) < 400 * within


@pytest.mark.parametrize(
    ("within_ms", "late_ms"),
    [(0, {}), (1, {}), (0, {48: 60}), (0, {50: 300, 51: 225, 52: 150, 53: 75}), (0, {159: 400})],
)
@pytest.mark.parametrize("lost", [(500, 510), (503, 506), (500, 540), (1560, 1570)])
def test_what_never_came_is_missing_among_bursts(
    lost: tuple[int, int], within_ms: int, late_ms: dict[int, float]
) -> None:
    (part,) = read(in_bursts(within_ms=within_ms, lost=lost, late_ms=late_ms)).parts
    assert part.rate_hz == pytest.approx(100.0, rel=1e-3)
    (gap,) = part.gaps
    assert gap.samples_missing == lost[1] - lost[0]
    assert gap.start_s == pytest.approx(lost[0] / 100, abs=0.1)
    assert part.time_s[-1] == pytest.approx(15.99, rel=1e-3)


def test_a_logger_that_records_now_and_then_has_real_holes() -> None:
    """Ten samples in 10 ms of every 100 ms, the height far on after each hole."""
    rows = [f"{k},{0.4 + 0.1 * np.sin(k / 30):.5f}" for k in range(16_000) if k % 100 < 10]
    data = text("time [ms],height [m]", rows)
    assert "mostly_missing" in rules(read(data))
    for result in (read(data, Declarations(rate_hz=1000.0)), read(b"# rate: 1000 Hz\n" + data)):
        (part,) = result.parts
        assert part.rate_hz == pytest.approx(1000.0, rel=0.01)
        assert len(part.gaps) == 159


def at_random(share: float, size: int = 10, bursts: int = 600, lost: frozenset[int] = frozenset()) -> bytes:
    """A log of `size` samples every 8.33 ms, their stamps at random within that share of it; bursts `lost` never came.

    Stamps are whole microseconds, some of them equal.
    """
    noise = np.random.default_rng(3)
    rows = []
    for burst in range(bursts):
        stamps = 8330 * (burst + share * np.sort(noise.random(size)))
        if burst not in lost:
            rows += [f"{t:.0f},{0.4 + 0.05 * np.sin((burst * size + k) / 95):.5f}" for k, t in enumerate(stamps)]
    return text("time [us],height [m]", rows)


@pytest.mark.parametrize(("share", "size"), [(0.2, 10), (0.4, 10), (0.4, 2), (0.3, 16)])
def test_stamps_at_random_within_a_burst_were_sample_times(share: float, size: int) -> None:
    """Ten stamps at random within 1.7 ms of every 8.33 ms: 11 666 Hz, and 821 739 samples missing of 27 360."""
    result = read(at_random(share, size))
    assert (result.refused, result.rows_kept) == (False, 600 * size)
    (part,) = result.parts
    assert part.rate_hz == pytest.approx(size / 8.33e-3, rel=2e-4)
    assert part.gaps == ()


def test_bursts_of_stamps_at_random_that_never_came_are_missing() -> None:
    (part,) = read(at_random(0.1, lost=frozenset({100, 300, 301}))).parts
    assert [gap.samples_missing for gap in part.gaps] == [10, 20]
    assert part.rate_hz == pytest.approx(10 / 8.33e-3, rel=1e-3)


def flags_of(message: str) -> list[str]:
    return re.findall(r"`(--rate [^`]*)`", message)


def test_more_samples_missing_than_present_are_asked_about() -> None:
    """Stamps at random all over the time between two bursts show neither rate nor bursts."""
    data = at_random(1.0, 16, 300)
    said = finding(read(data), "mostly_missing")
    assert said.severity == "file"
    of_stamps, counted = flags_of(said.message)
    rate_hz = float(of_stamps.removeprefix("--rate "))
    assert read(data, Declarations(rate_hz=rate_hz)).parts[0].rate_hz == pytest.approx(rate_hz, rel=1e-5)
    rate, column = counted.removeprefix("--rate ").split(" --column ")
    assert (float(rate), column) == (pytest.approx(16 / 8.33e-3, rel=2e-3), "time=own.clock")
    assert flags_of(finding(read(data, Declarations(rate_hz=float(rate))), "rate_contradicts").message)[1] == counted


@pytest.mark.parametrize("header", ["sample", "sample (-)"])
def test_a_counter_in_tens_was_taken_for_the_samples_number(header: str) -> None:
    """300 Hz became 30 Hz, nine of ten samples missing."""
    data = text(f"{header},height [m]", [f"{10 * k},{h}" for k, h in enumerate(HEIGHTS)])
    said = finding(read(data, Declarations(rate_hz=300.0)), "mostly_missing")
    assert said.severity == "file"
    says(said.message, "`--column sample=sequence`", "`--column sample=own.counter`")
    for channel_, duration_s in (("own.counter", 59 / 300), ("sequence", 590 / 300)):
        declared = Declarations(rate_hz=300.0, columns={"sample": ColumnDeclaration(channel_)})
        assert read(data, declared).parts[0].time_s[-1] == pytest.approx(duration_s)


COUNTERS = {
    "8 bits": ([*range(200, 256), *range(256), *range(90)], 256, range(130, 135)),
    "8 bits, lost at the end": ([*range(200, 256), *range(256), *range(90)], 256, range(54, 59)),
    "16 bits": (range(65_400, 65_800), 2**16, range(200, 205)),
    "32 bits": (range(2**32 - 100, 2**32 + 300), 2**32, range(200, 205)),
    "thousands from 1": ([*range(1, 1001)] * 2, 1001, range(998, 1003)),
    "8 bits with sign": ([*range(-128, 128)] * 2, 256, range(300, 305)),
    "it starts again": ([*range(200)] * 2, 1000, range(50, 55)),
}


@pytest.mark.parametrize("name", ["seq", "sample_no", "index", "packet_id", "n"])
@pytest.mark.parametrize(("numbers", "modulus", "lost"), COUNTERS.values(), ids=COUNTERS.keys())
def test_lost_samples_are_found_by_a_counter_that_passes_its_end(
    numbers: list[int], modulus: int, lost: range, name: str
) -> None:
    """After the first passage no loss was seen any more, before or behind it."""
    rows = [f"{n % modulus if n >= 0 else n},{0.4 + k % 9 / 1e3}" for k, n in enumerate(numbers) if k not in lost]
    (part,) = read(text(f"{name},height [m]", rows), Declarations(rate_hz=100.0)).parts
    (gap,) = part.gaps
    assert (gap.start_s, gap.samples_missing, gap.kind) == (pytest.approx((lost[0] - 1) / 100), 5, "dropped")
    assert part.time_s[-1] == pytest.approx((len(numbers) - 1) / 100)


def test_sample_numbers_that_do_not_count_up_are_said_not_to_show_losses() -> None:
    rows = [f"{n},{0.4 + k % 9 / 1e3}" for k, n in enumerate([*range(150), *range(40, 200)])]
    result = read(text("seq,height [m]", rows), Declarations(rate_hz=100.0))
    assert result.parts[0].gaps == ()
    assert finding(result, "sequence_unused").column == "seq"


@pytest.mark.parametrize("rate_hz", [700, 900, 990])
def test_a_tick_about_as_long_as_a_sample_is_asked_about(rate_hz: int) -> None:
    """700 Hz in whole milliseconds became 1000 Hz with 2571 samples lost."""
    kept = [k for k in range(6000) if k not in range(3000, 3020)]
    data = text("time [ms],height [m]", [f"{1000 * k // rate_hz},{0.4 + 0.05 * np.sin(k / 40):.5f}" for k in kept])
    said = finding(read(data), "rate_unclear")
    named = [float(flag.removeprefix("--rate ")) for flag in flags_of(said.message)]
    assert named == pytest.approx([rate_hz, 1000.0], rel=1e-3)
    (part,) = read(data, Declarations(rate_hz=float(rate_hz))).parts
    assert part.rate_hz == pytest.approx(rate_hz, rel=1e-3)
    assert sum(gap.samples_missing for gap in part.gaps) == pytest.approx(20, abs=1)
    (by_tick,) = read(data, Declarations(rate_hz=1000.0)).parts
    assert (by_tick.rate_hz, len(by_tick.gaps)) == (1000.0, pytest.approx(6000 * (1000 / rate_hz - 1), rel=0.02))


@pytest.mark.parametrize("head", ["", "# rate: 300 Hz\n"])
def test_rows_written_twice_are_no_samples_of_a_coarse_clock(head: str) -> None:
    rows = [row for k, row in enumerate(ROWS) for _ in range(2 if k % 21 == 5 else 1)]
    result = read(text(head + LOG_HEADER, rows))
    assert (result.rows_kept, finding(result, "time_duplicate").count) == (600, 29)
    assert result.parts[0].rate_hz == pytest.approx(300.0, rel=1e-3)


def test_losses_at_random_are_no_rounding() -> None:
    lost = np.random.default_rng(3).choice(np.arange(1, 5999), 600, replace=False)
    rows = [f"{k},{0.4 + 0.05 * np.sin(k / 40):.5f}" for k in range(6000) if k not in lost]
    (part,) = read(text("time [ms],height [m]", rows)).parts
    assert (part.rate_hz, sum(gap.samples_missing for gap in part.gaps)) == (1000.0, 600)


@pytest.mark.parametrize("time", ["time", "logged at"])
def test_a_comma_before_milliseconds_of_a_clock_is_its_decimal_sign(time: str) -> None:
    """Python's logging writes it: a comma that stands between thousands, it was said."""
    rows = [f"{k},2021-06-01 12:00:0{k // 100},{10 * k % 1000:03d},{447 + k % 9}.1" for k in range(400)]
    declared = Declarations(time_zone="UTC", columns={"logged at": ColumnDeclaration("time")} if time != "time" else {})
    result = read(text(f"sample,{time},height [mm]", rows), declared)
    (part,) = result.parts
    assert (part.rate_hz, part.start_utc) == (pytest.approx(100.0), "2021-06-01T12:00:00.000000Z")
    assert part.time_s[-1] == pytest.approx(3.99, abs=1e-6)


def test_whole_seconds_and_three_digits_in_columns_of_their_own_stay_apart() -> None:
    rows = [f"12:00:{k:02d},{447 + k},0.{4 + k % 2}" for k in range(60)]
    (part,) = read(text("time,current [mA],height [m]", rows), Declarations(rate_hz=1.0)).parts
    assert part.channels[0].values[:2].tolist() == pytest.approx([0.447, 0.448])


SECOND_HEADERS = {
    "other units": ("time [ms],height [mm],leg_length [mm],k_gain", "{t},{h:.3f},{x:.3f},400", 1e3),
    "reordered": ("time [ms],leg_length [m],height [m],k_gain", "{t},{x:.6f},{h:.6f},400", 1.0),
    "renamed": ("time [ms],foot_height [m],leg_length [m],gain", "{t},{h:.6f},{x:.6f},400", 1.0),
    "fewer columns": ("time [ms],height [m]", "{t},{h:.6f}", 1.0),
    "below a title": ("\nSecond trial of the day\n# rate: 100 Hz\ntime [ms],height [mm],leg_length [mm],k_gain",
                      "{t},{h:.3f},{x:.3f},400", 1e3),
}  # fmt: skip


@pytest.mark.parametrize("name", SECOND_HEADERS)
def test_a_second_table_was_read_under_the_first_header(name: str) -> None:
    """Millimetres became metres, legs became bodies: only the header's own row was rejected, 1 of 600."""
    header, row, scale = SECOND_HEADERS[name]
    second = [row.format(t=10 * k, h=0.3 * scale, x=0.1 * scale) for k in range(300)]
    result = read(text(LOG_HEADER, ROWS) + text(header, second))
    assert not result.refused, result.findings
    assert (result.rows_kept, result.rows_rejected) == (900, 0)
    assert finding(result, "second_header").line == 602 + header.count("\n")
    first, other = result.parts
    assert (first.part, other.part) == ("log", "log_table_2")
    assert len(first.time_s) == 600
    assert other.rate_hz == pytest.approx(100.0)
    values = {channel.name: float(channel.values[5]) for channel in other.channels}
    assert values["foot_height" if name == "renamed" else "body_height"] == pytest.approx(0.3)
    assert name == "fewer columns" or values["leg_length"] == pytest.approx(0.1)


def test_a_declaration_for_one_of_two_tables_leaves_the_other_alone() -> None:
    second = [f"{10 * k},{300 + k % 5}" for k in range(300)]
    declared = Declarations(columns={"h": ColumnDeclaration("foot_height", "mm")})
    result = read(text(LOG_HEADER, ROWS) + text("time [ms],h", second), declared)
    assert not result.refused
    assert "declared_column_absent" not in rules(result)


def test_a_header_of_unknown_names_is_not_a_bad_row_and_lines_of_words_are() -> None:
    """The numbers of `p` and `q` became heights."""
    second = [f"{3 * k},5.0,6.0,7" for k in range(300)]
    result = read(text(LOG_HEADER, ROWS) + text("n,p,q,r", second))
    assert result.refused
    assert finding(result, "second_header").line == 602
    words = read(text(LOG_HEADER, [*ROWS[:300], "ERR,ERR,ERR,ERR", *ROWS[300:]]))
    assert (words.rows_kept, words.rows_rejected, "second_header" in rules(words)) == (600, 1, False)


def test_a_short_table_above_a_longer_one_was_left_out_without_a_word() -> None:
    short = text("time [s],charge [mAh],current [A]", [f"{k},{k}.5,1.0" for k in range(10)])
    result = read(short + text(LOG_HEADER, ROWS))
    assert not result.refused, result.findings
    assert [(part.part, len(part.time_s)) for part in result.parts] == [("log", 10), ("log_table_2", 600)]


def test_tables_side_by_side_were_one() -> None:
    """The right one's heights lay on the left one's time, in which they were never measured."""
    both = [f"{row},,{10 * k},0.3" for k, row in enumerate(ROWS)]
    result = read(text(f"{LOG_HEADER},,time [ms],height [m]", both))
    assert finding(result, "tables_side_by_side")
    without_time = [f"{row},,0.3" for row in ROWS]
    assert finding(read(text(f"{LOG_HEADER},,height [m]", without_time)), "tables_side_by_side")


def test_a_second_time_without_a_unit_was_overlooked_and_a_declaration_decides() -> None:
    """Which of two times counts was taken from which has a unit."""
    data = text(f"t,{LOG_HEADER}", [f"{10 * k},{row}" for k, row in enumerate(ROWS)])
    assert "--column" in finding(read(data), "several_time_columns").message
    for name, rate_hz in (("t", 100.0), ("time", 300.0)):
        result = read(data, Declarations(columns={name: ColumnDeclaration("time", "ms")}))
        assert result.parts[0].rate_hz == pytest.approx(rate_hz, rel=1e-3)


HOPPER = RobotFacts(mass_kg=2.0, reach_m=0.3)
WEIGHT_N = 2.0 * 9.80665


def hopping_plate(header: str = ANY_PLATE, scale: float = 1.0, carried: float = 1.0, order: str = "xyz") -> bytes:
    """Hops of 0.5 s, 0.2 s of them on the plate with a half sine of force whose mean over a hop is the weight."""
    noise = np.random.default_rng(11)
    rows = []
    for k in range(4000):
        phase = k % 500
        fz = carried * WEIGHT_N * 2.5 * np.pi / 2 * np.sin(np.pi * phase / 200) if phase < 200 else 0.0
        force = {"x": 0.1 * fz + noise.normal(0, 0.5) - 3.0, "y": noise.normal(0, 0.5), "z": fz + noise.normal(0, 1.0)}
        forces = ",".join(f"{scale * force[axis]:.6f}" for axis in order)
        rows.append(f"{k},{forces},{0.02 * scale * fz:.6f},{-0.01 * scale * fz:.6f},0.0")
    return text(header, rows)


def with_robot(data: bytes, **declared: Any) -> ReadFile:
    return read(data, Declarations(robots=(HOPPER, RobotFacts(5.0, 0.5)), **declared))


def test_kilonewtons_labelled_newtons_were_stored() -> None:
    """0.02 N for 20 N."""
    message = finding(with_robot(hopping_plate(scale=1e-3)), "force_weight_implausible").message
    says(message, "2 kg", "19.6 N", "--override-units", "--no-robot-check")
    said = {"Fz": ColumnDeclaration("force_z", "kN")}
    result = with_robot(hopping_plate(scale=1e-3), columns=said, override_units=True)
    assert not result.refused, result.findings
    assert not with_robot(hopping_plate(scale=1e-3), no_robot_check=True).refused


def test_forward_and_vertical_force_exchanged_were_stored() -> None:
    """The forward force of a hop was the vertical one, a tenth of the weight."""
    message = finding(with_robot(hopping_plate(order="zyx")), "force_axes_swapped").message
    says(message, "--column", "force_z", "force_x")
    said = {"Fx [N]": ColumnDeclaration("force_z", "N"), "Fz [N]": ColumnDeclaration("force_x", "N")}
    moments = {"Mx": ColumnDeclaration("m1", "N*m"), "My": ColumnDeclaration("m2", "N*m")}
    assert not with_robot(hopping_plate(order="zyx"), columns={**said, **moments}).refused


def test_forces_of_a_known_robot_are_right_and_of_one_weighed_badly_noted() -> None:
    right = with_robot(hopping_plate())
    assert not {"force_weight_differs", "force_weight_implausible"} & {found.rule for found in right.findings}
    assert finding(with_robot(hopping_plate(carried=1.5)), "force_weight_differs")
    empty = text(ANY_PLATE, [f"{k},0,0,{np.sin(k):.3f},0,0,0" for k in range(1000)])
    assert not with_robot(empty).refused


def height_log(unit: str, scale: float, hop_m: float = 0.2) -> bytes:
    """Hops of 0.2 m, or standing, seen by a sensor with 1 mm of noise."""
    noise = np.random.default_rng(12).normal(0, 1e-3, 1200)
    height = 0.3 + hop_m * np.abs(np.sin(np.arange(1200) / 40.0)) + noise * (1 if hop_m else 0.05)
    rows = [f"{3 * k},{scale * h:.7g}" for k, h in enumerate(height)]
    return text(f"time [ms],height [{unit}]", rows)


def test_metres_labelled_millimetres_were_stored() -> None:
    """Jumps of 0.2 mm, of which no detector finds any; millimetres labelled centimetres, of 6 m."""
    message = finding(with_robot(height_log("mm", 1.0)), "height_implausible").message
    says(message, "0.5 m", "--override-units", "--no-robot-check")
    assert not with_robot(height_log("mm", 1.0), no_robot_check=True).refused
    assert not with_robot(height_log("m", 1.0, hop_m=0.0)).refused  # it stands
    assert with_robot(height_log("cm", 1e3, hop_m=0.6)).refused
    for unit, scale in (("m", 1.0), ("mm", 1e3)):
        assert not with_robot(height_log(unit, scale)).refused


@pytest.mark.parametrize("scale", [1.0, -1.0, 4.0, 7.0, 20.0])
def test_heights_beyond_the_robot_are_refused_and_none_is_stored_with_a_note(scale: float) -> None:
    """Of four logs of 2 to 4 m one was refused and three were stored."""
    result = with_robot(height_log("m", scale))
    assert result.refused is (scale != 1)
    assert result.refused is ("height_implausible" in {f.rule for f in result.findings})


def test_the_columns_of_a_second_header_of_a_sheet_were_those_of_the_first() -> None:
    """12 minutes became 12 mAh, at the cost of one row of 201."""
    first = [f"r{k},461,12" for k in range(100)]
    second = [f"r{100 + k},12,461" for k in range(100)]
    result = sheet("run,mAh,minutes", *first, "run,minutes,mAh", *second)
    assert finding(result, "second_header").line == 102
    left_blank = sheet("run,mAh,minutes", *first, "run,,mAh", *(f"r{100 + k},,461" for k in range(100)))
    assert finding(left_blank, "second_header").line == 102
    assert not sheet("run,mAh,minutes", *first, "run,mAh,minutes", *first).refused


def test_a_stated_rate_tells_bursts_from_holes() -> None:
    """White noise looks the same in bursts and in holes."""
    noise = np.random.default_rng(8).normal(0.4, 0.01, 1600)
    rows = [f"{100 * (k // 10) + k % 10},{h:.5f}" for k, h in enumerate(noise)]
    header = "time [ms],height [m]"
    for rate_hz, gaps in ((100.0, 0), (1000.0, 159)):
        (part,) = read(text(f"# Sampling rate: {rate_hz:g} Hz\n{header}", rows)).parts
        assert part.rate_hz == pytest.approx(rate_hz, rel=0.02)
        assert len(part.gaps) == gaps


def test_an_instruments_own_numbers_tell_what_was_lost_among_bursts() -> None:
    rows = [f"{k},{100 * (k // 10)},{0.4 + 0.05 * np.sin(k / 15):.5f}" for k in range(1600) if k not in (503, 504)]
    (part,) = read(text("seq,time [ms],height [m]", rows)).parts
    (gap,) = part.gaps
    assert (gap.samples_missing, gap.start_s) == (2, pytest.approx(5.02))


def test_a_comma_more_in_a_row_that_ends_in_a_comma_shifted_its_cells() -> None:
    """0,42 among points became a height of 0 m and a leg of 42 m, where every row ends in a comma."""
    rows = [f"{3 * k},0.4{k % 10},0.2{k % 10}," for k in range(300)]
    rows[200] = "600,0,40,0.20"
    for header in ("time [ms],height [m],leg_length [m],", "time [ms],height [m],leg_length [m]"):
        result = read(text(header, rows))
        assert (result.rows_kept, result.rows_rejected) == (299, 1)
        assert finding(result, "ragged_row").line == 202


def test_a_comma_more_in_a_padded_row_of_a_maker_shifted_its_cells() -> None:
    """6,0209 became forces of 6 N and 209 N, where a program had padded all lines with commas."""
    lines = plates.vicon(120).split(b"\r\n")
    lines[26] = lines[26].replace(b".", b",", 1)
    result = read(b"\r\n".join(lines))
    assert finding(result, "ragged_row").line == 27
    assert values(result)["force_y"].max() == pytest.approx(values(read(plates.vicon(120)))["force_y"].max())


@pytest.mark.parametrize("damaged", ["\x0b", "\x0c", "\x1c", "\x1d", "\x1f", "\x85"])
def test_a_damaged_last_digit_that_counts_as_a_blank_was_stripped(damaged: str) -> None:
    """0.425 became 0.42 and 451 mAh became 45 mAh, for a vertical tab and its like are blanks to a program."""
    for delimiter in ",;\t ":
        rows = [f"{3 * k}{delimiter}0.4{k % 10}5" for k in range(300)]
        rows[200] = f"600{delimiter}0.40{damaged}"
        result = read_file(f"time_ms{delimiter}height_m\n{chr(10).join(rows)}\n".encode("latin-1"), Declarations())
        assert (result.rows_kept, result.rows_rejected) == (299, 1), delimiter
    runs = [f"r{k},451,12" for k in range(200)]
    assert sheet("run,mAh,minutes", *runs, f"r200,45{damaged},12").rows_rejected == 1


PLATE_HEAD = ["Abtastrate: 1000 Hz", "Messdauer: 2,5 s", "Einheit: kN"]
ONE_FORCE = {"1": ColumnDeclaration("force_z", "kN")}


@pytest.mark.parametrize("above", [PLATE_HEAD, ["Platte, Labor 3", *PLATE_HEAD], ["Labor, Nord"], []])
@pytest.mark.parametrize("first_row", [None, 1])
def test_a_declared_decimal_comma_stood_between_cells(above: list[str], first_row: int | None) -> None:
    """0.021037 kN became 0 N, or 0 in one column and 21037 in another."""
    newtons = 21 + 0.037 * np.arange(300)
    data = "\n".join([*above, *(f"{value / 1000:.6f}".replace(".", ",") for value in newtons), ""]).encode()
    declared = Declarations(columns=ONE_FORCE, rate_hz=1000.0)
    asked = finding(read(data, declared), "decimal_comma_unquoted").message
    says(asked, "--decimal ,", "--delimiter ,")
    placed = {} if first_row is None else {"header_row": 0, "first_row": len(above) + 1}
    result = read(data, replace(declared, decimal_sign=",", **placed))
    assert channel(result, "force_z").values == pytest.approx(newtons)
