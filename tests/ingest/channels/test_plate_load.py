"""The unloaded level of a plate: hops, steps and jumps of any offset and noise are never judged the wrong way round."""

from __future__ import annotations

import numpy as np
import pytest

from ingest.channels.forces import find_load
from tests.helpers.single_jumps import SimulatedJump
from tests.stats.test_single_jump import SAMPLES, needs_samples

SHAPES = {
    "half sine": lambda p: np.sin(np.pi * p),
    "flat top": lambda p: np.sqrt(np.sin(np.pi * p)),
    "two humps": lambda p: np.minimum(8 * np.minimum(p, 1 - p), 1) * (1 - 0.2 * np.cos(4 * np.pi * (p - 0.5))),
    "impact": lambda p: np.sin(np.pi * p) + 1.5 * np.exp(-(((p - 0.08) / 0.03) ** 2)),
}


def moves(draw: np.random.Generator, shape: str) -> np.ndarray:
    """Contacts of 0.1 to 0.4 s with flights between, at 100 to 2000 Hz; about them the plate is unloaded, or the body
    stands on it, or the record begins and ends anywhere.
    """
    rate_hz, stance_s, flight_s = draw.choice([100, 500, 2000]), draw.uniform(0.1, 0.4), draw.uniform(0.1, 0.5)
    phase = (np.arange(int(10 * rate_hz)) / rate_hz + draw.uniform(0, 1)) % (stance_s + flight_s) / stance_s
    load_n = draw.choice([60.0, 300.0, 2000.0])
    force_n = np.where(phase < 1, load_n * SHAPES[shape](np.minimum(phase, 1.0)), 0.0)
    begin, end = np.sort(draw.uniform(0, force_n.size, 2)).astype(int)
    match draw.integers(3):
        case 0:
            force_n[:begin] = force_n[end:] = 0.0
        case 1:
            force_n = force_n[begin:end]
        case _:
            standing_n = np.full(force_n.size // 2, force_n.mean())
            force_n = np.concatenate([standing_n, force_n, standing_n])
    noise_n = draw.normal(0, draw.choice([0.0, 0.5, 2.5]), force_n.size)
    return force_n + noise_n + draw.choice([0.0, 0.2]) * np.arange(force_n.size) / rate_hz


@pytest.mark.parametrize("shape", SHAPES)
def test_no_move_is_judged_the_wrong_way_and_most_are_judged(shape: str) -> None:
    draw = np.random.default_rng(8)
    signs = []
    for _ in range(150):
        force_n, sign, offset_n = moves(draw, shape), draw.choice([1, -1]), draw.uniform(-200, 200)
        load = find_load(sign * force_n + offset_n)
        if load is not None:
            signs.append(load.sign * sign)
            assert load.unloaded_n == pytest.approx(offset_n, abs=0.05 * load.largest_n + 2.0)
    assert set(signs) == {1}
    assert len(signs) > 120


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("offset_n", [-150.0, 0.0])
def test_a_jump_out_of_standing_shows_its_load(sign: int, offset_n: float) -> None:
    for seed in range(20):
        true = SimulatedJump(seed, after_s=0.1 * seed)
        load = find_load(sign * true.force_n + offset_n)
        assert load is not None
        assert load.sign == sign
        assert load.unloaded_n == pytest.approx(offset_n, abs=2.0)


@needs_samples
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("trial", range(1, 5))
def test_real_jumps_show_their_load(trial: int, sign: int) -> None:
    """Two of them end in the flight; the top of a landing's impact is no level."""
    load = find_load(sign * np.loadtxt(SAMPLES / f"subject01_trial{trial}.force.txt"))
    assert load is not None
    assert load.sign == sign
    assert load.unloaded_n == pytest.approx(0.0, abs=1.5)
