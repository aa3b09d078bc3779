"""What all grounds have in common: one leg, its body and its motors (thesis Eq. 3.1, 3.2, 3.5), and a jump's record."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from benchmarks.reference_simulator.power_series import Series, State, Tape
from benchmarks.reference_simulator.result import JumpRecord

GRAVITY = Fraction("9.81")
# The motors' three terms and the work of the leg on the masses, integrated along a jump for every ground.
LEG_INTEGRALS = ("heat", "mechanical", "drag", "leg_work")

Guards = dict[str, Series]


class Gains(NamedTuple):
    """Stiffness and damping in force; `active` is the coefficient of |v_f| for a damping that follows the foot."""

    stiffness: Fraction
    damping: Fraction
    active: Fraction = Fraction(0)


@dataclass(frozen=True, slots=True)
class LegSeries:
    """The leg's quantities on a tape; `cap` is None where nothing limits the force."""

    body_velocity: Series
    foot_velocity: Series
    foot_position: Series
    length: Series
    rate: Series
    commanded: Series
    applied: Series
    cap: Series | None
    states: dict[str, Series]


class Walk:
    """A jump's walk through its modes: the state, the record, and the leg's equations and guards.

    Effects and parameters have the names of the simulator's scenes, in SI units.
    """

    integrals: tuple[str, ...]
    record: JumpRecord
    mode: str

    def __init__(self, effects: frozenset[str], parameters: Mapping[str, Fraction], bits: int, order: int) -> None:
        self.effects, self.p, self.bits, self.order = effects, parameters, bits, order
        self.state: State = {"x_b": parameters["rest_length"], **dict.fromkeys(("v_b", "x_f", "v_f"), Fraction(0))}
        self.saturation = 0
        """The sign of the force where it exceeds the cap, else 0."""

    def begin(self) -> None:
        """Begin the record of a jump in the state as it is."""
        self.state |= dict.fromkeys((*LEG_INTEGRALS, *self.integrals), Fraction(0))
        self.record = JumpRecord(self.energy())

    def enter(self, mode: str) -> None:
        """Go on in another mode."""
        self.mode = mode
        self.record.enter(mode)

    def energy(self) -> Fraction:
        """Kinetic and potential energy of body and foot; the leg's spring is virtual and holds none."""
        state = self.state
        of_body = self.p["body_mass"] * (state["v_b"] ** 2 / 2 + GRAVITY * state["x_b"])
        return of_body + self.p["foot_mass"] * (state["v_f"] ** 2 / 2 + GRAVITY * state["x_f"])

    def leg(
        self,
        tape: Tape,
        gains: Gains,
        *,
        fixed_foot: bool = False,
        foot: tuple[Series, Series] | None = None,
        motors: bool = True,
    ) -> LegSeries:
        """Body, leg and motors from the state on; the caller writes the foot's acceleration.

        A `fixed_foot` stands still; `foot` gives position and velocity of one whose motion is prescribed. Without
        `motors` no cost is integrated and no cap applied: beyond the straight leg there is none.
        """
        p, state = self.p, self.state
        x_b, v_b = tape.series(state["x_b"]), tape.series(state["v_b"])
        x_f, v_f = foot or (tape.series(state["x_f"]), tape.series(state["v_f"]))
        length, rate = x_b - x_f, v_b - v_f
        commanded = gains.stiffness * (length - p["rest_length"]) + gains.damping * rate
        if gains.active:
            commanded = commanded - gains.active * (rate * v_f)
        states = {"x_b": x_b, "v_b": v_b, "x_f": x_f, "v_f": v_f}
        applied, cap = commanded, None
        if motors:
            squared, difference = length * length, p["lower_link"] ** 2 - p["upper_link"] ** 2
            over, under = squared + difference, squared - difference
            # (2 l1 r^2)^2 (1 - u^2) without its square root: J^2 = over^2 / span.
            span = squared * (4 * p["upper_link"] ** 2 * squared - under * under)
            jacobian_squared = over * over / span
            if self.effects & {"torque_cap", "cost_torque_cap"}:
                cap = 2 * p["stall_torque"] * (over / span.root())
            elif "constant_force_cap" in self.effects:
                cap = tape.series(p["force_cap"])
            held = self.saturation * cap if self.saturation and cap is not None else commanded
            applied = commanded if "cost_torque_cap" in self.effects else held
            paid = commanded if "cost_of_commanded_force" in self.effects else held
            constant, resistance = p["torque_constant"], p["motor_resistance"]
            powers = {
                "heat": resistance / (2 * constant**2) * (paid * paid / jacobian_squared),
                "mechanical": -(paid * rate),
                "drag": constant**2 / resistance * (jacobian_squared * (rate * rate)),
            }
            states |= {name: tape.integral(state[name], power) for name, power in powers.items()}
        states["leg_work"] = tape.integral(state["leg_work"], -(applied * rate))
        tape.follow(x_b, v_b)
        tape.follow(v_b, -(1 / p["body_mass"] * applied) - GRAVITY)
        if foot is None and not fixed_foot:
            tape.follow(x_f, v_f)
        return LegSeries(v_b, v_f, x_f, length, rate, commanded, applied, cap, states)

    def free_foot(self, tape: Tape, leg: LegSeries) -> None:
        """Nothing but the leg and its weight moves the foot."""
        tape.follow(leg.foot_velocity, 1 / self.p["foot_mass"] * leg.applied - GRAVITY)

    def saturation_guards(self, leg: LegSeries) -> Guards:
        """`over` and `under` where the commanded force leaves the cap, `within` where it comes back."""
        if leg.cap is None:
            return {}
        if self.saturation:
            return {"within": leg.cap - self.saturation * leg.commanded}
        return {"over": leg.commanded - leg.cap, "under": -leg.commanded - leg.cap}

    def sets(self, **values: object) -> Callable[[], None]:
        """An event that only changes what is known."""
        return partial(vars(self).update, values)

    def ends(self, outcome: str) -> Callable[[], None]:
        """An event that ends the jump so."""
        return partial(setattr, self.record, "outcome", outcome)

    def events(self) -> dict[str, Callable[[], None]]:
        """What guards do on every ground."""
        found = {name: self.sets(saturation=sign) for name, sign in (("over", 1), ("under", -1), ("within", 0))}
        return {**found, "straight": self.ends("leg_straight"), "folded": self.ends("leg_folded")}
