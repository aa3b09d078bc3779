"""Values from all of the range of doubles, and a walk through a result that no number outside it survives."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from data_schema.vocabulary import Undefined
from stats.results import names_of

LEAST, MOST = 5e-324, 1.7976931348623157e308
SIZES = st.integers(-1074, 1023)
"""Powers of two of all positive doubles."""
P = re.compile(r"(.*_)?p(_low|_high|_greater|_less)?")


@st.composite
def doubles(draw: st.DrawFn, exponents: st.SearchStrategy[int] = SIZES) -> float:
    """A double of any size, or 0, or the largest or least of all."""
    kind = draw(st.sampled_from(["any", "any", "any", "any", "zero", "most", "least"]))
    size = {"zero": 0.0, "most": MOST, "least": LEAST}.get(kind)
    if size is None:
        size = math.ldexp(draw(st.integers(1, 2**53 - 1)) / 2**53 + 1.0, draw(exponents) - 1) or LEAST
    return math.copysign(size, draw(st.sampled_from([1.0, 1.0, -1.0])))


@st.composite
def groups(draw: st.DrawFn, size: st.SearchStrategy[int] | None = None) -> list[float]:
    """A sample: of one order of magnitude, of all, about an offset, or all the same."""
    n = draw(st.integers(2, 6) if size is None else size)
    kind = draw(st.sampled_from(["one size", "all sizes", "two sizes", "offset", "constant"]))
    if kind == "constant":
        return [draw(doubles())] * n
    if kind == "offset":
        # Whole numbers of one last digit about the middle of 2^53 of them.
        unit, sign = draw(st.integers(-1074, 970)), draw(st.sampled_from([1.0, -1.0]))
        steps = draw(st.lists(st.integers(-4, 4), min_size=n, max_size=n))
        return [sign * math.ldexp(float(3 * 2**51 + step), unit) for step in steps]
    if kind == "all sizes":
        return draw(st.lists(doubles(), min_size=n, max_size=n))
    ends = [draw(SIZES) for _ in range(1 if kind == "one size" else 2)]
    return draw(st.lists(doubles(st.sampled_from(ends)), min_size=n, max_size=n))


@st.composite
def levels(draw: st.DrawFn) -> float:
    """A chance between 0 and 1, from the least double to the last one below 1."""
    kind = draw(st.sampled_from(["usual", "small", "small", "large"]))
    if kind == "usual":
        return draw(st.floats(0.001, 0.999))
    if kind == "large":
        return 1.0 - math.ldexp(1.0, -draw(st.integers(2, 53)))
    return math.ldexp(draw(st.integers(2**52, 2**53 - 1)) / 2**53, draw(st.integers(-1073, -1)))


def degrees_of_freedom() -> st.SearchStrategy[float]:
    """Degrees of freedom that a fit may state: any above 0, usual ones, whole ones, or infinitely many."""
    return st.one_of(
        doubles().map(lambda df: abs(df) or 1.0), st.floats(0.02, 1e3), st.integers(1, 99), st.just(math.inf)
    )


def positive(values: list[float]) -> list[float]:
    """The same sizes without signs, none of them 0."""
    return [abs(value) or 1.0 for value in values]


def numbers(value: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Every float of a result by its path: fields, computed properties, parts; each `Undefined` has a reason."""
    if isinstance(value, Undefined):
        assert value.reason, path
        assert not re.search(r"\bnan\b|\binf\b|not been computed", value.reason), f"{path}: {value.reason}"
    elif is_dataclass(value) and not isinstance(value, type):
        for name in names_of(type(value)):
            yield from numbers(getattr(value, name), f"{path}.{name}")
    elif isinstance(value, Mapping):
        for name, item in value.items():
            yield from numbers(item, f"{path}.{name}")
    elif isinstance(value, list | tuple | np.ndarray):
        for place, item in enumerate(value):
            yield from numbers(item, f"{path}[{place}]")
    elif isinstance(value, float | np.floating):
        yield path, float(value)


def assert_sound(result: Any) -> None:
    """Every number is finite or says why not, p lies between 0 and 1, JSON and the sentence can be written."""
    for path, number in numbers(result):
        assert math.isfinite(number), f"{path} = {number}"
        name = re.sub(r"\[\d+\]", "", path).rpartition(".")[2]
        if "log10" in name and P.fullmatch(name.replace("log10_", "")):
            assert number <= 0.0, path
        elif P.fullmatch(name):
            assert 0.0 <= number <= 1.0, path
    if hasattr(result, "to_json"):
        json.loads(result.to_json())
        result.to_frame()
        assert not re.search(r"\bnan\b|\binf\b", result.sentence())
