"""Bad time: backwards, duplicated, wrapped, epochs, rates, clocks; all files are synthetic."""

from __future__ import annotations

import pytest

from tests.ingest.bad_input import LOG, ROWS, Case, check, clock, read, with_times
from tests.ingest.synthetic import LOG_HEADER, text

TIME = [
    Case("one step backwards", with_times(lambda n, t: t - 20 if n == 50 else t), False, "time_backwards", 599),
    Case("duplicated stamp", with_times(lambda n, t: 163 if n == 50 else t), False, "time_duplicate", 599),
    Case("5 % equal stamps", with_times(lambda n, _: 3 * (n - n // 20)), False, "arrival_times", 600),
    Case("missing stamp", with_times(lambda n, t: "" if n == 50 else t), False, "time_missing", 599),
    Case("constant", with_times(lambda *_: 5), True, "time_duplicate too_many_rejected"),
    Case("spike", with_times(lambda n, t: 10**8 if n == 50 else t), False, "time_spike", 599),
    Case("junk first stamp", with_times(lambda n, t: 10**7 if n == 0 else t), False, "time_spike", 599),
    Case("jump of hours", with_times(lambda n, t: t + 7_200_000 * (n > 300)), False, "time_restarted", 600),
    Case("pause of 13 s", with_times(lambda n, t: t + 13_000 * (n > 300)), False, "recording_paused", 600),
    Case("dropped packets", text(LOG_HEADER, ROWS[:100] + ROWS[103:]), False, "packets_dropped", 597),
    Case("milliseconds labelled seconds", with_times(lambda _, t: t, "time [s]"), True, "rate_implausible"),
    Case("unit unknown", with_times(lambda _, t: t, "time [fortnight]"), True, "time_unit_unknown"),
    Case("FILETIME", with_times(lambda _, t: 133_500_000_000_000_000 + t * 10_000, "time [filetime]"), False, "", 600),
    Case(
        "Excel serial date",
        with_times(lambda _, t: f"{44000.5 + t / 86_400_000:.10f}", "time"),
        True,
        "time_unit_missing",
    ),
    Case("epoch in s", with_times(lambda _, t: f"{1607954342 + t / 1000:.3f}", "time [s]"), False, "", 600),
    Case("epoch in ms", with_times(lambda _, t: 1607954342000 + t), False, "", 600),
    Case("epoch in us", with_times(lambda _, t: 1607954342000000 + 1000 * t, "time [us]"), False, "", 600),
    Case("midnight", with_times(lambda _, t: clock(86_399_000 + t), "time"), False, "midnight_passed", 600),
    Case("uint32 wrap", with_times(lambda _, t: (t + 2**32 - 1000) % 2**32), False, "time_wrapped", 600),
    Case("reboot", with_times(lambda n, t: t + 5_000_000 if n < 300 else t - 1000), False, "time_restarted", 600),
    Case("clock chaos", with_times(lambda n, t: (n % 20) * 3 + 10_000 * (n // 20 % 2)), True, "time_unusable"),
    Case("rate header contradicts", b"# Rate: 1000 Hz\n" + with_times(lambda n, _: 2 * n), True, "rate_contradicts"),
    Case("rate header a little off", b"# Rate: 303 Hz\n" + LOG, False, "rate_differs", 600),
    Case("start not 0", with_times(lambda _, t: t + 36_548), False, "", 600),
    Case(
        "local time without zone",
        with_times(lambda _, t: "2021-06-05 " + clock(52_200_000 + t), "time"),
        False,
        "instant_unknown",
        600,
    ),
    Case("day and month unclear", with_times(lambda _, t: "03/04/2019 " + clock(t), "time"), True, "date_unclear"),
    Case(
        "clock of 1980",
        with_times(lambda _, t: "1980-01-01T" + clock(t) + "Z", "time"),
        False,
        "clock_implausible",
        600,
    ),
    Case(
        "two time columns",
        text("time [ms],a,time [ms],b", [f"{n},1,{2 * n},2" for n in range(300)]),
        True,
        "several_time_columns",
    ),
    Case("no time, no rate", text("height [m]", [row.split(",")[1] for row in ROWS]), True, "rate_missing"),
    Case("nothing but time", text("time [ms]", [row.split(",")[0] for row in ROWS]), True, "no_channels"),
]


@pytest.mark.parametrize("case", TIME, ids=lambda case: case.name)
def test_bad_time_has_its_outcome(case: Case) -> None:
    check(case)


EPOCHS = [case for case in TIME if case.name.startswith(("epoch", "FILETIME"))]


@pytest.mark.parametrize("case", EPOCHS, ids=lambda case: case.name)
def test_an_epoch_gives_the_instant_and_the_same_axis(case: Case) -> None:
    (part,), (clean,) = read(case.data).parts, read(LOG).parts
    instant = "2024-01-17T21:20:00.000000Z" if case.name == "FILETIME" else "2020-12-14T13:59:02.000000Z"
    assert part.start_utc == instant
    assert part.time_s == pytest.approx(clean.time_s, abs=1e-6)
