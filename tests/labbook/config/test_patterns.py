"""A pattern for a run's name ends in bounded time on any name, or is refused when it is written."""

from __future__ import annotations

import dataclasses

import pytest

from data_schema.errors import InputRefused
from ingest.model import Limits
from labbook.config.model import LIMITS
from labbook.config.parsing import parse_configuration
from labbook.config.patterns import MOST_LETTERS, pattern_fault
from labbook.config.template import template

USUAL = [
    r"^(?P<run>r\d+)",
    r"(?i)(?P<run>run[_-]?\d{1,4})",
    r"^\d{4}-\d\d-\d\d_(?P<run>[a-z]+\d+)(?:_part\d)?\.(?:csv|txt)$",
    r"^(?P<run>(?:day\d+_)?r\d+)_.*\.csv$",
    r"(?P<run>\w+)[ (].*",
    r"^(\d+)_(\d+)_(\d+)_(\d+)_(?P<run>r\d+)",
    r"(?P<run>[a-z]+_?\d+)(?:log|raw)?.*\.(?:csv|txt|dat)$",
    r"^\d{8}[-_]\d{6}[-_](?P<run>r\d{3})(?:_[a-z]+)?(?:_v\d)?\.csv(?:\.gz)?$",
    r"^(?:\w+ )?(?P<run>(?:[a-z]+-)+\d+)",
    rf"(?P<run>{'|'.join(f'r{number:03}' for number in range(30))})\.csv",
    "|".join(["(?P<run>r1)", *(f"r{number}" for number in range(2, 40))]),
]
ENDLESS = [
    r"(?P<run>(\d+)*x)",
    r"(?P<run>(a|a)*)b",
    r"^(?P<run>(?:\w+\s?)+)$",
    r"(?P<run>([a-z]*)*)!",
    r"(?P<run>(?:x+x+)+y)",
    r"(?P<run>.*.*.*.*.*.*.*x)",
    r"(?P<run>((ab)?)*c)",
    r"(?P<run>a*a*a*a*a*b)",
    rf"(?P<run>{'a' * MOST_LETTERS})",
    r"(?P<run>(a{1,20}){1,20})b",
    rf"(?P<run>{'a?' * 30}{'a' * 30}b)",
    rf"(?P<run>{'(a*)' * 8})b",
    rf"(?P<run>{'(a|a)' * 30})b",
    r"(?P<run>a)(?:\w{1,20}){15}!",
    r"(?i)(?P<run>a)([a-z]+A)+!",
    r"(?P<run>a)(\w+\b\w?)+!",
    rf"(?P<run>{'(a|a|a|a|a|a|a|a)' * 10})b",
    r"(?P<run>(?:a+|b)+)c",
    r"(?x)(?P<run>a* a* a* a* a* b)",
]


@pytest.mark.parametrize("pattern", USUAL)
def test_usual_patterns_are_taken(pattern: str) -> None:
    assert pattern_fault(pattern, in_force=False) is None


@pytest.mark.parametrize("pattern", ENDLESS)
def test_patterns_that_may_not_end_are_refused_unless_they_are_in_force(pattern: str) -> None:
    fault = pattern_fault(pattern, in_force=False)
    assert fault is not None
    assert "\n" not in fault
    assert pattern_fault(pattern, in_force=True) is None


def test_every_limit_has_its_key() -> None:
    assert tuple(field.name for field in dataclasses.fields(Limits)) == LIMITS


def test_limits_are_set_by_name_and_unknown_ones_refused() -> None:
    text = template("study", "Ada Bee")
    configuration = parse_configuration(text + "\n[files.limits]\nmost_columns = 12\n", "labbook.toml")
    assert configuration.files.limits == {"most_columns": 12}
    with pytest.raises(InputRefused, match="most_colums"):
        parse_configuration(text + "\n[files.limits]\nmost_colums = 12\n", "labbook.toml")
