"""What a force plate records of simulated jumps (`force_plate` scene): its force with noise, and the foot's impacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.random import Generator

from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.demo.writers import FloatArray, PlateRecord

RATE_HZ = 1000
HELD_S = 1.0
"""The robot is held above the plate before and after its jumps."""
_STIFFNESSES = (0.98, 1.0, 1.02)
_SETTLING = 9
"""Jumps after which the next one costs the same to 2 per mille."""
_IMPACT_S = (0.003, 0.006)
_CLOCK_DRIFT = 20e-6
_FORCE_NOISE_N = 2.5
_FORCE_OFFSET_N = (-6.0, 0.4, 0.0)
_MOMENT_NOISE_NM = 0.25
_CENTRE_M = (0.012, -0.020)
_COP_LIMIT_M = 1.28


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """One simulated jump from touchdown to touchdown, arrays of shape (n,) over `time_s` since its touchdown.

    `impulse_n_s` stops the foot at touchdown; `cost_j` is what the motors take for the whole jump, `stance_j` for the
    stance alone.
    """

    time_s: FloatArray
    force_n: FloatArray
    leg_m: FloatArray
    leg_rate_m_s: FloatArray
    body_m: FloatArray
    impulse_n_s: float
    cost_j: float
    stance_j: float


@cache
def pieces(gain: int) -> tuple[tuple[Piece, ...], tuple[Piece, ...]]:
    """Simulate a gain: the jumps in which it settles, and one settled jump of each stiffness."""
    from simulator.gains import stiffness_n_m
    from simulator.jump import simulate
    from simulator.scene_file import load_scene

    start = load_scene("force_plate").changed(jumps=_SETTLING + 1)
    settling: tuple[Piece, ...] = ()
    settled = []
    for share in _STIFFNESSES:
        scene = start.changed({"k_extension": share * stiffness_n_m(gain)})
        result = simulate(scene, 1e-6, trajectory=True)
        motion = result.trajectory
        if motion is None:
            raise RuntimeError(f"{scene.name} has no recorded motion")
        names = ("time", "jump", "mode", "leg_length", "body_height", "body_velocity", "foot_velocity")
        columns = {name: motion[name].to_numpy() for name in (*names, "body_acceleration")}
        found = []
        for number, jump in enumerate(result.jumps):
            of_it = columns["jump"] == number
            now = {name: values[of_it] for name, values in columns.items()}
            push_n = scene["body_mass"] * (now["body_acceleration"] + STANDARD_GRAVITY_M_S2)
            standing_n = push_n + scene["foot_mass"] * STANDARD_GRAVITY_M_S2
            before = result.jumps[number - 1].next_touchdown_body_velocity_m_s if number else 0.0
            found.append(
                Piece(
                    time_s=now["time"] - now["time"][0],
                    force_n=np.where(now["mode"] == 0, standing_n, 0.0),
                    leg_m=now["leg_length"],
                    leg_rate_m_s=now["body_velocity"] - now["foot_velocity"],
                    body_m=now["body_height"],
                    impulse_n_s=scene["foot_mass"] * abs(before or 0.0),
                    cost_j=jump.cost_J,
                    stance_j=jump.stance_heat_J + jump.stance_mechanical_J + jump.stance_drag_J,
                )
            )
        settled.append(found[-1])
        if share == 1.0:
            settling = tuple(found[:-1])
    return settling, tuple(settled)


def hopping_record(seed: int, gain: int, hops: int) -> PlateRecord:
    """Record `hops` settled jumps at a gain, the plate unloaded for a second before and after."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 2]))
    settled = pieces(gain)[1]
    hopping = Hopping.of([settled[which] for which in rng.integers(len(settled), size=hops)])
    end_s = float(hopping.begins_s[-1])
    time_s = np.arange(0.0, end_s + HELD_S, 1.0 / RATE_HZ)
    return record_of(rng, replace(hopping, last_s=end_s).sampled("force_n", time_s) + hopping.impacts(rng, time_s))


@dataclass(frozen=True, slots=True, eq=False)
class Hopping:
    """Jumps one after the other, s since the robot was let go: when each begins, the last one's end behind them, and
    when the robot is held again.
    """

    jumps: Sequence[Piece]
    begins_s: FloatArray
    last_s: float

    @classmethod
    def of(cls, jumps: Sequence[Piece]) -> Hopping:
        """Put jumps one behind the other, the last one caught at its apex."""
        begins_s = np.cumsum([0.0, *(piece.time_s[-1] for piece in jumps)]) + HELD_S
        return cls(jumps, begins_s, float(begins_s[-2] + jumps[-1].time_s[apex_of(jumps[-1])]))

    def sampled(self, what: str, time_s: FloatArray, before: float = 0.0, after: float = 0.0) -> FloatArray:
        """Read a motion at times; before the first touchdown and from `last_s` on the robot is held."""
        begun = zip(self.jumps, self.begins_s[:-1], strict=True)
        times = np.concatenate([piece.time_s + begin for piece, begin in begun])
        values = np.concatenate([getattr(piece, what) for piece in self.jumps])
        found = np.interp(time_s, times, values)
        return np.where(time_s < self.begins_s[0], before, np.where(time_s > self.last_s, after, found))

    def impacts(self, rng: Generator, time_s: FloatArray) -> FloatArray:
        """Return the force that stops the foot at each touchdown: half a sine of some milliseconds."""
        force_n = np.zeros(time_s.size)
        for piece, begin_s in zip(self.jumps, self.begins_s[:-1].tolist(), strict=True):
            length_s = rng.uniform(*_IMPACT_S)
            first, last = np.searchsorted(time_s, [begin_s, begin_s + length_s])
            phase = np.pi * (time_s[first:last] - begin_s) / length_s
            force_n[first:last] += 0.5 * np.pi * piece.impulse_n_s / length_s * np.sin(phase)
        return force_n


def apex_of(piece: Piece) -> int:
    """Return the sample at which the body is highest in flight."""
    return int(np.argmax(piece.body_m * (piece.force_n == 0.0)))


def record_of(rng: Generator, fz_n: FloatArray, noise: float = 1.0) -> PlateRecord:
    """Record a vertical force, shape (n,), by a plate whose errors are multiplied by `noise`."""
    n = fz_n.size
    foot_m = np.array(_CENTRE_M) + np.cumsum(rng.normal(0, 2e-5, (n, 2)), axis=0)
    force_n = noise * rng.normal(0, _FORCE_NOISE_N, (n, 3)) + _FORCE_OFFSET_N
    force_n[:, 2] += fz_n
    moment_nm = noise * rng.normal(0, _MOMENT_NOISE_NM, (n, 3))
    moment_nm[:, 0] += fz_n * foot_m[:, 1]
    moment_nm[:, 1] -= fz_n * foot_m[:, 0]
    # As the program does: a quotient at every sample, meaningless where nothing stands on the plate.
    pressing_n = np.where(np.abs(force_n[:, 2]) < 1e-3, 1e-3, force_n[:, 2])
    cop_m = np.column_stack([-moment_nm[:, 1], moment_nm[:, 0]]) / pressing_n[:, None]
    time_ms = np.arange(n) * (1 + _CLOCK_DRIFT) * 1000 / RATE_HZ
    return PlateRecord(time_ms, force_n, moment_nm, np.clip(cop_m, -_COP_LIMIT_M, _COP_LIMIT_M))
