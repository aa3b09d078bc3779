"""The force-plate study (thesis 3.2.2) as a campaign with a known truth: simulated jumps, as instruments see them.

On each of four days the robot jumps 80 times at each of four extension gains, in the thesis's order, and idles twice.
The jumps are the simulator's (`force_plate` scene): those in which it settles, then settled ones of extension
stiffnesses that differ by up to 2 %, as no two hops are equal. The battery gives what the whole jumps cost in the
simulation; what days and runs differ by is drawn. The plate has noise, and the robot's clock and the plate's differ.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.demo.logger import samples_not_dropped
from labbook.demo.truth import recharged_mah
from labbook.demo.writers import StudyRun

FloatArray = NDArray[np.float64]
GAINS = (300, 600, 500, 400)
"""In the order of the day (thesis 3.2.2)."""
DAYS, HOPS = 4, 80
IDLE_S = (60, 180)
VOLTAGE_V = 15.4
_LOG_STEP_S = 0.003
"""Whole milliseconds at 333 Hz."""
_STIFFNESSES = (0.98, 1.0, 1.02)
_SETTLING = 9
"""Jumps after which the next one costs the same to 2 per mille."""
_HELD_S, _WATCHED_S = 1.0, 0.4
"""The robot is held above the plate before and after its jumps; records begin within the second."""
_FIRST_DAY = dt.date(2021, 3, 1)
_LOG_DRIFT, _LOG_DRIFT_SD = 80e-6, 5e-6
_LEG_NOISE_M, _LEG_RATE_NOISE_M_S, _HEIGHT_NOISE_M = 5e-5, 0.01, 0.001
_IMPACT_S = (0.003, 0.006)
_PLATE_CREEP_N_S = 0.02
_DROP_CHANCE, _LONGEST_DROP = 0.06, 12
_OVERHEAD_S = 22


@dataclass(frozen=True, slots=True)
class PlateScatter:
    """Standard deviations: of what the battery gives, as a share, by day and by run, and of each recharge."""

    day: float = 0.01
    run: float = 0.01
    recharge_mah: float = 0.35


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


@dataclass(frozen=True, slots=True, eq=False)
class PlateStudyRun(StudyRun):
    """A run as it was, and what both instruments recorded of it.

    The log's channels have one element a recorded sample of `log_ms`; `clocks` are the true offset in s (what the log's
    clock shows at the plate's first sample, from the log's first on) and drift of the log's clock against the plate's;
    `cost_j` and `stance_j` are the means over its jumps.
    """

    cost_j: float = 0.0
    stance_j: float = 0.0
    clocks: tuple[float, float] = (0.0, 0.0)
    plate: PlateRecord | None = None
    log_ms: NDArray[np.int64] | None = None
    channels: Mapping[str, FloatArray] | None = None

    @property
    def gain(self) -> int | None:
        """Its extension gain, None of an idle run."""
        return self.levels.get("k_gain")


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


def plate_campaign(
    seed: int, *, days: int = DAYS, hops: int = HOPS, scatter: PlateScatter | None = None, noise: float = 1.0
) -> list[PlateStudyRun]:
    """Draw the campaign; `noise` multiplies the instruments' errors and the share of packets that are lost."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 4]))
    scatter = scatter or PlateScatter()
    runs: list[PlateStudyRun] = []
    for day in range(days):
        date = _FIRST_DAY + dt.timedelta(days=day)
        day_share = rng.normal(0.0, scatter.day)
        of_day = [(None, IDLE_S[0]), *((gain, 0) for gain in GAINS), (None, IDLE_S[1])]
        for position, (gain, idle_s) in enumerate(of_day, start=1):
            name = f"r{len(runs) + 1:03d}"
            if gain is None:
                duration_s = idle_s + int(rng.integers(-2, 3))
                charge = recharged_mah(rng, duration_s, 0.0, VOLTAGE_V, scatter.recharge_mah)
                runs.append(PlateStudyRun(name, date, position, {}, 0, duration_s, charge))
                continue
            share = (1.0 + day_share) * (1.0 + rng.normal(0.0, scatter.run))
            settling, settled = pieces(gain)
            jumps = [*settling, *(settled[which] for which in rng.integers(len(settled), size=hops))][:hops]
            run = PlateStudyRun(name, date, position, {"k_gain": gain}, hops, 0, 0)
            run = _recorded(rng, _Hopping.of(jumps), run, noise)
            joules = share * run.cost_j * hops
            charge = recharged_mah(rng, run.duration_s, joules, VOLTAGE_V, scatter.recharge_mah)
            runs.append(replace(run, charge_mah=charge))
    return runs


def hopping_record(seed: int, gain: int, hops: int) -> PlateRecord:
    """Record `hops` settled jumps at a gain, the plate unloaded for a second before and after."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 2]))
    settled = pieces(gain)[1]
    hopping = _Hopping.of([settled[which] for which in rng.integers(len(settled), size=hops)])
    end_s = float(hopping.begins_s[-1])
    time_s = np.arange(0.0, end_s + _HELD_S, 1.0 / RATE_HZ)
    return record_of(rng, replace(hopping, last_s=end_s).sampled("force_n", time_s) + hopping.impacts(rng, time_s))


@dataclass(frozen=True, slots=True, eq=False)
class _Hopping:
    """Jumps one after the other, s since the robot was let go: when each begins, the last one's end behind them, and
    when the robot is held again.
    """

    jumps: Sequence[Piece]
    begins_s: FloatArray
    last_s: float

    @classmethod
    def of(cls, jumps: Sequence[Piece]) -> _Hopping:
        """Put jumps one behind the other, the last one caught at its apex."""
        begins_s = np.cumsum([0.0, *(piece.time_s[-1] for piece in jumps)]) + _HELD_S
        return cls(jumps, begins_s, float(begins_s[-2] + jumps[-1].time_s[_apex(jumps[-1])]))

    def sampled(self, what: str, time_s: FloatArray, before: float = 0.0, after: float = 0.0) -> FloatArray:
        """Read a motion at times; before the first touchdown and from `last_s` on the robot is held."""
        begun = zip(self.jumps, self.begins_s[:-1], strict=True)
        times = np.concatenate([piece.time_s + begin for piece, begin in begun])
        values = np.concatenate([getattr(piece, what) for piece in self.jumps])
        found = np.interp(time_s, times, values)
        return np.where(time_s < self.begins_s[0], before, np.where(time_s > self.last_s, after, found))

    def impacts(self, rng: np.random.Generator, time_s: FloatArray) -> FloatArray:
        """Return the force that stops the foot at each touchdown: half a sine of some milliseconds."""
        force_n = np.zeros(time_s.size)
        for piece, begin_s in zip(self.jumps, self.begins_s[:-1].tolist(), strict=True):
            length_s = rng.uniform(*_IMPACT_S)
            first, last = np.searchsorted(time_s, [begin_s, begin_s + length_s])
            phase = np.pi * (time_s[first:last] - begin_s) / length_s
            force_n[first:last] += 0.5 * np.pi * piece.impulse_n_s / length_s * np.sin(phase)
        return force_n


def _apex(piece: Piece) -> int:
    return int(np.argmax(piece.body_m * (piece.force_n == 0.0)))


def _recorded(rng: np.random.Generator, hopping: _Hopping, run: PlateStudyRun, noise: float) -> PlateStudyRun:
    """Record a run by both instruments; its charge is not drawn."""
    jumps, last_s = hopping.jumps, hopping.last_s
    # The plate's clock is true but for its stamps; the log's runs slow by its drift.
    begin_s, log_begin_s = rng.uniform(0.0, _WATCHED_S, 2).tolist()
    drift = _LOG_DRIFT + float(rng.normal(0.0, _LOG_DRIFT_SD))
    plate_s = np.arange(begin_s, last_s + _HELD_S, 1.0 / RATE_HZ)
    log_s = np.arange(log_begin_s, last_s + _HELD_S, _LOG_STEP_S * (1.0 + drift))
    n = log_s.size
    log_ms = int(rng.integers(15_000, 40_000)) + np.arange(n) * round(1000 * _LOG_STEP_S)
    force_n = hopping.sampled("force_n", plate_s)
    force_n += hopping.impacts(rng, plate_s) + noise * _PLATE_CREEP_N_S * plate_s
    plate = record_of(rng, force_n, noise)
    per_plate = float((plate.time_ms[-1] - plate.time_ms[0]) / 1e3 / (plate_s[-1] - plate_s[0]))
    rest_m, caught_m = float(jumps[0].leg_m[0]), float(jumps[-1].body_m[_apex(jumps[-1])])
    channels = {
        channel: hopping.sampled(what, log_s, before, after) + noise * rng.normal(0.0, sd, n)
        for channel, what, before, after, sd in (
            ("body_height [m]", "body_m", rest_m, caught_m, _HEIGHT_NOISE_M),
            ("leg_length [m]", "leg_m", rest_m, rest_m, _LEG_NOISE_M),
            ("leg_velocity [m/s]", "leg_rate_m_s", 0.0, 0.0, _LEG_RATE_NOISE_M_S),
        )
    }
    channels["k_gain"] = np.full(n, float(run.gain or 0))
    dropped = int(rng.binomial(run.jumps, min(noise * _DROP_CHANCE, 1.0)))
    recorded = samples_not_dropped(rng, n, dropped, _LONGEST_DROP)
    recorded[0] = True
    return replace(
        run,
        duration_s=int(last_s) + _OVERHEAD_S,
        cost_j=float(np.mean([piece.cost_j for piece in jumps])),
        stance_j=float(np.mean([piece.stance_j for piece in jumps])),
        clocks=((begin_s - log_begin_s) / (1.0 + drift), 1.0 / (1.0 + drift) / per_plate - 1.0),
        plate=plate,
        log_ms=log_ms[recorded],
        channels={channel: values[recorded] for channel, values in channels.items()},
    )


RATE_HZ = 1000

_CLOCK_DRIFT = 20e-6
_FORCE_NOISE_N = 2.5
_FORCE_OFFSET_N = (-6.0, 0.4, 0.0)
_MOMENT_NOISE_NM = 0.25
_CENTRE_M = (0.012, -0.020)
_COP_LIMIT_M = 1.28


@dataclass(frozen=True, slots=True, eq=False)
class PlateRecord:
    """Force-plate samples: `time_ms` (n,), force and moment (n, 3), centre of pressure (n, 2); z down."""

    time_ms: FloatArray
    force_n: FloatArray
    moment_nm: FloatArray
    cop_m: FloatArray


def record_of(rng: np.random.Generator, fz_n: FloatArray, noise: float = 1.0) -> PlateRecord:
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
