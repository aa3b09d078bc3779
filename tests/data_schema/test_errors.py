"""Which name is meant by one that does not exist."""

from __future__ import annotations

import pytest

from data_schema.errors import nearest

RUNS = ("r001", "r007", "r017", "r070", "r100", "LOG0007")


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("r7", "r007"),
        ("R07", "r007"),
        ("r0007", "r007"),
        ("r70", "r070"),
        ("r0100", "r100"),
        ("log7", "LOG0007"),
        ("unlike", None),
    ],
)
def test_the_zeros_of_a_number_make_no_other_name(given: str, meant: str | None) -> None:
    assert nearest(given, RUNS) == meant


def test_zeros_behind_a_decimal_sign_do() -> None:
    assert nearest("level 0.05", ("level 0.5", "level 0.005", "level 0.051")) != "level 0.5"
    assert nearest("1.5", ("01.5", "1.05")) == "01.5"


def test_of_two_names_with_the_same_number_neither_is_preferred_for_it() -> None:
    assert nearest("a-7", ("a-07", "a-007")) in ("a-07", "a-007")
