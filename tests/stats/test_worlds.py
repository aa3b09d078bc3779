"""What the first page says of simulated campaigns, on a few of each world (in a soak, of all); the table has 2 000."""

import pytest

from benchmarks.statistics_document import SHOWN_WORLDS
from benchmarks.worlds.rows import WORLDS
from benchmarks.worlds.world import World, holds, shares_of

FEW = 60
OFF = 0.12
"""Four standard errors of a share of .95 over so few campaigns."""


SHOWN = {name for name, _truth in SHOWN_WORLDS} | {
    "force plate, days of 8, 4, 2, 2 runs, days scatter by 1 %",
    "characterisation, errors with a lag-1 correlation of 0.8",
    "compaction, 5 flasks, quadratic term 0.5",
    "emulator, 4 days, savings on a curve",
}
"""Those of the page, and one of each other study."""


@pytest.mark.parametrize(
    "world",
    [pytest.param(one, marks=() if one.name in SHOWN else pytest.mark.soak) for one in WORLDS],
    ids=lambda world: f"{world.name}, {world.truth}",
)
def test_a_reader_is_not_misled(world: World) -> None:
    shares = shares_of(world, FEW)
    assert holds(world, shares, OFF), shares
