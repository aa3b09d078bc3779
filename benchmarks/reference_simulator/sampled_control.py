"""The controller under a 1 kHz clock (thesis 3.1.3, 5.1.1): each tick sets phase, stiffness and damping, then held."""

from benchmarks.reference_simulator.fixed_point import FixedPoint
from benchmarks.reference_simulator.leg import Gains, State
from benchmarks.reference_simulator.parameters import FlightGains, GranularParameters, SwitchingRule


class SampledController:
    """Gains in force and the tick they were set at; tick 0 is touchdown."""

    def __init__(self, parameters: GranularParameters, number: FixedPoint) -> None:
        p, of = parameters, number.of
        self._parameters, self._number = parameters, number
        self._soft = Gains(of(p.compression_stiffness_n_m), of(p.compression_damping_kg_s))
        self.gains = self._soft
        self._extending = False
        self._tick = 0

    @property
    def next_tick_time(self) -> int:
        """When the gains may change next."""
        return self._number.of((self._tick + 1) * self._parameters.tick_s)

    def tick(self, state: State) -> None:
        """Let the next tick pass in `state`."""
        self._tick += 1
        self.sample(state)

    def pass_until(self, time: int) -> None:
        """Let the ticks up to `time` pass without effect: the foot was in the air."""
        while self.next_tick_time <= time:
            self._tick += 1

    def lift_off(self) -> None:
        """The gains of flight, from the instant of lift-off."""
        if self._parameters.flight_gains is FlightGains.SOFT:
            self._extending, self.gains = False, self._soft

    def sample(self, state: State) -> None:
        """Set the gains by the state as it is now."""
        p, of = self._parameters, self._number.of
        length, rate = state["x_b"] - state["x_f"], state["v_b"] - state["v_f"]
        if p.switching_rule is SwitchingRule.UNLATCHED:
            pushing_off = rate > 0 and state["x_f"] < 0 and state["v_b"] > 0
            self._extending = pushing_off or length < of(p.shortest_leg_m)
        elif self._extending:
            self._extending = length < of(p.rest_length_m)
        else:
            self._extending = of(p.rest_length_m) - length > of(p.switch_compression_m) and rate >= 0
        if not self._extending:
            self.gains = self._soft
            return
        sampled = self._number.multiply(of(p.active_damping_kg_m), max(-state["v_f"], 0))
        self.gains = Gains(of(p.extension_stiffness_n_m), of(p.extension_damping_kg_s) + sampled)
