"""The root between two places: to the last digits, wherever it lies between them and however the function bends."""

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stats.exact.roots import root_between

BENDS: dict[str, Callable[[float], float]] = {
    "straight": lambda x: x,
    "cubic": lambda x: x**3,
    "flat at its root": lambda x: math.copysign(math.sqrt(abs(x)), x),
    "steps": lambda x: math.copysign(1.0, x),
    "infinite on one side": lambda x: math.inf if x > 0.25 else x,
}


@pytest.mark.parametrize("bend", BENDS)
@given(root=st.floats(0.05, 0.95), rising=st.booleans(), turned=st.booleans())
def test_the_root_is_found_to_the_last_digits(bend: str, root: float, rising: bool, turned: bool) -> None:
    def function(x: float) -> float:
        return BENDS[bend](x - root) * (1.0 if rising else -1.0)

    ends = [(place, function(place)) for place in ((1.0, 0.0) if turned else (0.0, 1.0))]
    # A cube below the smallest double is 0 over some width
    assert root_between(function, *ends) == pytest.approx(root, rel=1e-15, abs=1e-107 if bend == "cubic" else 0.0)


@given(st.integers(1, 300))
def test_a_root_many_decades_below_the_ends_keeps_its_digits(decades: int) -> None:
    root = 10.0**-decades
    found = root_between(lambda x: math.log(x / root) if x > 0.0 else -math.inf, (0.0, -math.inf), (1.0, 700.0), 5000)
    assert found == pytest.approx(root, rel=1e-14, abs=0.0)
