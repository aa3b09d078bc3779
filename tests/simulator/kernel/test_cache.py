"""Compiled kernels on disk: loaded by the next process, never served when the physics has changed, never mixed up."""

from __future__ import annotations

import json
import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numba
import pytest

from data_schema.errors import UsageError
from data_schema.file_cache import CACHE_VARIABLE, cache_folder
from simulator.compiled import compiled
from simulator.jump import simulate
from simulator.kernel.build import kernel_for
from simulator.kernel.cache import KIND, MOST_VERSIONS, fingerprint, keep_on_disk
from simulator.scene_file import load_scene, shipped_scenes
from tests.helpers.kernels import ROOT, python
from tests.helpers.wording import refuses

SMALL = """
import json, sys
import numba, numpy as np
from data_schema.errors import UsageError
from simulator.compiled import compiled
from simulator.kernel.cache import give_unique_symbols, keep_on_disk
from simulator.kernel.composition import compose
from simulator.kernel.layout import K1, K4, MECHANICAL, NOW, PARAMETERS, V_BODY, X_BODY
from simulator.kernel.mechanics.leg import make_set_gains
from simulator.kernel.mechanics.motion import make_rates
from simulator.kernel.steps.attempt import make_runge_kutta

def kernel_of(effects):
    composition = compose(effects)
    give_unique_symbols(composition.effects)
    rates_of, set_gains = make_rates(composition), make_set_gains(composition)
    step = make_runge_kutta(composition, rates_of)

    @compiled
    def kernel(work):
        set_gains(work, False, 0.0)
        rates_of(0.0, 0.0, work, NOW, K1)
        step(0.0, 0.0, 1e-3, work)

    keep_on_disk(kernel, composition.effects)
    kernel.compile((numba.float64[::1],))
    work = np.zeros(composition.row_size)
    work[PARAMETERS:] = 1.0
    work[NOW + X_BODY], work[NOW + V_BODY] = 0.5, 2.0
    return kernel, work

made = [kernel_of(effects.split(",")) for effects in sys.argv[1:]]
found = []
for kernel, work in made:
    kernel(work)
    found.append([work[K1 + V_BODY], work[K4 + MECHANICAL + 1], sum(kernel.stats.cache_hits.values())])
print(json.dumps(found))
"""
"""One step alone as a kernel: compiled in seconds, and with a function of its own, whose name another kernel's could
share. The body's acceleration and the power of heat or drag tell which effects, and which version of them, made it."""

DAMPED = "rigid_ground,touchdown_impact,leg_damping"
HEATED, DRAGGED = f"{DAMPED},motor_heat", f"{DAMPED},drag"


class Found(NamedTuple):
    """What a small kernel gives, and how often it was found on disk."""

    acceleration_m_s2: float
    power_w: float
    loaded: int


def small(cache: Path, *effects: str, folder: Path = ROOT) -> list[Found]:
    """Small kernels with these effects, made in one process in this order."""
    lines = json.loads(python(["-c", SMALL, *effects], folder=folder, LABBOOK_CACHE=str(cache)))
    return [Found(*line) for line in lines]


# a_b = -(k (r - l) + b v_r) / m_b - g
DAMPED_M_S2 = 0.5 - 2.0 - 9.81
TWICE_DAMPED_M_S2 = 0.5 - 4.0 - 9.81


def stamps(cache: Path) -> dict[Path, tuple[int, int]]:
    """Every kernel's identity and time of its last change."""
    return {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in cache.rglob("*.nb?")}


@pytest.fixture(scope="module")
def cached(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Found, Found]:
    """A cache folder with two kernels, each compiled by a process of its own, and what they gave there."""
    cache = tmp_path_factory.mktemp("kernels")
    with ThreadPoolExecutor(2) as pool:
        heated, dragged = pool.map(lambda effects: small(cache, effects)[0], (HEATED, DRAGGED))
    assert not heated.loaded
    assert not dragged.loaded
    return cache, heated, dragged


def test_kernels_of_different_processes_are_not_mixed_up_in_a_third(cached: tuple[Path, Found, Found]) -> None:
    """Symbols are counted from 1 in each process; two kernels must not share a name for different functions."""
    cache, heated, dragged = cached
    assert heated[0] == dragged[0] == pytest.approx(DAMPED_M_S2)
    assert heated[1] != pytest.approx(dragged[1], rel=0.1)
    before = stamps(cache)
    found = small(cache, DRAGGED, HEATED)
    assert [one[:2] for one in found] == [dragged[:2], heated[:2]]
    assert all(one.loaded for one in found)
    assert stamps(cache) == before


def copied(folder: Path) -> Path:
    """The simulator's sources in another folder."""
    for package in ("simulator", "data_schema"):
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def test_edited_physics_is_compiled_anew_and_the_old_kept_apart(
    cached: tuple[Path, Found, Found], tmp_path: Path
) -> None:
    """The edited file is not that of the kernel, where the compiler's own cache would look."""
    folder = copied(tmp_path / "edited")
    effect = folder / "simulator" / "effects" / "leg_damping.py"
    text = effect.read_text(encoding="utf-8")
    assert text.count("p[compression]") == 1
    effect.write_text(text.replace("p[compression]", "2.0 * p[compression]"), encoding="utf-8")
    cache = cached[0]
    before = stamps(cache)
    (edited,) = small(cache, HEATED, folder=folder)
    assert edited.acceleration_m_s2 == pytest.approx(TWICE_DAMPED_M_S2)
    assert not edited.loaded
    after = stamps(cache)
    assert {path: after[path] for path in before} == before
    assert fingerprint(folder / "simulator") != fingerprint()


def test_every_source_counts(tmp_path: Path) -> None:
    sources = copied(tmp_path) / "simulator"
    assert fingerprint(sources) == fingerprint()
    seen = {fingerprint()}
    for path in ("kinematics.py", "effects/cone.py", "kernel/run.py"):
        (sources / path).write_bytes((sources / path).read_bytes() + b"\n")
        seen.add(fingerprint(sources))
    (sources / "effects" / "cone.py").rename(sources / "effects" / "pile.py")
    assert len({*seen, fingerprint(sources)}) == 5


def test_old_versions_go_and_what_is_not_a_version_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    cache = cache_folder(KIND)
    olds = [cache / f"{number:020x}" for number in range(5)]
    others = [tmp_path / "thesis", cache / "photographs"]
    for age, folder in enumerate(reversed(olds + others)):
        folder.mkdir(parents=True)
        (folder / "file").write_text("kept", encoding="utf-8")
        os.utime(folder, (1e9 - age, 1e9 - age))
    keep_on_disk(compiled(lambda number: number), ("any",))
    assert [folder.exists() for folder in olds] == [False] * (6 - MOST_VERSIONS) + [True] * (MOST_VERSIONS - 1)
    assert (cache / fingerprint()).is_dir()
    assert [folder.exists() for folder in others] == [True, True]


def twice() -> tuple[float, bool]:
    """What the least of kernels gives for 3, and whether it was found on disk."""
    kernel: Any = compiled(lambda number: 2.0 * number)
    keep_on_disk(kernel, ("any",))
    kernel.compile((numba.float64,))
    return kernel(3.0), bool(kernel.stats.cache_hits)


def test_a_cache_that_cannot_be_written_costs_time_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file where the folder should be, and a folder in which nobody can make a file."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    no_files = Path("/proc/self")
    if not no_files.is_dir():
        pytest.skip("there is no folder that refuses files whoever asks")
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "refusing"))
    version = cache_folder(KIND) / fingerprint()
    version.parent.mkdir(parents=True)
    version.symlink_to(no_files)
    for name in ("file", "refusing"):
        monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / name))
        assert twice() == (6.0, False)


@pytest.mark.parametrize("shared_with", ["everyone", "the group", "somebody else"])
@pytest.mark.parametrize("place", ["", "labbook-kernels", "labbook-kernels/{}", "labbook-kernels/{}/kernel.nbi"])
def test_a_cache_that_others_may_write_to_is_refused(
    place: str, shared_with: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = tmp_path / "cache"
    monkeypatch.setenv(CACHE_VARIABLE, str(cache))
    before = os.umask(0o002)
    try:
        keep_on_disk(compiled(lambda number: number), ("any",))
    finally:
        os.umask(before)
    (cache_folder(KIND) / fingerprint() / "kernel.nbi").touch(0o644)
    keep_on_disk(compiled(lambda number: number), ("any",))
    shared = cache / place.format(fingerprint())
    if shared_with != "somebody else":
        shared.chmod(shared.stat().st_mode | (0o002 if shared_with == "everyone" else 0o020))
    elif os.geteuid() == 0:
        os.chown(shared, 65534, -1)
    else:
        pytest.skip("only root can give a file away")
    with refuses(UsageError, "put any program") as refused:
        keep_on_disk(compiled(lambda number: number), ("any",))
    assert repr(str(shared)) in str(refused.value)


def test_a_cache_in_a_folder_for_all_is_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tmp_path.chmod(0o1777)
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    keep_on_disk(compiled(lambda number: number), ("any",))
    assert (cache_folder(KIND) / fingerprint()).is_dir()


@pytest.mark.parametrize("suffix", [".nbc", ".nbi"])
def test_a_damaged_file_costs_time_only(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    assert [twice(), twice()] == [(6.0, False), (6.0, True)]
    (damaged,) = tmp_path.rglob(f"*{suffix}")
    damaged.write_bytes(damaged.read_bytes()[:100])
    assert [twice(), twice()] == [(6.0, False), (6.0, True)]


WHOLE = """
import json, sys
from simulator.jump import simulate
from simulator.kernel.build import kernel_for
from simulator.scene_file import load_scene
found, loaded = [], []
for name in sys.argv[1:]:
    changed = load_scene(name).changed(jumps=1)
    hits = kernel_for(changed.effects).batch.stats.cache_hits
    jump = simulate(changed, 1e-9).jump
    found.append([jump.apex_height_m, jump.cost_J])
    loaded.append(bool(sum(hits.values())))
print(json.dumps([found, loaded]))
"""


def test_a_second_process_loads_what_the_first_has_compiled() -> None:
    """And many kernels together: all shipped scenes in one process, the last compiled first."""
    scenes = shipped_scenes()
    wanted = []
    for name in scenes:
        scene = load_scene(name).changed(jumps=1)
        kernel_for(scene.effects)
        jump = simulate(scene, 1e-9).jump
        wanted.append([jump.apex_height_m, jump.cost_J])
    numbers, loaded = json.loads(python(["-c", WHOLE, *reversed(scenes)]))
    assert numbers == wanted[::-1]
    assert all(loaded)
