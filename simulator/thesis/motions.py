"""Figure 3.4: where body and foot are during one jump, with either controller and the phase it is in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from simulator.jump import simulate
from simulator.kernel.layout import FLIGHT
from simulator.scene import Scene

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
_SAME_TIME_S = 1e-12
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Pair(Generic[T]):
    """The same thing with compression-extension (CE) and with active damping (AD)."""

    ce: T
    ad: T


def both_controllers(scene: Scene) -> Pair[Scene]:
    """Return the scene of set 1 without and with active damping; it is shipped with (thesis 3.2)."""
    return Pair(ce=scene.changed({"b_ad": 0.0}), ad=scene)


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """One jump from touchdown to the next; arrays of shape (n,), heights above the undisturbed surface, up positive.

    At an event two samples share one time. `extending` is the controller's phase in stance, `flying` the time after
    lift-off; joules are sums since touchdown. The ground jams `jams` times: the foot stops in it.
    """

    time_s: FloatArray
    body_height_m: FloatArray
    body_velocity_m_s: FloatArray
    foot_height_m: FloatArray
    foot_velocity_m_s: FloatArray
    body_acceleration_m_s2: FloatArray
    leg_work_j: FloatArray
    ground_loss_j: FloatArray
    grain_energy_j: FloatArray
    extending: BoolArray
    flying: BoolArray
    switch_time_s: float
    liftoff_time_s: float
    jams: int

    @property
    def depth_m(self) -> FloatArray:
        """Return the greatest depth of the foot in stance so far, m: how deep the ground is pressed."""
        return np.asarray(np.maximum.accumulate(np.where(self.flying, 0.0, np.maximum(-self.foot_height_m, 0.0))))

    def at_switch(self, values: FloatArray) -> float:
        """Return what a quantity is at the controller's first switch to extension."""
        return float(np.interp(self.switch_time_s, self.time_s, values))


def motion_of(scene: Scene, accuracy: float) -> Motion:
    """Simulate a jump of a scene on grains with the sampled, unlatched controller, and keep its motion."""
    result = simulate(scene, accuracy, trajectory=True)
    motion, jump = result.trajectory, result.jump
    if motion is None or jump.liftoff_time_s is None:
        raise RuntimeError(f"{scene.name} does not leave the ground, and has no motion to draw")
    columns = {
        name: motion[name].to_numpy().astype(np.float64)
        for name in ("time", "body_height", "body_velocity", "foot_height", "foot_velocity", "body_acceleration")
    }
    flying = motion["mode"].to_numpy() == FLIGHT
    extending = _extending(scene, columns) & ~flying
    return Motion(
        time_s=columns["time"],
        body_height_m=columns["body_height"],
        body_velocity_m_s=columns["body_velocity"],
        foot_height_m=columns["foot_height"],
        foot_velocity_m_s=columns["foot_velocity"],
        body_acceleration_m_s2=columns["body_acceleration"],
        leg_work_j=motion["leg_work"].to_numpy(),
        ground_loss_j=motion["ground_loss"].to_numpy(),
        grain_energy_j=motion["grain_energy"].to_numpy(),
        extending=extending,
        flying=flying,
        switch_time_s=float(columns["time"][np.argmax(extending)]),
        liftoff_time_s=jump.liftoff_time_s,
        jams=sum(change.after == "jammed" for change in jump.mode_changes),
    )


def sample_motions(scene: Scene, touchdown_speed_m_s: float, accuracy: float) -> Pair[Motion]:
    """Simulate one jump with either controller, body and foot arriving at this downward speed."""
    started = both_controllers(scene.changed({"initial_velocity": -touchdown_speed_m_s}))
    return Pair(ce=motion_of(started.ce, accuracy), ad=motion_of(started.ad, accuracy))


def _extending(scene: Scene, columns: dict[str, FloatArray]) -> BoolArray:
    """Decide each tick's phase by the published rule from the state at that tick; it is held until the next.

    Steps land on the ticks at which the phase changes, so that nothing that decides is interpolated.
    """
    time_s, tick_s = columns["time"], 1.0 / scene["control_rate"]
    ticks_s = np.arange(int(time_s[-1] / tick_s) + 1) * tick_s
    body_m, foot_m, body_m_s, foot_m_s = (
        np.interp(ticks_s, time_s, columns[name])
        for name in ("body_height", "foot_height", "body_velocity", "foot_velocity")
    )
    rule = (body_m_s > foot_m_s) & (foot_m < 0.0) & (body_m_s > 0.0)
    phase = rule | (body_m - foot_m < scene["guard_length"])
    # Of the samples that share a tick's time, the first ends the step before it, in the phase before.
    ends_step = np.append(np.diff(time_s) < _SAME_TIME_S, False)
    tick = np.searchsorted(ticks_s, time_s + np.where(ends_step, -1.0, 1.0) * _SAME_TIME_S, side="right") - 1
    return np.asarray(phase[np.maximum(tick, 0)])
