"""The order in which conditions are listed: that of the factors' levels, the swept factor last.

So the control and the treated conditions of one group stand together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from labbook.analysis.comparison import pairing
from labbook.config.model import Configuration


def place(known: Mapping[str, Sequence[str]], swept: str | None, levels: Mapping[str, str]) -> list[int]:
    """Return what sorts a condition with these levels; `known` has the labels of each factor in their order.

    A level that a condition has not comes first, one that is not known last.
    """
    factors = sorted(known, key=lambda name: name == swept)
    return [_position(known[name], levels[name]) if name in levels else -1 for name in factors]


def place_configured(configuration: Configuration, levels: Mapping[str, str]) -> list[int]:
    """Return what sorts a condition by the factors and levels of labbook.toml."""
    known = {name: [level.label for level in factor.levels] for name, factor in configuration.factors.items()}
    return place(known, pairing.swept_factor(configuration), levels)


def _position(labels: Sequence[str], label: str) -> int:
    return labels.index(label) if label in labels else len(labels)
