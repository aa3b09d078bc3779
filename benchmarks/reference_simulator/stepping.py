"""One Taylor step of a hybrid system: until the series fail, the step ends, or the first guard rises above zero."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from benchmarks.reference_simulator.crossings import first_rise
from benchmarks.reference_simulator.leg import State
from benchmarks.reference_simulator.power_series import Series, SeriesTape, value_at


@dataclass(frozen=True, slots=True)
class Advance:
    """How far a step came: in time, what stopped it, and whether it came to its end."""

    elapsed: int
    fired: str | None
    complete: bool


def advance(
    tape: SeriesTape, state: State, moving: Mapping[str, Series], guards: Mapping[str, Series], step: int
) -> Advance:
    """Carry `state` forward along `moving` by at most `step`; of two guards at one instant the first named wins.

    A guard that is positive from the start on fires at once, with nothing elapsed.
    """
    bits = tape.bits
    one = 1 << bits
    reach = tape.run(step)
    moment = one if reach >= 1 else int(reach * 2**50) << (bits - 50)
    fired = None
    for name, guard in guards.items():
        rise = first_rise(guard, moment, bits)
        if rise is not None and (rise < moment or fired is None):
            moment, fired = rise, name
            if not rise:
                break
    if moment:
        for name, series in moving.items():
            state[name] = value_at(series, moment, bits) if moment != one else sum(series)
    return Advance((moment * step) >> bits, fired, fired is None and moment == one)


def setting(target: object, **values: object) -> Callable[[], None]:
    """An event that only changes attributes of `target`."""

    def event() -> None:
        for name, value in values.items():
            setattr(target, name, value)

    return event
