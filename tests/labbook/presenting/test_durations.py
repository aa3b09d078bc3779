from __future__ import annotations

import pytest

from labbook.presenting.durations import time_text


@pytest.mark.parametrize(
    ("seconds", "text"), [(2.0, "2 s"), (0.0123, "12.3 ms"), (65.4e-6, "65.4 µs"), (1e-7, "0.1 µs")]
)
def test_times_with_the_unit_that_suits_them(seconds: float, text: str) -> None:
    assert time_text(seconds) == text
