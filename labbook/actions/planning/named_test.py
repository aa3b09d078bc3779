"""`labbook power --test`: how likely a test finds what is there, or how many values that needs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from data_schema.errors import UsageError, unknown_name
from stats.planning.power import Power, power_anova, power_equivalence, power_t, power_welch, sample_size
from stats.results import as_dict

ALPHA, USUAL_POWER = 0.05, 0.8
Given = Mapping[str, Any]
"""The options that were given, by name; those that may be repeated are lists."""


@dataclass(frozen=True, slots=True)
class _Test:
    """What a test needs and may have, and its power with so many values in the first and in the second group.

    `most` says how often an option may be given, once where it is not there; None: any number of times.
    """

    needs: tuple[str, ...]
    may_have: tuple[str, ...]
    plan: Callable[[Given, float, int, int], Power]
    most: Mapping[str, int | None]


def plan_test(name: str, given: Given) -> tuple[dict[str, Any], list[str]]:
    """Return the plan with the n given, or the smallest n that reaches the power: as data and in words."""
    if name not in _TESTS:
        raise unknown_name("test", name, _TESTS)
    test = _TESTS[name]
    if "--n" in given and "--power" in given:
        raise UsageError("--n asks for the power and --power for the n: give one of the two.")
    reads = (*test.needs, *test.may_have)
    idle = [option for option in given if option not in (*reads, "--n", "--power", "--alpha")]
    if idle:
        raise UsageError(
            f"--test {name} has no use for {' and '.join(idle)}: leave that out; it reads {', '.join(reads)}."
        )
    for option in test.needs:
        if option not in given:
            raise UsageError(f"this test needs {option}: add it, in the unit of the values.")
    for option, values in given.items():
        most = test.most.get(option, 1)
        if isinstance(values, list | tuple) and most is not None and len(values) > most:
            raise UsageError(f"{option} is given {len(values)} times: this test takes {most} at most.")
    alpha = given.get("--alpha", ALPHA)
    if "--n" in given:
        found = test.plan(given, alpha, given["--n"][0], given["--n"][-1])
        return {"plan": as_dict(found)}, [found.sentence()]
    smallest = sample_size(lambda n: test.plan(given, alpha, n, n), given.get("--power", USUAL_POWER))
    return smallest.to_dict(), [smallest.sentence()]


def _t(given: Given, alpha: float, a: int, b: int) -> Power:
    return power_t(given["--difference"], given["--sd"][0], a, b, alpha, 1 if "--one-sided" in given else 2)


def _welch(given: Given, alpha: float, a: int, b: int) -> Power:
    sds, sides = given["--sd"], 1 if "--one-sided" in given else 2
    return power_welch(given["--difference"], sds[0], sds[-1], a, b, alpha, sides)


def _anova(given: Given, alpha: float, n: int, _same: int) -> Power:
    return power_anova(given["--mean"], given["--sd"][0], n, alpha)


def _tost(given: Given, alpha: float, a: int, b: int) -> Power:
    mean = given["--mean"][0] if "--mean" in given else None
    if "--percent" in given and mean is None:
        raise UsageError("this test needs --mean: add it, for bounds in percent of the control's.")
    if mean is not None and "--percent" not in given:
        raise UsageError("--mean is the control's, for bounds in percent of it: add --percent, or leave it out.")
    low, high, difference = given["--low"], given["--high"], given.get("--difference", 0.0)
    return power_equivalence(given["--sd"][0], low, high, a, b, alpha, difference=difference, control_mean=mean)


_OF_T = ("--difference", "--sd")
_TESTS: Mapping[str, _Test] = {
    "t": _Test(_OF_T, ("--one-sided",), _t, {"--n": 2}),
    "welch": _Test(_OF_T, ("--one-sided",), _welch, {"--sd": 2, "--n": 2}),
    "anova": _Test(("--mean", "--sd"), (), _anova, {"--mean": None}),
    "tost": _Test(("--low", "--high", "--sd"), ("--difference", "--percent", "--mean"), _tost, {"--n": 2}),
}
