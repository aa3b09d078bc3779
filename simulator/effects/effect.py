"""What an effect is: one piece of physics, declared as data, and the compiled functions it gives the kernel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, get_args

from simulator.compiled import Function
from simulator.parameter import Parameter

ParameterIndex = Callable[[str], int]
"""Where a parameter, declared or derived, of an effect that is on stands in the row that a kernel works in."""

Mode = Literal["jammed", "intruding", "flight", "creeping", "carried"]
MODES: tuple[Mode, ...] = get_args(Mode)
"""Contact modes. On the emulator *jammed* is the platform held by its ratchet, *intruding* the platform yielding."""


@dataclass(frozen=True, slots=True)
class Energy:
    """An energy that is summed over a jump, in joules: a state of the integration, and a column of results.

    `sign`: how the energy book counts it, as gained by body and foot (1) or lost (-1); 0 is a part of the cost, which
    the book does not know: its power is the effect's function `NAME_w(p, lever_m, leg_speed_m_s, force_n)`, and there
    is a column for the stance and one for the jump. `label` is its line in the table of `labbook sim run`. One that is
    `sudden` is lost at events alone, and needs no integration. A cost that is `singular` has a pole where the leg is
    straight, which it may be in flight: it counts there only where the cost is that of the whole jump.
    """

    name: str
    meaning: str
    sign: Literal[-1, 0, 1]
    label: str
    sudden: bool = False
    singular: bool = False

    @property
    def column(self) -> str:
        """Name of the output of an energy of the book."""
        return f"{self.name}_J"

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return (self.column,) if self.sign else (f"stance_{self.name}_J", f"jump_{self.name}_J")


@dataclass(frozen=True, slots=True)
class BodyForce:
    """A force on the body beside the leg's and its weight; forces of several effects are summed.

    The effect's function `body_force_n(p, height_m, velocity_m_s)` gives it in newtons, up positive. It acts in
    `modes`; in those of them where it `breaks_closed_form` motion is integrated: all, unless the force changes at
    events alone. `loss` is the energy that it takes from the body; its rate is minus force times velocity.

    One that `holds` is dry friction: the effect's `body_held(p)` says whether the body rests; `hold_guard(p, drive_n,
    velocity_m_s)` rises through zero when it stops or is pushed on, with `drive_n` the sum of all other forces; then
    `body_stops(p, drive_n)` decides; `body_moves(p, velocity_m_s)` says how the body starts.
    """

    loss: Energy
    modes: tuple[Mode, ...]
    breaks_closed_form: tuple[Mode, ...]
    holds: bool = False


@dataclass(frozen=True, slots=True)
class Guard:
    """An event of an effect: a step ends where a force has a kink or a jump.

    It happens where the effect's function `NAME_guard(p, body_height_m, body_velocity_m_s, foot_height_m,
    foot_velocity_m_s)`, smooth between events, rises through zero in one of the `modes`. There `NAME_happens` of the
    same arguments, if the effect gives it, changes numbers that the effect keeps in `derived`; it happens again once
    the guard has been negative. The instant is located to a share of a metre or a metre a second, so that a guard is
    best of that size. `expression` and `happens` say in the automaton's table what rises through zero, and what the
    event does.

    One `of_force` is where a cost has a kink: its function is `NAME_guard(p, lever_m, leg_speed_m_s, force_n)` of the
    force that the cost counts, and a step ends where it passes zero either way. Nothing else happens there.
    """

    name: str
    expression: str
    happens: str
    modes: tuple[Mode, ...]
    of_force: bool = False

    def __post_init__(self) -> None:
        """Refuse modes that are none."""
        if not self.modes or not set(self.modes) <= set(MODES):
            raise ValueError(f"the guard {self.name} is in the modes {self.modes!r}: let them be some of {MODES}.")


MOTION = (
    *("body_height", "body_velocity", "body_acceleration"),
    *("foot_height", "foot_velocity", "foot_acceleration", "leg_length"),
    *("leg_work", "mechanical_energy", "time", "mode", "jump"),
)
"""Names of the sampled motion, which no state may have."""


@dataclass(frozen=True, slots=True)
class State:
    """A number that an effect integrates beside the motion, as the stretch of a damper in series with a spring.

    The effect's function `NAME_rate(p, height_m, velocity_m_s, states)` is its rate, of the body's height and velocity
    and the tuple of the effect's states; `NAME_start(p, height_m, velocity_m_s)` is where a simulation starts, 0
    without it. From jump to jump it goes on. `typical` is the size that an error is a share of, in its `unit`.
    `body_force_n`, `NAME_guard` and `NAME_happens` of an effect with states get the tuple as their last argument.
    """

    name: str
    unit: str
    meaning: str
    typical: float

    def __post_init__(self) -> None:
        """Refuse a name of the sampled motion, and a size that is none."""
        if self.name in MOTION:
            raise ValueError(f"the state {self.name} has a name of the sampled motion: give it a name of its own.")
        if not self.typical > 0.0:
            raise ValueError(f"the typical size of {self.name} is {self.typical}: let it be above 0.")


def no_functions(at: ParameterIndex) -> dict[str, Function]:
    """Give the kernel nothing: the effect is a choice that another part reads."""
    return {}


@dataclass(frozen=True, slots=True)
class Effect:
    """One piece of physics.

    `needs`: alternatives, each a tuple of effects of which at least one must be on. `excludes`: effects that cannot be
    on together with it, each with the sentence that says why and what to change. `derived`: names of numbers that
    `functions(at)["prepare"]` computes from the parameters as a simulation starts, 0 otherwise, or that its functions
    keep from event to event.
    `functions` fills slots of the kernel: `Composition.slots` by name. `body_force` says of the function `body_force_n`
    when it acts; without it such a function is refused. `energies` are integrated, and those with a sign booked;
    `publishes`: other outputs it computes. All outputs read 0 while it is off. `lacks`: what it leaves out, though one
    might expect it. `guards` are events, `states` numbers that it integrates; while one with states is on, no motion
    has a closed form.
    """

    name: str
    meaning: str
    source: str
    parameters: tuple[Parameter, ...] = ()
    needs: tuple[tuple[str, ...], ...] = ()
    excludes: dict[str, str] = field(default_factory=dict)
    energies: tuple[Energy, ...] = ()
    publishes: tuple[str, ...] = ()
    lacks: str = ""
    derived: tuple[str, ...] = ()
    body_force: BodyForce | None = None
    guards: tuple[Guard, ...] = ()
    states: tuple[State, ...] = ()
    functions: Callable[[ParameterIndex], dict[str, Function]] = no_functions

    @property
    def all_energies(self) -> tuple[Energy, ...]:
        """Every energy it turns over."""
        return self.energies if self.body_force is None else (*self.energies, self.body_force.loss)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs it computes."""
        return (*self.publishes, *(column for energy in self.all_energies for column in energy.columns))
