"""Which share of a prediction's variance each assumed input bears: Sobol indices, over all inputs at once.

Each input lies anywhere within its part of its value, all values as likely, and has one value in all conditions. The
first-order index is the share that goes if the input is known; the total index is the share that stays if it alone is
not. Both come from Saltelli's sample as scipy has it (`scipy.stats.sobol_indices`).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.pairing import pairs_each
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.prediction.predicting import PredictionResult
from labbook.analysis.prediction.simulating import many_scenes
from reports.predicted import PredictedQuantity
from simulator.scene_file import parse_scene

Floats = NDArray[np.float64]
_FEWEST, _RESAMPLES = 32, 200


@dataclass(frozen=True, slots=True)
class Shares:
    """The indices of one input in one quantity of one condition: Undefined where the robot does not always jump.

    `total_se` is the total index's standard error by the sample (bootstrap).
    """

    input: str
    quantity: PredictedQuantity
    condition: str
    first_order: float | Undefined
    total: float | Undefined
    total_se: float | Undefined


def shares_of_inputs(
    predicted: Mapping[tuple[str, str], PredictionResult],
    conditions: Sequence[ConditionValues],
    swept: str | None,
    size: int,
    seed: int = 1,
) -> list[Shares]:
    """Return the indices of every assumed input in joules, apex and savings of every predicted condition.

    `size` is the sample's, a power of two; each condition is simulated that often times the inputs and two. Raises
    `UsageError` where it is none, and where nothing is assumed.
    """
    from scipy import stats

    if size < _FEWEST or size & (size - 1):
        raise UsageError(f"a sample of {size} is no power of two from {_FEWEST} on: give one such as 256.")
    results = {key: result for (key, _robot), result in predicted.items()}
    if len(results) < len(predicted):
        raise UsageError("these runs are of several robots: choose one with --where, as in --where robot=NAME.")
    parts = {name: about.varied_by for result in results.values() for name, about in result.assumed.items()}
    if not parts:
        raise UsageError("nothing is assumed in these predictions: name what is under assumed = [...] of [simulation].")
    keys, names = list(results), list(parts)
    scenes = [parse_scene(result.scene_toml, result.scene) for result in results.values()]
    several = many_scenes(scenes, names, results[keys[0]].accuracy)
    pairs = [
        (keys.index(pair.a[0].key), keys.index(pair.b[0].key))
        for pair in (pairs_each(conditions, swept) if swept else [])
        if pair.a[0].key in keys and pair.b[0].key in keys
    ]

    def outputs(factors: Floats) -> Floats:
        """Return joules, apexes and savings, shape (outputs, n), for factors of shape (inputs, n)."""
        found = several.means(factors.T, times=True)
        joules, apex = found[Outcome.JOULES].T, found[Outcome.APEX].T
        saved = [100.0 * (1.0 - joules[treated] / joules[control]) for control, treated in pairs]
        return np.concatenate([joules, apex, np.array(saved).reshape(len(pairs), factors.shape[1])])

    rng = np.random.default_rng(seed)
    drawn = _sampled(outputs, np.array([parts[name] for name in names]), size, rng)
    with np.errstate(invalid="ignore", divide="ignore"):
        found = stats.sobol_indices(func=drawn, n=size)
        again = [_drawn_again(drawn, rng.integers(0, size, size)) for _ in range(_RESAMPLES)]
        errors = np.std([stats.sobol_indices(func=one, n=size).total_order for one in again], axis=0)
    about = [
        *((PredictedQuantity.JOULES, key) for key in keys),
        *((PredictedQuantity.APEX, key) for key in keys),
        *((PredictedQuantity.SAVINGS, keys[treated]) for _control, treated in pairs),
    ]
    return [
        Shares(
            names[column],
            quantity,
            key,
            _known(found.first_order[row, column]),
            _known(found.total_order[row, column]),
            _known(errors[row, column]),
        )
        for (row, (quantity, key)), column in itertools.product(enumerate(about), range(len(names)))
    ]


def _sampled(
    outputs: Callable[[Floats], Floats], parts: Floats, size: int, rng: np.random.Generator
) -> dict[str, Floats]:
    """Return the outputs of Saltelli's sample: of two samples A and B, and of A with one input at a time from B."""
    from scipy.stats import qmc

    inputs = len(parts)
    points = qmc.Sobol(2 * inputs, rng=rng).random(size).T
    a, b = (1.0 + parts[:, np.newaxis] * (2.0 * one - 1.0) for one in (points[:inputs], points[inputs:]))
    mixed = [np.where(np.arange(inputs)[:, np.newaxis] == column, b, a) for column in range(inputs)]
    f_a, f_b, *f_ab = np.split(outputs(np.concatenate([a, b, *mixed], axis=1)), inputs + 2, axis=1)
    return {"f_A": f_a, "f_B": f_b, "f_AB": np.array(f_ab)}


def _drawn_again(drawn: Mapping[str, Floats], rows: NDArray[np.int64]) -> dict[str, Floats]:
    return {name: values[..., rows] for name, values in drawn.items()}


def _known(index: float) -> float | Undefined:
    return float(index) if np.isfinite(index) else Undefined(Reason.VARIED_WITHOUT_JUMP, source="input")
