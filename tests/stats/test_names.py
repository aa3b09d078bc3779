"""Two groups are called by the names that the caller gives them, wherever something is undefined, refused or said."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from data_schema.errors import InputRefused
from stats.compare.equivalence import equivalence
from stats.compare.savings import percent_savings
from stats.compare.two_sample import compare_two
from stats.groups.variances import f_test
from stats.results import Result, as_dict
from tests.helpers.wording import refuses, says

NAMES = ("gain 400", "gain 0")
TESTS: dict[str, Callable[[Any, Any], Result]] = {
    "compare_two": lambda a, b: compare_two(a, b, names=NAMES),
    "f_test": lambda a, b: f_test(a, b, names=NAMES),
    "equivalence": lambda a, b: equivalence(a, b, low=-1.0, high=1.0, names=NAMES),
    "percent_savings": lambda a, b: percent_savings(a, b, names=NAMES),
}


def reasons(data: dict[str, Any]) -> list[str]:
    inner = [reason for value in data.values() if isinstance(value, dict) for reason in reasons(value)]
    return inner + [str(value) for name, value in data.items() if name.endswith("_reason")]


@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize(("a", "b", "named"), [([], [1.0, 2.0], 0), ([3.0], [1.0, 2.0], 0), ([1.0, 2.0], [3.0], 1)])
def test_reasons_name_the_group_that_is_too_small(test, a, b, named):
    said = [reason for reason in reasons(as_dict(TESTS[test](a, b))) if "group" in reason]
    assert said
    assert all(NAMES[named] in reason and NAMES[1 - named] not in reason for reason in said)


def test_a_constant_group_is_named():
    found = compare_two([1.0, 2.0], [3.0, 3.0], names=NAMES)
    says(found.f.reason, "0", "the ratio divides")
    says(found.sentence(), "400", "1.5", "n = 2", "minus gain", "3")
    says(equivalence([1.0, 2.0], [3.0, 4.0], low=-1.0, high=1.0, names=NAMES).sentence(), "400", "n = 2", "minus")
    assert f_test([1.0, 2.0], [3.0, 4.0], names=NAMES).groups == NAMES


@pytest.mark.parametrize("test", TESTS)
def test_refusals_name_the_group_and_the_way_out(test):
    with refuses(InputRefused, "gain", "0", "1", "2 values", 'or say missing="drop"'):
        TESTS[test]([1.0, 2.0], [float("nan"), 2.0])


def test_one_name_for_both_groups_is_refused():
    for test in (compare_two, percent_savings, lambda a, b, names: equivalence(a, b, low=-1.0, high=1.0, names=names)):
        with refuses(InputRefused, "groups are called", "'x'"):
            test([1.0, 2.0], [3.0, 5.0], names=("x", "x"))


def test_the_example_of_an_alpha_is_an_alpha():
    with refuses(InputRefused, "give a number", "1", "0.05"):
        compare_two([1.0, 2.0], [3.0, 5.0], alpha=5)
    with refuses(InputRefused, "give a number", "1", "0.95"):
        percent_savings([1.0, 2.0], [3.0, 5.0], level=95)


def test_savings_are_told_by_the_names_given():
    found = percent_savings([5.0, 5.2, 5.1], [4.0, 4.1, 4.2], names=("CE", "ad"))
    says(found.sentence(), "mean of ad", "19.6 %")
    says(found.sentence("no gain", "gain 50"), "mean of gain", "50", "19.6 %")
    unnamed = percent_savings([5.0, 5.2, 5.1], [4.0, 4.1, 4.2])
    says(unnamed.sentence(), "the treated runs", "19.6 %")
