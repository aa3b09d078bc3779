"""What every function here does with its input first: doubles, one dimension, nothing infinite or missing."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused


def as_values(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return `values` as float64 of shape (n,); `name` is what the sentence of a refusal calls them.

    Raises `InputRefused` when they are not numbers, not one-dimensional, or some are NaN or infinite.
    """
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputRefused(f"{name} holds something that is not a number: give real numbers only.") from error
    if array.ndim != 1:
        raise InputRefused(f"{name} has {array.ndim} dimensions where one is allowed: give a plain list of numbers.")
    bad = ~np.isfinite(array)
    if bad.any():
        raise InputRefused(
            f"{name} holds {int(bad.sum())} of {array.size} values that are NaN or infinite, the first at position "
            f"{int(np.argmax(bad)) + 1}: leave missing values out before calling."
        )
    return array


def as_number(name: str, value: float, *, low: float = -np.inf, above: float = -np.inf) -> float:
    """Return one finite number that is at least `low` and greater than `above`.

    Raises `InputRefused` otherwise.
    """
    number = float(value)
    if not np.isfinite(number) or number < low or number <= above:
        allowed = "a finite number"
        if low > -np.inf:
            allowed = f"a number of at least {low:g}"
        if above > -np.inf:
            allowed = f"a number greater than {above:g}"
        raise InputRefused(f"{name} is {value!r}: give {allowed}.")
    return number


def as_level(name: str, value: float) -> float:
    """Return a probability strictly between 0 and 1; raises `InputRefused` otherwise."""
    number = float(value)
    if not 0.0 < number < 1.0:
        raise InputRefused(f"{name} is {value!r}: give a number between 0 and 1, for example 0.95.")
    return number
