"""Other programs by name, loaded when they are asked: some are needed by nothing else here and may be missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.stats_evidence.weaknesses.case import Peer


def module(name: str) -> Any:
    """Return a module; raises `ModuleNotFoundError` where it is not installed."""
    return import_module(name)


def pingouin() -> Any:
    """Return pingouin."""
    return module("pingouin")


def scipy_stats() -> Any:
    """Return scipy.stats."""
    return module("scipy.stats")


def weightstats() -> Any:
    """Return statsmodels' module of t-tests."""
    return module("statsmodels.stats.weightstats")


def sm_oneway(groups: Sequence[ArrayLike], use_var: str = "unequal") -> Any:
    """Return statsmodels' one-way analysis of variance."""
    return module("statsmodels.stats.oneway").anova_oneway(groups, use_var=use_var)


def frame(groups: Mapping[str, ArrayLike]) -> Any:
    """Return groups in the long format, a frame with columns "y" and "group"."""
    names = np.repeat(list(groups), [np.size(values) for values in groups.values()])
    return module("pandas").DataFrame({"y": np.concatenate(list(groups.values())), "group": names})


scipy = partial(Peer, "scipy")
statsmodels = partial(Peer, "statsmodels")
pg = partial(Peer, "pingouin")
numpy = partial(Peer, "numpy")
xarray = partial(Peer, "xarray")
sklearn = partial(Peer, "scikit-learn")
