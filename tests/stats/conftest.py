"""Height logs with known apexes: the bed of thesis 5.1.3 with its hand motion, and the emulator's chain of jumps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

GRAVITY = 9.80665
REST_LENGTH_M = 0.27
Floats = NDArray[np.float64]
Piece = tuple[float, Callable[[Floats], Floats], Callable[[Floats], Floats]]
"""Duration, body height and leg length as functions of the time since the piece began."""


@dataclass(frozen=True)
class Log:
    time_s: Floats
    height_m: Floats
    leg_m: Floats
    touchdown_s: Floats
    liftoff_s: Floats
    apex_s: Floats
    """NaN for a misfire."""
    apex_height_m: Floats


def hermite(duration: float, z0: float, v0: float, z1: float, v1: float) -> Callable[[Floats], Floats]:
    def at(t: Floats) -> Floats:
        x = t / duration
        return (
            (1 + 2 * x) * (1 - x) ** 2 * z0
            + x * (1 - x) ** 2 * duration * v0
            + x * x * (3 - 2 * x) * z1
            + x * x * (x - 1) * duration * v1
        )

    return at


def constant(value: float) -> Callable[[Floats], Floats]:
    return lambda t: np.full(t.shape, value)


def hand(duration: float, start: float, end: float, wobble_m: float, hertz: float) -> Piece:
    move = hermite(duration, start, 0.0, end, 0.0)

    def at(t: Floats) -> Floats:
        return move(t) + wobble_m * np.sin(2 * math.pi * hertz * t) * np.sin(math.pi * t / duration) ** 2

    return duration, at, constant(REST_LENGTH_M)


def stance(bottom: float, liftoff: float, v_down: float, v_up: float) -> tuple[Piece, Piece]:
    """Compression and extension; the foot sinks by 0.02 m, then to where the leg is at rest length again."""
    down = hermite(0.15, REST_LENGTH_M, v_down, bottom, 0.0)
    up = hermite(0.14, bottom, 0.0, liftoff, v_up)
    foot_down = hermite(0.15, 0.0, v_down, -0.02, 0.0)
    foot_up = hermite(0.14, -0.02, 0.0, liftoff - REST_LENGTH_M, 0.0)
    return ((0.15, down, lambda t: down(t) - foot_down(t)), (0.14, up, lambda t: up(t) - foot_up(t)))


def free_flight(duration: float, z0: float, v0: float) -> Piece:
    return duration, lambda t: z0 + v0 * t - 0.5 * GRAVITY * t * t, constant(REST_LENGTH_M)


def assemble(pieces: list[Piece], marks: dict[str, list[tuple[int, float, float]]], rate_hz: float) -> Log:
    """Sample the pieces; marks are (piece, time in it, value)."""
    begins = np.concatenate([[0.0], np.cumsum([piece[0] for piece in pieces])])
    time = np.arange(0.0, begins[-1] - 1e-9, 1.0 / rate_hz)
    height, leg = np.empty(time.size), np.empty(time.size)
    edges = np.searchsorted(time, begins)
    for (_, z, length), begin, first, last in zip(pieces, begins, edges, edges[1:], strict=False):
        height[first:last], leg[first:last] = z(time[first:last] - begin), length(time[first:last] - begin)
    when = {name: np.array([begins[piece] + at for piece, at, _ in rows]) for name, rows in marks.items()}
    heights = np.array([value for _, _, value in marks["apex"]])
    return Log(time, height, leg, when["touchdown"], when["liftoff"], when["apex"], heights)


def make_bed_log(
    n_jumps: int = 25,
    *,
    rate_hz: float = 300.0,
    misfires: tuple[int, ...] = (),
    rest_s: tuple[float, float] = (2.0, 4.0),
    apex_m: tuple[float, float] = (0.29, 0.36),
    catch_s: tuple[float, float] = (0.025, 0.06),
    seed: int = 1,
) -> Log:
    """Clamp, lowering by hand, drop, stance, apex, catch, lifting back: `n_jumps` times; `misfires` do not lift off."""
    rng = np.random.default_rng(seed)
    pieces: list[Piece] = []
    marks: dict[str, list[tuple[int, float, float]]] = {"touchdown": [], "liftoff": [], "apex": []}
    fall_s, v_down = math.sqrt(2 * 0.15 / GRAVITY), -math.sqrt(2 * 0.15 * GRAVITY)
    for number in range(1, n_jumps + 1):
        pieces.append(hand(rng.uniform(*rest_s), 0.46, 0.46, 0.002, 1.3))
        pieces.append(hand(rng.uniform(0.8, 1.2), 0.46, 0.42, 0.008, rng.uniform(2.5, 4.0)))
        pieces.append(hand(0.5, 0.42, 0.42, 0.006, 3.0))
        pieces.append(free_flight(fall_s, 0.42, 0.0))
        marks["touchdown"].append((len(pieces), 0.0, 0.0))
        apex, liftoff = rng.uniform(*apex_m), rng.uniform(0.235, 0.26)
        v_up = math.sqrt(2 * GRAVITY * (apex - liftoff))
        if number in misfires:
            v_up = 0.0
        down, up = stance(rng.uniform(0.13, 0.2), 0.2 if number in misfires else liftoff, v_down, v_up)
        pieces += [down, up]
        if number in misfires:
            marks["liftoff"].append((len(pieces), math.nan, 0.0))
            marks["apex"].append((len(pieces), math.nan, math.nan))
            pieces.append((1.0, constant(0.2), constant(0.2)))
            pieces.append(hand(rng.uniform(0.6, 1.2), 0.2, 0.46, 0.01, 3.0))
            continue
        marks["liftoff"].append((len(pieces), 0.0, 0.0))
        marks["apex"].append((len(pieces), v_up / GRAVITY, apex))
        after = rng.uniform(*catch_s)
        pieces.append(free_flight(v_up / GRAVITY + after, liftoff, v_up))
        caught = apex - 0.5 * GRAVITY * after**2
        slow = rng.uniform(0.05, 0.09)
        end = caught - 0.4 * GRAVITY * after * slow
        pieces.append((slow, hermite(slow, caught, -GRAVITY * after, end, 0.0), constant(REST_LENGTH_M)))
        pieces.append(hand(rng.uniform(0.8, 1.5), end, 0.46, 0.012, rng.uniform(2.0, 3.5)))
    pieces.append(hand(2.0, 0.46, 0.46, 0.002, 1.3))
    return assemble(pieces, marks, rate_hz)


def make_emulator_log(
    n_jumps: int = 100, *, rate_hz: float = 300.0, apex_m: tuple[float, float] = (0.40, 0.44), seed: int = 2
) -> Log:
    """Hop after hop on a platform that gives way by 0.02 m and is pushed back in flight."""
    rng = np.random.default_rng(seed)
    pieces: list[Piece] = [hand(1.5, 0.32, REST_LENGTH_M + 0.004, 0.002, 3.0)]
    marks: dict[str, list[tuple[int, float, float]]] = {"touchdown": [], "liftoff": [], "apex": []}
    pieces.append(free_flight(math.sqrt(2 * 0.004 / GRAVITY), REST_LENGTH_M + 0.004, 0.0))
    v_down = -math.sqrt(2 * 0.004 * GRAVITY)
    for number in range(1, n_jumps + 1):
        marks["touchdown"].append((len(pieces), 0.0, 0.0))
        apex, liftoff = rng.uniform(*apex_m), REST_LENGTH_M - 0.02
        v_up = math.sqrt(2 * GRAVITY * (apex - liftoff))
        pieces += stance(0.17, liftoff, v_down, v_up)
        marks["liftoff"].append((len(pieces), 0.0, 0.0))
        marks["apex"].append((len(pieces), v_up / GRAVITY, apex))
        v_down = -math.sqrt(2 * GRAVITY * (apex - REST_LENGTH_M))
        falling = (-v_down if number < n_jumps else 0.5) / GRAVITY
        pieces.append(free_flight(v_up / GRAVITY + falling, liftoff, v_up))
    caught = apex - 0.5 * 0.5**2 / GRAVITY
    pieces.append((0.08, hermite(0.08, caught, -0.5, caught - 0.02, 0.0), constant(REST_LENGTH_M)))
    pieces.append(hand(1.0, caught - 0.02, 0.4, 0.0, 1.0))
    return assemble(pieces, marks, rate_hz)


@pytest.fixture(scope="session")
def bed_log() -> Callable[..., Log]:
    return make_bed_log


@pytest.fixture(scope="session")
def emulator_log() -> Callable[..., Log]:
    return make_emulator_log
