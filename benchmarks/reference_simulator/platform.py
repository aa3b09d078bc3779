"""The emulated ground (thesis 4.2): how the platform pushes back, and the ratchet that holds, releases and resets."""

from enum import StrEnum
from fractions import Fraction

from benchmarks.reference_simulator.fixed_point import FixedPoint
from benchmarks.reference_simulator.parameters import PlatformParameters
from benchmarks.reference_simulator.power_series import Series, SeriesTape


class Phase(StrEnum):
    """What the ratchet and the platform's motors are doing; rigid ground is in `RIGID` for ever."""

    HOLD = "hold"
    RELEASE = "release"
    RESET = "reset"
    ENGAGE = "engage"
    RIGID = "rigid"


_FOLLOWING = {Phase.RELEASE: Phase.RESET, Phase.RESET: Phase.ENGAGE, Phase.ENGAGE: Phase.HOLD}


class Platform:
    """A massless platform at `position` (metres below 0 are negative) with the clock of its state machine."""

    def __init__(self, parameters: PlatformParameters | None, number: FixedPoint) -> None:
        p = parameters or PlatformParameters()
        of = number.of
        self.number = number
        self.phase = Phase.RIGID if parameters is None else Phase.HOLD
        self.position = 0
        self.elapsed = 0
        self.stiffness, self.damping, self.lift = of(p.stiffness_n_m), of(p.damping_kg_s), of(p.lift_kg_m)
        self.travel, self.yield_margin = of(p.travel_m), of(p.yield_margin_n)
        self.release_length = of(p.release_length_m)
        self._reset_from = 0
        self._reset_rate = of(1 / p.reset_s)
        self._shortest_hold = of(p.shortest_hold_s)
        self._length: dict[Phase, Fraction] = {
            Phase.RELEASE: p.release_s,
            Phase.RESET: p.reset_s,
            Phase.ENGAGE: p.engage_s,
        }

    @property
    def time_left(self) -> int | None:
        """Time to the end of the phase, or to the end of the shortest hold; None where no clock runs."""
        if self.phase in _FOLLOWING:
            return self.number.of(self._length[self.phase]) - self.elapsed
        if self.phase is Phase.HOLD and self.elapsed < self._shortest_hold:
            return self._shortest_hold - self.elapsed
        return None

    @property
    def may_release(self) -> bool:
        """Whether the ratchet has held for as long as it must before a release."""
        return self.phase is Phase.HOLD and self.elapsed >= self._shortest_hold

    def enter(self, phase: Phase) -> None:
        """Begin a phase; the reset starts from where the platform is."""
        self.phase, self.elapsed = phase, 0
        if phase is Phase.RESET:
            self._reset_from = self.position

    def end_phase(self) -> None:
        """What happens when the clock of the phase runs out."""
        if self.phase is Phase.HOLD:
            self.elapsed = self._shortest_hold
            return
        if self.phase is Phase.RESET:
            self.position = 0
        self.enter(_FOLLOWING[self.phase])

    def path(self, tape: SeriesTape) -> tuple[Series, Series, Series]:
        """Position, velocity and acceleration of a platform that does not yield: it is reset, or it rests."""
        if self.phase is not Phase.RESET:
            return tape.constant(self.position), tape.constant(0), tape.constant(0)
        one, multiply = self.number.one, self.number.multiply
        share = tape.state(multiply(self.elapsed, self._reset_rate))
        tape.follow(share, tape.constant(self._reset_rate))
        square = tape.multiply(share, share)
        cube = tape.multiply(square, share)
        # 1 - 10 s^3 + 15 s^4 - 6 s^5 and its derivatives
        factor = tape.combine([(6 * one, square), (-15 * one, share)], 10 * one)
        start, rate = self._reset_from, self._reset_rate
        position = tape.combine([(-start, tape.multiply(cube, factor))], start)
        rest = tape.combine([(-one, share)], one)
        velocity = tape.combine([(-30 * multiply(start, rate), tape.multiply(square, tape.multiply(rest, rest)))])
        bend = tape.multiply(tape.multiply(share, rest), tape.combine([(-2 * one, share)], one))
        return position, velocity, tape.combine([(-60 * multiply(start, multiply(rate, rate)), bend)])

    def reaction(self, tape: SeriesTape, position: Series, velocity: Series) -> Series:
        """The force on the foot while the platform yields downward: -k x - alpha v + beta v^2."""
        squared = tape.multiply(velocity, velocity)
        return tape.combine([(-self.stiffness, position), (-self.damping, velocity), (self.lift, squared)])
