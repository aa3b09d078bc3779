"""Entries beside the kernel's own, kept on disk with it: of processes that want one at once, one compiles it."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.helpers.kernels import ROOT, python

ENTRY = """
import math

def entry(number):
    total = 0.0
    for place in range(10):
        total += math.sin(place * number) * math.cos(place + number) + math.atan2(number, place + 1.0)
    return total
"""
WANTED = """
import json, math, sys, time
from pathlib import Path
import numba
from simulator.kernel.cache import cached_entry
sys.path.insert(0, sys.argv[1])
from kept_entry import entry
(here := Path(sys.argv[1]) / f"ready{sys.argv[2]}").touch()
while len(list(here.parent.glob("ready*"))) < 2:
    time.sleep(0.001)
found = cached_entry(entry, (numba.float64,), "entry", ("drag",))
print(json.dumps([math.isclose(found(0.5), entry(0.5)), bool(sum(found.stats.cache_hits.values()))]))
"""


def test_of_two_processes_at_once_one_compiles_and_the_other_waits_and_loads(tmp_path: Path) -> None:
    (tmp_path / "kept_entry.py").write_text(ENTRY, encoding="utf-8")
    cache = str(tmp_path / "cache")

    def wanted(number: str) -> list[bool]:
        right: list[bool] = json.loads(
            python(["-c", WANTED, str(tmp_path), number], folder=ROOT, LABBOOK_CACHE=cache, PYTHONDONTWRITEBYTECODE="1")
        )
        return right

    with ThreadPoolExecutor(2) as pool:
        found = sorted(pool.map(wanted, ("1", "2")))
    assert found == [[True, False], [True, True]]
    for kind in ("*.nbi", "*.nbc"):
        assert len(list((tmp_path / "cache").rglob(kind))) == 1
