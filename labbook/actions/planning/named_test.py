"""`labbook power --test`: how likely a test finds what is there, or how many values that needs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from data_schema.errors import UsageError, unknown_name
from data_schema.vocabulary import Undefined
from labbook.presenting.stats.fields import field_lines
from stats.planning.power import Power, power_anova, power_equivalence, power_t, power_welch, sample_size
from stats.planning.power_percent import power_percent_equivalence
from stats.results import as_dict

ALPHA, USUAL_POWER = 0.05, 0.8


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


def plan_test(request: NamedTest) -> tuple[dict[str, Any], list[str], list[str]]:
    """Return the plan with the n given, or the smallest n that reaches the power: as data, in words, field by field."""
    if request.test not in _TESTS:
        raise unknown_name("test", request.test, _TESTS)
    if request.n and request.power is not None:
        raise UsageError("--n asks for the power and --power for the n: give one of the two.")
    _refuse_idle(request)
    plan = _TESTS[request.test](request, ALPHA if request.alpha is None else request.alpha)
    if request.n:
        _at_most("--n", request.n, 1 if request.test == "anova" else 2)
        found = plan(request.n[0], request.n[-1])
        return {"plan": as_dict(found)}, [found.sentence()], field_lines(found)
    smallest = sample_size(lambda n: plan(n, n), USUAL_POWER if request.power is None else request.power)
    fields = [] if isinstance(smallest.plan, Undefined) else field_lines(smallest.plan)
    return smallest.to_dict(), [smallest.sentence()], fields


def _t(request: NamedTest, alpha: float) -> Plan:
    difference = _one("--difference", request.difference)
    _at_most("--sd", request.sd, 1)
    sd, sides = _some("--sd", request.sd)[0], 1 if request.one_sided else 2
    return lambda a, b: power_t(difference, sd, a, b, alpha, sides)


def _welch(request: NamedTest, alpha: float) -> Plan:
    difference = _one("--difference", request.difference)
    _at_most("--sd", request.sd, 2)
    sds, sides = _some("--sd", request.sd), 1 if request.one_sided else 2
    return lambda a, b: power_welch(difference, sds[0], sds[-1], a, b, alpha, sides)


def _anova(request: NamedTest, alpha: float) -> Plan:
    _at_most("--sd", request.sd, 1)
    means, sd = _some("--mean", request.mean), _some("--sd", request.sd)[0]
    return lambda n, _same: power_anova(means, sd, n, alpha)


def _tost(request: NamedTest, alpha: float) -> Plan:
    _at_most("--sd", request.sd, 1)
    low, high = _one("--low", request.low), _one("--high", request.high)
    difference, sd = request.difference or 0.0, _some("--sd", request.sd)[0]
    if request.percent:
        _at_most("--mean", request.mean, 1)
        mean = _some("--mean", request.mean)[0]
        return lambda a, b: power_percent_equivalence(difference, mean, sd, low, high, a, b, alpha)
    if request.mean:
        raise UsageError("--mean is the control's, for bounds in percent of it: add --percent, or leave it out.")
    return lambda a, b: power_equivalence(difference, sd, low, high, a, b, alpha)


_TESTS: Mapping[str, Callable[[NamedTest, float], Plan]] = {"t": _t, "welch": _welch, "anova": _anova, "tost": _tost}
_READ = {
    "t": ("--difference", "--one-sided"),
    "welch": ("--difference", "--one-sided"),
    "anova": ("--mean",),
    "tost": ("--difference", "--low", "--high", "--percent", "--mean"),
}
"""Options that belong to some tests only."""


def _refuse_idle(request: NamedTest) -> None:
    """Raise `UsageError` for an option that the test has no use for."""
    given = {
        "--difference": request.difference is not None,
        "--mean": bool(request.mean),
        "--low": request.low is not None,
        "--high": request.high is not None,
        "--one-sided": request.one_sided,
        "--percent": request.percent,
    }
    idle = [option for option, is_given in given.items() if is_given and option not in _READ[request.test]]
    if idle:
        raise UsageError(
            f"--test {request.test} has no use for {' and '.join(idle)}: leave that out; it reads "
            f"{', '.join((*_READ[request.test], '--sd'))}."
        )


def _one(option: str, value: float | None) -> float:
    if value is None:
        raise UsageError(f"this test needs {option}: add it, in the unit of --sd.")
    return value


def _some(option: str, values: Sequence[float]) -> Sequence[float]:
    if not values:
        raise UsageError(f"this test needs {option}: add it, in the unit of the values.")
    return values


def _at_most(option: str, values: Sequence[float], most: int) -> None:
    if len(values) > most:
        raise UsageError(f"{option} is given {len(values)} times: this test takes {most} at most.")
