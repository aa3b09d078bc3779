"""What the first page says of simulated campaigns, on a few of each world; the table has 2 000."""

import pytest

from benchmarks.worlds.rows import WORLDS
from benchmarks.worlds.world import World, holds, shares_of

FEW = 60
OFF = 0.12
"""Four standard errors of a share of .95 over so few campaigns."""


@pytest.mark.parametrize("world", WORLDS, ids=lambda world: f"{world.name}, {world.truth}")
def test_a_reader_is_not_misled(world: World) -> None:
    shares = shares_of(world, FEW)
    assert holds(world, shares, OFF), shares
