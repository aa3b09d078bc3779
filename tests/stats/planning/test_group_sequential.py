"""Boundaries of group-sequential designs and the errors of unplanned looks, against published numbers and a walk."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import special, stats

from data_schema.errors import InputRefused
from labbook.analysis.preregistration.looks import look_at
from stats.planning.group_sequential import nominal_levels, share_in_error
from tests.helpers.wording import refuses

EQUAL = [0.2, 0.4, 0.6, 0.8, 1.0]


def z_of(levels: tuple[float, ...], sides: int = 2) -> list[float]:
    return [-float(special.ndtri(level / sides)) for level in levels]


def test_boundaries_are_those_published() -> None:
    """Of five equal looks by the program of Reboussin, DeMets, Kim and Lan, with .025 on each side."""
    published = [4.877, 3.357, 2.680, 2.290, 2.031]
    assert z_of(nominal_levels(EQUAL)) == pytest.approx(published, abs=5e-4)
    assert z_of(nominal_levels(EQUAL, 0.025, one_sided=True), 1) == pytest.approx(published, abs=5e-4)


@pytest.mark.parametrize(("looks", "share"), [(1, 0.05), (2, 0.083), (3, 0.107), (5, 0.142), (10, 0.193), (20, 0.248)])
def test_unplanned_looks_err_as_published(looks: int, share: float) -> None:
    """Armitage, McPherson and Rowe 1969, of a known variance."""
    assert share_in_error(range(1, looks + 1), [0.05] * looks) == pytest.approx(share, abs=5e-4)


@pytest.mark.parametrize("information", [[0.5, 1.0], [0.13, 0.14, 0.7, 1.0], [1e-3, 0.5, 0.9999, 1.0], list(EQUAL)])
@pytest.mark.parametrize("one_sided", [False, True])
def test_all_looks_together_err_in_alpha(information: list[float], one_sided: bool) -> None:
    levels = nominal_levels(information, 0.05, one_sided=one_sided)
    assert share_in_error(information, levels, one_sided=one_sided) == pytest.approx(0.05, abs=1e-7)


@pytest.mark.parametrize("sides", [1, 2])
def test_the_integral_over_looks_is_that_of_the_multivariate_normal_distribution(sides: int) -> None:
    information, levels = np.array([0.3, 0.37, 0.9, 1.0]), [0.02, 0.05, 0.04, 0.05]
    correlation = np.sqrt(np.minimum.outer(information, information) / np.maximum.outer(information, information))
    z = [-special.ndtri(level / sides) for level in levels]
    low = [-np.inf] * 4 if sides == 1 else [-each for each in z]
    inside = stats.multivariate_normal.cdf(z, cov=correlation, lower_limit=low, abseps=1e-7, maxpts=400_000)
    share = share_in_error(list(information), levels, one_sided=sides == 1)
    assert share == pytest.approx(1.0 - inside, abs=1e-6)


def test_the_last_planned_look_spends_the_rest_and_further_ones_keep_its_level() -> None:
    looks = [look_at([10, 20, 38, 44][:number], planned=3, runs_planned=40) for number in (1, 2, 3, 4)]
    exact = nominal_levels([10, 20, 38], spending=[0.25, 0.5, 1.0])
    assert all(0.99 * level <= look.level <= level for look, level in zip(looks, exact, strict=False))
    assert looks[3].level == looks[2].level
    assert [look.unplanned for look in looks] == [False, False, False, True]
    assert looks[2].share_in_error == pytest.approx(0.05, abs=0.001)
    assert looks[3].share_in_error > looks[2].share_in_error
    assert look_at([12]).level == 0.05


def test_more_runs_than_planned_keep_alpha_at_the_last_look_and_a_look_after_all_of_them_is_none_of_the_plan() -> None:
    more = look_at([50, 110], planned=2, runs_planned=100)
    assert not more.unplanned
    assert 0.99 * 0.05 <= more.share_in_error <= 0.05
    after = look_at([100, 200], planned=2, runs_planned=100)
    assert after.unplanned
    assert after.share_in_error == pytest.approx(0.0831, abs=1e-4)  # two looks at .05 (Armitage and others 1969)


def test_parts_that_are_none_are_refused() -> None:
    with refuses(InputRefused, "0.5", "1.2"):
        nominal_levels([0.5, 1.2])
