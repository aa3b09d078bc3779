"""One function of labbook, and what a user of another program calls for the same fields."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SEED = 4
SCIPY, STATSMODELS, PINGOUIN, BARE = "scipy", "statsmodels", "pingouin", "bare call"


@dataclass(frozen=True, slots=True)
class Inputs:
    """Samples of n values each, the same for every program, in the form that each takes."""

    n: int
    a: Floats
    b: Floats
    c: Floats
    """Shape (n,), normal."""
    y: Floats
    """Shape (n,), a line over `a` with scatter."""

    @property
    def tenths(self) -> Floats:
        """Of `a`, in whole numbers, shape (n,): a line over them is exact in doubles."""
        return np.round(10.0 * self.a)

    @property
    def groups(self) -> dict[str, Floats]:
        """The three samples by name."""
        return {"a": self.a, "b": self.b, "c": self.c}

    def frame(self) -> pd.DataFrame:
        """Return the three samples one under the other."""
        return pd.DataFrame({"y": np.concatenate([self.a, self.b, self.c]), "g": np.repeat(["a", "b", "c"], self.n)})


def inputs(n: int) -> Inputs:
    """Draw samples of n values."""
    a, b, c, scatter = np.random.default_rng(SEED).normal(0.0, 1.0, (4, n))
    return Inputs(n, a, b + 0.3, c, 3.0 * a + scatter)


Call = Callable[[], object]
Prepared = Callable[[Inputs], Call]
"""What is timed is the call; to bring the data into a program's form is not."""


@dataclass(frozen=True, slots=True)
class Peer:
    """What is called instead, and which of labbook's fields that gives."""

    program: str
    """One of the programs above; a bare call gives fewer fields, and no budget is judged by it."""
    what: str
    prepared: Prepared


@dataclass(frozen=True, slots=True)
class Case:
    """One row of the tables."""

    name: str
    labbook: Prepared
    peers: tuple[Peer, ...] = field(default=())
    sizes: tuple[int, ...] = (25, 100, 1000, 10_000)
