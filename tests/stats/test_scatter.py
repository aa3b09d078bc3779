"""Neither an offset nor the size of the values costs digits; groups by name, and what are no samples."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pandas as pd
import pytest

import stats
from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.scatter import read_groups
from tests.helpers.wording import refuses

A, B, C = [3.0, 1.0, 4.0, 1.5], [1.0, 5.0, 9.0], [2.0, 6.0, 5.0, 3.5, 5.5]
Groups = list[Any]

STATISTICS: dict[str, Callable[[Groups], Sequence[Any]]] = {
    "Welch": lambda g: [getattr(stats.compare_two(g[0], g[1]), name) for name in ("t", "df", "p", "hedges_g")],
    "F": lambda g: [getattr(stats.compare_two(g[0], g[1], "f_then_t"), name) for name in ("f", "f_p")],
    "ANOVA": lambda g: [getattr(stats.one_way_anova(g), name) for name in ("f", "p", "eta_squared", "omega_squared")],
    "Welch's ANOVA": lambda g: [getattr(stats.welch_anova(g), name) for name in ("f", "p", "df_within")],
    "variances": lambda g: [stats.brown_forsythe(g).p],
    "pairs": lambda g: [pair.p for pair in stats.compare_all_pairs(g).pairs],
    "autocorrelation": lambda g: [stats.autocorrelation(g[2])],
    "line": lambda g: [stats.fit_linear(g[2], {"x": np.arange(5.0)}).p[1]],
}


@pytest.mark.parametrize("name", STATISTICS)
@pytest.mark.parametrize("offset", [2.0**20, -(2.0**40)], ids=["1e6", "-1e12"])
def test_an_offset_that_values_carry_exactly_changes_no_digit(name: str, offset: float) -> None:
    near = STATISTICS[name]([A, B, C])
    far = STATISTICS[name]([np.array(values) + offset for values in (A, B, C)])
    assert far == pytest.approx(near, rel=1e-9)


@pytest.mark.parametrize("name", STATISTICS)
@pytest.mark.parametrize("size", [2.0**-996, 2.0**1010], ids=["1e-300", "1e304"])
def test_the_unit_changes_no_digit(name: str, size: float) -> None:
    near = STATISTICS[name]([A, B, C])
    far = STATISTICS[name]([size * np.array(values) for values in (A, B, C)])
    assert far == pytest.approx(near, rel=1e-12)


def test_means_and_differences_come_back_in_the_unit_of_the_values() -> None:
    read = read_groups({"a": [1e15 + 0.125, 1e15, 1e15], "b": [1e15, 1e15, 1e15 + 0.25]})
    assert read.means == pytest.approx((1e15, 1e15))
    a, b = read.filled
    assert read.scale.length(a.mean - b.mean) == pytest.approx(-0.125 / 3.0, rel=1e-12)
    assert (read.names, read.sizes, read.df_within) == (("a", "b"), (3, 3), 4)
    huge = stats.compare_two([1.7e308, 1.6e308, 1.5e308], [-1.7e308, -1.6e308, -1.5e308])
    assert isinstance(huge.difference, Undefined)
    assert isinstance(huge.t, float)
    tiny = stats.describe([5e-324, 1.5e-323, 1e-323])
    assert (tiny.mean, tiny.sd) == (1e-323, 5e-324)


TABLE = pd.DataFrame({"gain": [400, 400, 0, 0], "joules": [1.0, 2.0, 4.0, 7.0]})


@pytest.mark.parametrize(
    ("groups", "names"),
    [
        (dict(iter(TABLE.groupby("gain")["joules"])), ("0", "400")),
        ([(1.0, 2.0), (3.0, 4.0)], ("1", "2")),
        (pd.DataFrame({"CE": [1.0], "AD": [3.0]}), ("CE", "AD")),
    ],
)
def test_groups_come_by_name_or_in_a_list(groups: Any, names: tuple[str, ...]) -> None:
    assert read_groups(groups).names == names


def test_groups_that_are_no_samples_are_refused() -> None:
    for none in ([], "12", 5.0, [1.0, 2.0]):
        with refuses(InputRefused, "no samples"):
            read_groups(none)  # type: ignore[arg-type]
    with pytest.raises(InputRefused, match="group 'b'"):
        read_groups({"a": [1.0], "b": [float("nan")]})
    assert read_groups({"a": [1.0, 2.0], "b": [float("nan"), 3.0]}, "drop").missing == 1
