"""Files that were once read wrongly without a word: each test names the wrong answer that came of it."""

from __future__ import annotations

import numpy as np
import pytest

from ingest.model import ChannelData, ColumnDeclaration, Declarations, Finding, Profile, ReadFile
from ingest.read import read_file
from tests.ingest.synthetic import LOG_HEADER, robot_rows, text

ROWS = robot_rows()


def read(data: bytes, declared: Declarations | None = None) -> ReadFile:
    return read_file(data, declared or Declarations())


def finding(result: ReadFile, rule: str) -> Finding:
    """The one finding of this rule."""
    (found,) = [finding for finding in result.findings if finding.rule == rule]
    return found


def channel(result: ReadFile, name: str) -> ChannelData:
    """The channel of this name in the only part."""
    (part,) = result.parts
    (found,) = [channel for channel in part.channels if channel.name == name]
    return found


@pytest.mark.parametrize(
    "declared",
    [
        Declarations(columns={"height": ColumnDeclaration("body_height", "mm")}),
        Declarations(profiles=(Profile("p", ("height",), columns={"height [m]": ColumnDeclaration(unit="mm")}),)),
    ],
    ids=["flag", "profile"],
)
def test_a_declared_unit_against_the_header_was_read_as_declared(declared: Declarations) -> None:
    """0.42 m became 0.00042 m."""
    result = read(text(LOG_HEADER, ROWS), declared)
    assert result.refused
    message = finding(result, "unit_contradicts").message
    assert all(part in message for part in ("'height [m]'", "says m ", "mm is declared", "--override-units"))


def test_a_declared_time_unit_against_the_header_was_read_as_declared() -> None:
    """300 Hz became 300 kHz."""
    profile = Profile("p", ("height [m]",), time_column="time [ms]", time_unit="us")
    assert finding(read(text(LOG_HEADER, ROWS), Declarations(profiles=(profile,))), "unit_contradicts")


def test_a_header_that_is_wrong_can_be_overridden_and_one_that_agrees_needs_no_flag() -> None:
    same = Declarations(columns={"height": ColumnDeclaration("body_height", "metre")})
    assert channel(read(text(LOG_HEADER, ROWS), same), "body_height").scale == 1.0
    over = Declarations(columns={"height": ColumnDeclaration("body_height", "mm")}, override_units=True)
    assert channel(read(text(LOG_HEADER, ROWS), over), "body_height").scale == 1e-3


@pytest.mark.parametrize("delimiter", ["\t", ";"])
def test_thousands_points_were_read_as_decimals(delimiter: str) -> None:
    """1.002 mm beside 999 mm became 1.002 mm, though the string pot stood at 1002 mm."""
    heights = [f"{h}" if h < 1000 else f"{h // 1000}.{h % 1000:03d}" for h in range(900, 1100)]
    rows = [f"{3 * k}{delimiter}{h}" for k, h in enumerate(heights)]
    data = text(f"time [ms]{delimiter}height [mm]", rows)
    message = finding(read(data), "decimal_sign_unclear").message
    assert "--decimal ." in message
    assert "--decimal ," in message
    assert not read(data, Declarations(decimal_sign=".")).refused


def test_three_decimals_throughout_are_decimals() -> None:
    rows = [f"{3 * k}\t{1 + k / 1000:.3f}" for k in range(200)]
    assert channel(read(text("time [ms]\theight [m]", rows)), "body_height").values[2] == pytest.approx(1.002)
