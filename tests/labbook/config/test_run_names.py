"""One scheme says what runs are called: plans name by it, and the names of files are recognised by it."""

from __future__ import annotations

import pytest

from labbook.config.run_names import RunNames


@pytest.mark.parametrize(
    ("scheme", "names"),
    [
        ("r{:03d}", {1: "r001", 47: "r047", 999: "r999", 1000: "r1000"}),
        ("LOG{:04d}", {47: "LOG0047", 12345: "LOG12345"}),
        ("trial {}", {3: "trial 3", 12: "trial 12"}),
        ("2024-{:02d}_hop", {7: "2024-07_hop"}),
    ],
)
def test_a_number_makes_a_name_and_the_name_says_the_number(scheme: str, names: dict[int, str]) -> None:
    for number, name in names.items():
        assert RunNames(scheme).name(number) == name
        assert RunNames(scheme).number(name) == number


@pytest.mark.parametrize("name", ["r1", "r0047", "r047b", "R047", "LOG0047", "", "r-47"])
def test_a_name_of_another_form_has_no_number(name: str) -> None:
    assert RunNames().number(name) is None


@pytest.mark.parametrize(
    ("scheme", "file", "known", "run"),
    [
        ("r{:03d}", "r020_synthetic.csv", (), "r020"),
        ("r{:03d}", "2024-03-04_plate_r020.txt", (), "r020"),
        ("r{:03d}", "r020b.csv", ("r020",), None),
        ("r{:03d}", "r020b.csv", ("r020", "r020b"), "r020b"),
        ("r{:03d}", "motor020.csv", (), None),  # the end of another word
        ("r{:03d}", "r001-r006.csv", ("r001",), None),  # several
        ("LOG{:04d}", "LOG0047.TXT", (), "LOG0047"),
        ("LOG{:04d}", "LOG00047.TXT", (), None),
        ("{:03d}", "012_1200Hz.csv", ("012",), "012"),
        ("r{:03d}", "hop-a-7 plate.csv", ("hop-a", "hop-a-7", "hop"), "hop-a-7"),
        ("r{:03d}", "hop-a-75.csv", ("hop-a-7",), None),
    ],
)
def test_a_file_states_the_run_that_its_name_holds(
    scheme: str, file: str, known: tuple[str, ...], run: str | None
) -> None:
    assert RunNames(scheme).stated_in(file, known) == run
