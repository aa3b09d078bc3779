"""Calibrations in labbook.toml and on the command line."""

from __future__ import annotations

from typing import Any

import pytest

from data_schema.calibration import Calibration, line_through
from data_schema.errors import InputRefused, UsageError
from labbook.cli.declaring import Declared
from labbook.cli.file_options import declared_options
from labbook.config.parsing import parse_configuration, template
from labbook.statements.importing import declarations
from tests.helpers.wording import refuses

PROFILE = """
[profiles.adc]
recognise = ["t", "adc_h"]
columns = { adc_h = { channel = "body_height", unit = "cm", %s } }
"""
BASE = template("book", "Ada Nwosu", "AN")


def in_profile(keys: str) -> tuple[Calibration, ...]:
    configuration = parse_configuration(BASE + PROFILE % keys, "labbook.toml")
    (profile,) = declarations(configuration, {}).profiles
    return profile.columns["adc_h"].calibrations


def on_command_line(column: str) -> dict[str, Any]:
    return declared_options(Declared(column=[column]))


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("offset = -4.7", (Calibration(offset=-4.7),)),
        (
            'scale = 0.0288, offset = -3.4, scale_se = 1e-5, offset_se = 0.1, source = "ruler"',
            (Calibration(0.0288, -3.4, ((1e-5, 0.0), (0.0, 0.1)), source="ruler"),),
        ),
        ("raw = [812, 3071], height = [20, 85]", (line_through([812, 3071], [20, 85]),)),
        ("raw = [812, 3071], value = [20, 85], se = 0.1", (line_through([812, 3071], [20, 85], 0.1),)),
        (
            "calibrations = [{ offset = -4.7, until = 2024-03-04 }, { offset = -4.1, from = 2024-03-05 }]",
            (Calibration(offset=-4.7, last_day="2024-03-04"), Calibration(offset=-4.1, first_day="2024-03-05")),
        ),
    ],
)
def test_a_profile_states_a_calibration(keys: str, expected: tuple[Calibration, ...]) -> None:
    assert in_profile(keys) == expected


@pytest.mark.parametrize(
    ("keys", "fact"),
    [
        ("scale = 0", "scale"),
        ("raw = [812], height = [20]", "two points"),
        ("raw = [812, 812], height = [20, 85]", "812"),
        ('raw = [812, 3071], height = [20, "x"]', "'x'"),
        ("raw = [812, 3071], height = [20, 85], offset = 1", "offset"),
        ("offset = 1, calibrations = [{ offset = 2 }]", "calibrations"),
        ('offset = 1, from = "soon"', "soon"),
        ("offset = 1, ofset_se = 1", "ofset_se"),
        ("height = [20, 85]", "raw"),
        ("offset = 1, se = 0.1", "raw"),
        ("scale = 2, scale_se = -1", "scale_se"),
        ("offset = 1, from = 2024-03-05, until = 2024-03-04", "until"),
    ],
)
def test_what_is_no_calibration_is_refused(keys: str, fact: str) -> None:
    with refuses(InputRefused, fact):
        in_profile(keys)


@pytest.mark.parametrize(
    ("text", "name", "calibration"),
    [
        ("adc_h=body_height:mm,scale=0.29,offset=-4.7,source=ruler", "adc_h", Calibration(0.29, -4.7, source="ruler")),
        ("h [cm]=body_height:cm,offset=-4.7", "h [cm]", Calibration(offset=-4.7)),
        ("a=b=body_height:cm,offset=-4.7", "a=b", Calibration(offset=-4.7)),
        ("h=own.pot:V,scale=2", "h", Calibration(2.0)),
        ("h=body_height:m,raw=812 3071,value=0.2 0.85,se=0.001", "h", line_through([812, 3071], [0.2, 0.85], 0.001)),
        ("h=body_height:m", "h", None),
    ],
)
def test_the_command_line_states_a_calibration(text: str, name: str, calibration: Calibration | None) -> None:
    declared = declarations(parse_configuration(BASE, "labbook.toml"), on_command_line(text))
    assert declared.columns[name].calibrations == (() if calibration is None else (calibration,))


def test_what_a_calibration_lacks_or_says_twice_is_refused() -> None:
    with refuses(InputRefused, "unit"):
        parse_configuration(BASE + PROFILE.replace('unit = "cm", ', "") % "offset = 1", "labbook.toml")
    for text, facts in (
        ("adc_h=body_height:counts", ["counts", "scale=SCALE", "raw="]),
        ("adc_h=body_height,scale=2", ["unit"]),
        ("adc_h=body_height:m,scale=2,scale=3", ["twice", "scale"]),
        ("adc_h=body_height:mm,scale=0.29,offset=-4.7,source=ruler, page 12", ["page 12"]),
    ):
        with refuses(UsageError, *facts):
            on_command_line(text)
