"""Small sweeps of the second set of simulations, and files that are compared byte by byte."""

from __future__ import annotations

from pathlib import Path

from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.sweep.design import grid, sobol
from simulator.sweep.sweep import SAMPLED, Sweep

ACCURACY = 1e-3


def grid_sweep(
    *over: str, scene: Scene | None = None, accuracy: float = ACCURACY, error_bars: float = SAMPLED
) -> Sweep:
    """A sweep over a grid, of `sim2` where no scene is given."""
    scene = scene or load_scene("sim2")
    return Sweep(scene, grid(over, scene.effects), accuracy, "0.test", error_bars)


def sobol_sweep(rows: int, *over: str, seed: int = 0, error_bars: float = SAMPLED) -> Sweep:
    """A sweep of `sim2` over a sample; without words, of foot and active damping."""
    scene = load_scene("sim2")
    design = sobol(over or ("b_ad=0:300", "foot_radius=0.02:0.04"), scene.effects, rows, seed)
    return Sweep(scene, design, ACCURACY, "0.test", error_bars)


def every_byte(path: Path) -> dict[str, bytes]:
    """The content of a file, or of every file in a folder, by name."""
    if path.is_file():
        return {"": path.read_bytes()}
    return {str(entry.relative_to(path)): entry.read_bytes() for entry in sorted(path.rglob("*")) if entry.is_file()}
