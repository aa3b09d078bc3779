"""What every function here does with its input first: real numbers of any type, one dimension, nothing infinite."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from numbers import Real
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused, unknown_name


def require_list(name: str, values: Any) -> None:
    """Raise `InputRefused` for a table, a dict, a set, a generator or a single number, saying what to give instead.

    `name` is what the sentence calls the values.
    """
    if is_table(values):
        columns = [repr(str(column)) for column in values.columns]
        held = f"the column {columns[0]}" if len(columns) == 1 else f"{len(columns)} columns"
        like = f", for example df[{columns[0]}]" if columns else ""
        raise InputRefused(f"{name} is a table with {held} where one list of numbers is allowed: give a column{like}.")
    kind = type(values).__name__
    if isinstance(values, Mapping):
        raise InputRefused(f"{name} is a {kind}: give a list of its numbers, for example list(numbers.values()).")
    if isinstance(values, Iterable) and not hasattr(values, "__getitem__") and not hasattr(values, "__array__"):
        raise InputRefused(f"{name} is a {kind}: give a list of its numbers, for example list(numbers).")


def is_table(values: Any) -> bool:
    """Whether something is a data frame, of pandas or another package: none of them need be loaded."""
    return hasattr(type(values), "columns")


T = TypeVar("T")
Missing = Literal["refuse", "drop"]
MISSING: tuple[Missing, ...] = ("refuse", "drop")
"""What to do with values that are NaN: refuse them all, or leave them out and say how many."""

_LEVELS = {"alpha": 0.05, "power": 0.8}
"""What such a number usually is, by its name."""
NO_VALUE = ("NAType", "NaTType", "NoneType")
"""Types of a missing value, by name: pandas itself need not be loaded."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Finite values, shape (n,), and how many were left out as missing."""

    values: NDArray[np.float64]
    missing: int


def as_sample(name: str, values: ArrayLike | Iterable[Decimal], missing: Missing = "refuse") -> Sample:
    """Return real numbers of any type (also of pandas and xarray), shape (n,), as a sample.

    `name` is what the sentence of a refusal calls them. NaN, None, pandas' NA and masked values are missing: refused,
    or with `missing="drop"` left out and counted. Raises `InputRefused` for infinite values, truth values, text,
    complex numbers, times and more than one dimension.
    """
    if missing not in MISSING:
        raise unknown_name("way with missing values", missing, MISSING)
    require_list(name, values)
    doubles = _doubles(name, values)
    if doubles.ndim == 0:
        raise InputRefused(f"{name} is a single value: give a list of numbers.")
    if doubles.ndim != 1:
        raise InputRefused(f"{name} has {doubles.ndim} dimensions where one is allowed: give a plain list of numbers.")
    finite = np.isfinite(doubles)
    if finite.all():
        return Sample(doubles, 0)
    bad = ~finite if missing == "refuse" else np.isinf(doubles)
    if bad.any():
        what, way_out = "infinite", "leave infinite values out before calling"
        if np.isnan(doubles[bad]).any():
            what = "NaN or infinite"
            way_out = 'leave missing values out before calling, or say missing="drop"'
            if np.isinf(doubles[bad]).any():
                way_out += " (infinite values are never dropped)"
        raise InputRefused(
            f"{name} holds {int(bad.sum())} of {doubles.size} values that are {what}, the first at position "
            f"{int(np.argmax(bad)) + 1}: {way_out}."
        )
    return Sample(doubles[finite], int(doubles.size - finite.sum()))


def as_groups(groups: Any) -> dict[str, ArrayLike]:
    """Return samples by their names; a sequence of samples, each of shape (n_i,), gets the names "1", "2" and so on.

    Pairs of a name and a sample keep their names: `df.groupby("condition")["joules"]` is a sequence of such. Raises
    `InputRefused` for what is no sequence of samples, and for two of one name.
    """
    if isinstance(groups, Mapping):
        return dict(groups)
    if is_table(groups):  # a group for each column
        return {str(name): groups[name] for name in groups.columns}
    listed = [] if isinstance(groups, str | bytes) or not isinstance(groups, Iterable) else list(groups)
    if not all(np.iterable(values) and not isinstance(values, str) for values in listed) or not listed:
        raise InputRefused("the groups are no samples: give one sample of numbers for each, by name or in a list.")
    if not all(map(_is_named, listed)):
        return {str(place): values for place, values in enumerate(listed, 1)}
    named: dict[str, ArrayLike] = {}
    for label, values in listed:
        name = ", ".join(map(str, label)) if isinstance(label, tuple) else str(label)
        if name in named:
            raise InputRefused(f"two groups are called {name!r}: give each a name of its own.")
        named[name] = values
    return named


def _is_named(item: Any) -> bool:
    """Whether something is a pair of a name and a sample; pandas names groups of several columns by tuples."""
    if not isinstance(item, tuple) or len(item) != 2 or isinstance(item[1], str) or not np.iterable(item[1]):
        return False
    of_several = isinstance(item[0], tuple) and hasattr(item[1], "__array__")
    return of_several or isinstance(item[0], str) or not np.iterable(item[0])


def as_pair(names: tuple[str, str], first: T, second: T) -> dict[str, T]:
    """Return two things by their names; raises `InputRefused` where these are the same."""
    if names[0] == names[1]:
        raise InputRefused(f"both groups are called {names[0]!r}: give each a name of its own.")
    return {names[0]: first, names[1]: second}


def as_values(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return `values` as float64 of shape (n,); `name` is what the sentence of a refusal calls them.

    Raises `InputRefused` for what `as_sample` refuses, NaN included.
    """
    return as_sample(name, values).values


def as_number(name: str, value: float, *, low: float = -np.inf, above: float = -np.inf) -> float:
    """Return one finite number that is at least `low` and greater than `above`.

    Raises `InputRefused` otherwise.
    """
    number = _one(name, value)
    if not math.isfinite(number) or number < low or number <= above:
        allowed = "a finite number"
        if low > -np.inf:
            allowed = f"a number of at least {low:g}"
        if above > -np.inf:
            allowed = f"a number greater than {above:g}"
        raise InputRefused(f"{name} is {value!r}: give {allowed}.")
    return number


def as_level(name: str, value: float) -> float:
    """Return a probability strictly between 0 and 1; raises `InputRefused` otherwise."""
    number = _one(name, value)
    if not 0.0 < number < 1.0:
        raise InputRefused(
            f"{name} is {value!r}: give a number between 0 and 1, for example {_LEVELS.get(name, 0.95)}."
        )
    return number


def as_count(name: str, value: float, least: int = 0) -> int:
    """Return one whole number that is at least `least`; raises `InputRefused` otherwise."""
    number = _one(name, value)
    if not math.isfinite(number) or number != int(number) or number < least:
        raise InputRefused(f"{name} is {value!r}: give a whole number of at least {least}.")
    return int(value)


def _one(name: str, value: Any) -> float:
    if type(value) is float:  # nearly always, and asking for the others takes most of the time
        return value
    if isinstance(value, bool | np.bool_ | str | complex | np.complexfloating):
        raise InputRefused(f"{name} is {value!r}: give a number.")
    try:
        return float(value)
    except OverflowError:
        return np.inf
    except (TypeError, ValueError) as error:
        raise InputRefused(f"{name} is {value!r}: give a number.") from error


def _doubles(name: str, values: Any) -> NDArray[np.float64]:
    """Return real numbers of any type as doubles, NaN for missing values."""
    no_number = InputRefused(f"{name} holds something that is not a number: give real numbers only.")
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise no_number from error
    if array.dtype.kind == "O" and array.ndim == 1:
        array = np.array([_double(name, value, no_number) for value in array.tolist()], dtype=np.float64)
    elif array.dtype.kind not in "fiu" or (array.dtype.kind == "O" and array.size):
        raise no_number
    with np.errstate(over="ignore"):  # a long double that is too large becomes infinite and is refused as such
        doubles = array.astype(np.float64)
    if isinstance(values, np.ma.MaskedArray):
        doubles = np.where(np.ma.getmaskarray(values), np.nan, doubles)
    return doubles


def _double(name: str, value: Any, no_number: InputRefused) -> float:
    if type(value).__name__ in NO_VALUE:
        return math.nan
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real | Decimal):
        raise no_number
    try:
        return float(value)
    except OverflowError as error:
        raise InputRefused(f"{name} holds a number beyond 1.8e308: give smaller numbers.") from error
    except ValueError as error:  # a signalling NaN
        raise no_number from error


Labels = Sequence[object] | ArrayLike
"""Names of conditions, days or runs, one for each value: words, numbers or anything with a text of its own."""


def as_labels(name: str, labels: Labels) -> list[str]:
    """Return the texts of labels, shape (n,), numbers that are equal by one name, as 0 and 0.0.

    Raises `InputRefused` for a label that is missing or empty: it would be a condition or a day of its own.
    """
    texts = [_label_text(each) for each in np.asarray(labels, dtype=object).ravel().tolist()]
    if "" in texts:
        raise InputRefused(
            f"{name} holds {texts.count('')} of {len(texts)} labels that are missing, the first at position "
            f"{texts.index('') + 1}: leave missing values out before calling."
        )
    return texts


def _label_text(label: Any) -> str:
    if type(label).__name__ in NO_VALUE or label != label:
        return ""
    if isinstance(label, Real) and float(label).is_integer():
        return str(int(float(label)))
    return str(label) if str(label).strip() else ""
