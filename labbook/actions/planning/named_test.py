"""`labbook power --test`: how likely a test finds what is there, or how many values that needs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from data_schema.errors import UsageError, unknown_name
from stats.planning.power import Power, power_anova, power_equivalence, power_t, power_welch, sample_size
from stats.results import as_dict

ALPHA, USUAL_POWER = 0.05, 0.8
_Number = TypeVar("_Number", int, float)


@dataclass(frozen=True, slots=True)
class NamedTest:
    """The test and what is assumed to be true; `n` for the power of so many values, else `power` for the n it needs."""

    test: str
    difference: float | None = None
    sd: tuple[float, ...] = ()
    mean: tuple[float, ...] = ()
    low: float | None = None
    high: float | None = None
    n: tuple[int, ...] = ()
    power: float | None = None
    alpha: float | None = None
    one_sided: bool = False
    percent: bool = False


Plan = Callable[[int, int], Power]
"""The power of so many values in the first and in the second group."""


def plan_test(request: NamedTest) -> tuple[dict[str, Any], list[str]]:
    """Return the plan with the n given, or the smallest n that reaches the power: as data and in words."""
    if request.test not in _TESTS:
        raise unknown_name("test", request.test, _TESTS)
    if request.n and request.power is not None:
        raise UsageError("--n asks for the power and --power for the n: give one of the two.")
    plan_for, read = _TESTS[request.test]
    _refuse_idle(request, read)
    plan = plan_for(request, ALPHA if request.alpha is None else request.alpha)
    if request.n:
        sizes = _some("--n", request.n, 1 if request.test == "anova" else 2)
        found = plan(sizes[0], sizes[-1])
        return {"plan": as_dict(found)}, [found.sentence()]
    smallest = sample_size(lambda n: plan(n, n), USUAL_POWER if request.power is None else request.power)
    return smallest.to_dict(), [smallest.sentence()]


def _t(request: NamedTest, alpha: float) -> Plan:
    difference, sides = _one("--difference", request.difference), 1 if request.one_sided else 2
    if request.test == "t":
        (sd,) = _some("--sd", request.sd, 1)
        return lambda a, b: power_t(difference, sd, a, b, alpha, sides)
    sds = _some("--sd", request.sd, 2)
    return lambda a, b: power_welch(difference, sds[0], sds[-1], a, b, alpha, sides)


def _anova(request: NamedTest, alpha: float) -> Plan:
    means, (sd,) = _some("--mean", request.mean), _some("--sd", request.sd, 1)
    return lambda n, _same: power_anova(means, sd, n, alpha)


def _tost(request: NamedTest, alpha: float) -> Plan:
    low, high = _one("--low", request.low), _one("--high", request.high)
    difference, (sd,) = request.difference or 0.0, _some("--sd", request.sd, 1)
    mean: float | None = None
    if request.percent:
        (mean,) = _some("--mean", request.mean, 1)
    elif request.mean:
        raise UsageError("--mean is the control's, for bounds in percent of it: add --percent, or leave it out.")
    return lambda a, b: power_equivalence(sd, low, high, a, b, alpha, difference=difference, control_mean=mean)


_TESTS: Mapping[str, tuple[Callable[[NamedTest, float], Plan], tuple[str, ...]]] = {
    "t": (_t, ("--difference", "--one-sided")),
    "welch": (_t, ("--difference", "--one-sided")),
    "anova": (_anova, ("--mean",)),
    "tost": (_tost, ("--difference", "--low", "--high", "--percent", "--mean")),
}
"""How each test is planned, and the options that it reads and some other test does not."""


def _refuse_idle(request: NamedTest, read: tuple[str, ...]) -> None:
    """Raise `UsageError` for an option that the test has no use for."""
    given = {
        "--difference": request.difference is not None,
        "--mean": bool(request.mean),
        "--low": request.low is not None,
        "--high": request.high is not None,
        "--one-sided": request.one_sided,
        "--percent": request.percent,
    }
    idle = [option for option, is_given in given.items() if is_given and option not in read]
    if idle:
        raise UsageError(
            f"--test {request.test} has no use for {' and '.join(idle)}: leave that out; it reads "
            f"{', '.join((*read, '--sd'))}."
        )


def _one(option: str, value: float | None) -> float:
    if value is None:
        raise UsageError(f"this test needs {option}: add it, in the unit of --sd.")
    return value


def _some(option: str, values: tuple[_Number, ...], most: int | None = None) -> tuple[_Number, ...]:
    if not values:
        raise UsageError(f"this test needs {option}: add it, in the unit of the values.")
    if most is not None and len(values) > most:
        raise UsageError(f"{option} is given {len(values)} times: this test takes {most} at most.")
    return values
