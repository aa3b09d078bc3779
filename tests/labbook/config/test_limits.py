"""Every bound on what a file may ask for is a key of `[files.limits]`."""

from __future__ import annotations

import dataclasses

import pytest

from data_schema.errors import InputRefused
from ingest.model import Limits
from labbook.config.model import LIMITS
from labbook.config.parsing import parse_configuration
from labbook.config.template import template


def test_every_limit_has_its_key() -> None:
    assert tuple(field.name for field in dataclasses.fields(Limits)) == LIMITS


def test_limits_are_set_by_name_and_unknown_ones_refused() -> None:
    text = template("study", "Ada Bee")
    configuration = parse_configuration(text + "\n[files.limits]\nmost_columns = 12\n", "labbook.toml")
    assert configuration.files.limits == {"most_columns": 12}
    with pytest.raises(InputRefused, match="most_colums"):
        parse_configuration(text + "\n[files.limits]\nmost_colums = 12\n", "labbook.toml")
