"""What a reference jump gives: decimal numbers with as many digits as were asked for."""

from dataclasses import dataclass, field
from decimal import Context, Decimal
from fractions import Fraction

from benchmarks.reference_simulator.power_series import State


@dataclass(frozen=True, slots=True)
class ModeChange:
    """The instant at which a jump enters a mode, counted from its touchdown."""

    time_s: Decimal
    mode: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceResult:
    """One jump; `None` stands where the outcome leaves a number undefined.

    Times count from touchdown and lift-off is the last one before the apex. Heat, mechanical work and drag are
    integrated from touchdown to lift-off on granular ground, and over the whole jump, to the next touchdown, where
    jumps follow each other. `cost_j` is heat plus mechanical work; `duration_s` ends at the apex, or at the next
    touchdown.
    """

    outcome: str
    duration_s: Decimal
    liftoff_time_s: Decimal | None
    liftoff_body_velocity_m_s: Decimal | None
    max_depth_m: Decimal
    apex_height_m: Decimal | None
    heat_j: Decimal
    mechanical_j: Decimal
    drag_j: Decimal
    cost_j: Decimal
    energy_residual_j: Decimal
    mode_changes: tuple[ModeChange, ...]


@dataclass
class JumpRecord:
    """What one jump has shown so far; `energy` is that at its touchdown."""

    energy: Fraction
    time: Fraction = Fraction(0)
    liftoff_time: Fraction | None = None
    liftoff: State | None = None
    apex: Fraction | None = None
    deepest: Fraction = Fraction(0)
    outcome: str | None = None
    changes: list[tuple[Fraction, str]] = field(default_factory=list)

    def enter(self, mode: str) -> None:
        """Note a change of mode now."""
        self.changes.append((self.time, mode))

    def lift_off(self, state: State) -> None:
        """Note a lift-off now; an apex seen before it does not count."""
        self.liftoff_time, self.liftoff, self.apex = self.time, dict(state), None

    def result(self, spent: State, residual: Fraction, digits: int) -> ReferenceResult:
        """The jump in decimals, with the costs of `spent` and what the energy book lacks."""

        def show(value: Fraction) -> Decimal:
            return Context(prec=digits).divide(Decimal(value.numerator), Decimal(value.denominator))

        return ReferenceResult(
            outcome=str(self.outcome),
            duration_s=show(self.time),
            liftoff_time_s=None if self.liftoff_time is None else show(self.liftoff_time),
            liftoff_body_velocity_m_s=None if self.liftoff is None else show(self.liftoff["v_b"]),
            max_depth_m=show(self.deepest),
            apex_height_m=None if self.apex is None else show(self.apex),
            heat_j=show(spent["heat"]),
            mechanical_j=show(spent["mechanical"]),
            drag_j=show(spent["drag"]),
            cost_j=show(spent["heat"] + spent["mechanical"]),
            energy_residual_j=show(residual),
            mode_changes=tuple(ModeChange(show(time), mode) for time, mode in self.changes),
        )
