"""Bad values: wrong units, spikes, clipped, dead and held sensors; all files are synthetic."""

from __future__ import annotations

import pytest

from tests.ingest.bad_input import ROWS, Case, check, check_one_row_lost, read, with_cell, with_heights
from tests.ingest.synthetic import LOG_HEADER, text

VALUES = [
    Case("cm labelled m", with_heights(lambda h: f"{100 * h:.4f}"), True, "out_of_range", 0),
    Case("mm labelled m", with_heights(lambda h: f"{1000 * h:.3f}"), True, "out_of_range", 0),
    Case("mV labelled V", with_heights(lambda h: 16_000 + h, "battery [V]"), True, "out_of_range", 0),
    Case("mAh labelled Ah", b"run,charge [Ah]\nr001,812\nr002,790\n", True, "out_of_range", 0),
    Case("inches", with_heights(lambda h: f"{h / 0.0254:.5f}", "height [in]"), False, "", 600),
    Case("a mass as a height", with_heights(lambda h: h, "height [kg]"), True, "unit_not_convertible"),
    Case("spike of 1e35", with_cell("2.2e35"), False, "out_of_range", 599),
    Case("denormal", with_cell("2e-310"), False, "out_of_range", 599),
    Case(
        "spikes in 2 % of rows",
        text(LOG_HEADER, [f"{3 * n},9e9,0.2,400" if n % 50 == 0 else row for n, row in enumerate(ROWS)]),
        True,
        "out_of_range too_many_rejected",
    ),
    Case("flat tops", with_heights(lambda h: min(h, 0.45)), False, "channel_clipped", 600),
    Case("dead sensor", with_heights(lambda _: 0), False, "channel_constant", 600),
    Case(
        "sensor slower than the log",
        text(
            LOG_HEADER,
            [
                ",".join([row.split(",")[0], *ROWS[n - n % 4].split(",")[1:2], *row.split(",")[2:]])
                for n, row in enumerate(ROWS)
            ],
        ),
        False,
        "channel_held",
        600,
    ),
    Case(
        "stuck logger",
        text(
            LOG_HEADER,
            [
                f"{row.split(',')[0]},{ROWS[100].split(',', 1)[1]}" if 100 <= n < 140 else row
                for n, row in enumerate(ROWS)
            ],
        ),
        False,
        "packets_held",
    ),
]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (with_heights(lambda h: f"{1000 * h:.3f}"), '--column "height [m]=body_height:mm" --override-units'),
        (with_heights(lambda h: f"{100 * h:.3f}"), '--column "height [m]=body_height:cm" --override-units'),
        (
            with_heights(lambda h: 16_000 + h, "battery [V]"),
            '--column "battery [V]=battery_voltage:mV" --override-units',
        ),
    ],
)
def test_values_of_another_unit_name_the_flags_that_read_them(data: bytes, said: str) -> None:
    (found,) = [finding for finding in read(data).findings if finding.rule == "out_of_range"]
    assert f"`{said}`" in found.message


@pytest.mark.parametrize("case", VALUES, ids=lambda case: case.name)
def test_bad_values_have_their_outcome(case: Case) -> None:
    check(case)


@pytest.mark.parametrize("case", [case for case in VALUES if case.kept == 599], ids=lambda case: case.name)
def test_a_value_no_sensor_can_give_rejects_its_whole_row(case: Case) -> None:
    check_one_row_lost(case, "rejected")


def test_repeated_packets_are_a_held_gap() -> None:
    stuck = next(case for case in VALUES if case.name == "stuck logger")
    (part,) = read(stuck.data).parts
    (gap,) = part.gaps
    assert gap.kind == "held"
    assert gap.samples_missing == 39  # rows 101 to 139 repeat row 100
    assert gap.start_s == part.time_s[100]
    assert gap.start_s + gap.length_s == pytest.approx(part.time_s[140])
