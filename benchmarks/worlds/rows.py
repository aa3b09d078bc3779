"""The table of worlds: 2 000 campaigns of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from benchmarks.worlds import coarse_charger, contrasts, groups, looks, order_in_day, studies
from benchmarks.worlds.world import World, holds, shares_of

WORLDS: tuple[World, ...] = (
    *order_in_day.WORLDS,
    *coarse_charger.WORLDS,
    *looks.WORLDS,
    *groups.WORLDS,
    *contrasts.WORLDS,
    *studies.WORLDS,
)
CAMPAIGNS = 2000


def rows() -> Sequence[Mapping[str, str]]:
    """Simulate every world."""
    found = []
    for world in WORLDS:
        shares = shares_of(world, CAMPAIGNS)
        print(f"{world.name}, {world.truth}: covers {shares.covers}, warns {shares.warns}", flush=True)
        found.append(
            {
                "world": world.name,
                "truth": world.truth,
                "campaigns": str(shares.campaigns),
                "coverage": "" if shares.covers is None else f"{shares.covers:.4f}",
                "finds": f"{shares.finds:.4f}",
                "warns": f"{shares.warns:.4f}",
                "warning_needed": {True: "yes", False: "no", None: ""}[world.warning_needed],
                "holds": "yes" if holds(world, shares) else "no",
            }
        )
    return found
