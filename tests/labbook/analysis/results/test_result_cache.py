"""What a report printed is compared with what is stored now, and asking for it loads nothing that computes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from labbook.analysis.algorithms import versions_now
from labbook.analysis.results.result_cache import equals_printed

HEAVY = ("numpy", "scipy", "pandas", "pyarrow", "statsmodels", "stats")


@pytest.mark.parametrize(
    ("printed", "value", "same"),
    [
        (None, None, True),
        (None, 0.0, False),
        (0.0, None, False),
        (0.15, 0.15 * (1 + 1e-12), True),
        (0.15, 0.15 * (1 + 1e-6), False),
        (0.0, 0.0, True),
        (0.0, 1e-12, False),
    ],
)
def test_values_agree_when_another_machine_could_have_added_in_another_order(
    printed: float | None, value: float | None, same: bool
) -> None:
    assert equals_printed(printed, value) is same


def test_a_rest_of_rounding_beside_its_error_is_the_same() -> None:
    """The mean deviation of a book's only pack is 0 but for rounding."""
    assert equals_printed(5.9e-16, -2.2e-16, 0.3)
    assert not equals_printed(5.9e-16, 0.01, 0.3)
    assert not equals_printed(5.9e-16, -2.2e-16)


def test_versions_are_told_of_results_and_of_detectors() -> None:
    assert {"run_energy", "run_apexes", "overall_savings"} <= set(versions_now())
    assert all(version >= 1 for version in versions_now().values())


def test_tracing_a_stored_number_loads_nothing_that_computes() -> None:
    code = "import sys, labbook.actions.upkeep.tracing, labbook.book.opening\n"
    code += f"print([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parents[4], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"
