"""What `labbook sim sweep` does: a scene, changed by words, simulated over a grid or a sample, to a file.

A scene with only the effects that matter: what `--effects auto --within 1%` does to it.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
from collections.abc import Callable
from dataclasses import dataclass, replace

from data_schema.errors import UsageError
from simulator.ablation.corners import Corners, compare_at_corners
from simulator.ablation.smallest import tolerance_of
from simulator.ablation.study import Ablation, ablation_of_effects
from simulator.changes import changed_by_words, without_auto
from simulator.declared import all_parameters, readers
from simulator.scene import Scene, Value
from simulator.scene_file import load_scene
from simulator.sweep.axes import axes_of, ranges_of
from simulator.sweep.design import Design, grid, sobol
from simulator.sweep.sweep import Sweep

SEARCH_ACCURACY = 1e-6
"""The finest accuracy at which the smallest set is searched; the scene is then simulated to the one asked for."""

Step = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Auto:
    """Words for effects without `auto`, and the tolerance that goes with it; None where it was not given."""

    words: str | None
    tolerance: float | None
    accuracy: float

    def ablation(self, scene: Scene, step: Step, required: frozenset[str] = frozenset()) -> Ablation | None:
        """Search the smallest set of the scene's effects, those `required` in it; None without a tolerance.

        `step` is called after each set of effects tried.
        """
        if self.tolerance is None:
            return None
        return ablation_of_effects(scene, self.tolerance, self.accuracy, step, required)


def auto_of(effects: str | None, within: str | None, accuracy: float) -> Auto:
    """Read `--effects` and `--within`; raises `UsageError` for one that misses the other, or is no tolerance."""
    words, auto = without_auto(effects)
    coarser = accuracy if accuracy > SEARCH_ACCURACY else SEARCH_ACCURACY
    if auto and within is None:
        raise UsageError(
            "--effects auto chooses effects by a tolerance: add --within, for example --effects auto --within 1%."
        )
    if within is not None and not auto:
        raise UsageError(f"--within {within} is for effects left out by themselves: add --effects auto.")
    return Auto(words, None if within is None else tolerance_of(within, coarser), coarser)


def reduced_scene(scene: Scene, ablation: Ablation | None) -> Scene:
    """Return the scene with the smallest set of effects that was found, and as it is where none was searched."""
    if ablation is None:
        return scene
    return changed_by_words(scene, effects=",".join(f"-{name}" for name in ablation.smallest.left_out.effects))


@dataclass(frozen=True, slots=True)
class SweepRequest:
    """A scene's name or file and the words that change it, what is swept, and how accurately.

    `sample`: rows of a Sobol sample, drawn with `seed`; without it a grid. `within`: the tolerance, in words, for which
    `auto` among the effects finds the smallest set. `error_bars`: the share of the scenes that have them.
    """

    scene: str
    over: tuple[str, ...]
    sets: tuple[str, ...] = ()
    effects: str | None = None
    accuracy: float = 1e-6
    sample: int | None = None
    seed: int | None = None
    within: str | None = None
    error_bars: float = 0.0


@dataclass(frozen=True, slots=True)
class PlannedSweep:
    """A sweep that can be run; `ablation` is that of the effects, where the smallest set of them was asked for.

    `corners`: how far that set is off at the corners of what is swept, where it leaves anything out.
    """

    sweep: Sweep
    ablation: Ablation | None
    corners: Corners | None = None


def planned_sweep(request: SweepRequest, step: Step) -> PlannedSweep:
    """Return the sweep that is asked for; `step` is called after each set of effects tried, and of each corner.

    The smallest set of effects is that of the scene as it stands, before anything varies; effects that read a swept
    parameter stay. It is compared with all effects at the corners of what is swept. Raises `UsageError` where the sweep
    has no meaning or cannot be simulated.
    """
    given = _with_swept(load_scene(request.scene), request.over)
    auto = auto_of(request.effects, request.within, request.accuracy)
    scene = changed_by_words(given, request.sets, auto.words)
    design = _design(request, scene)
    for axis in design.axes:
        value = scene.values.get(axis.parameter)
        if value is not None and value.set_by_user and value is not given.values.get(axis.parameter):
            raise UsageError(f"{axis.parameter} is both set and swept: leave out one of --set and --over.")
    version = importlib.metadata.version("robot-labbook")
    sweep = Sweep(scene, design, request.accuracy, version, request.error_bars)
    ablation = auto.ablation(scene, step, frozenset(name for axis in design.axes for name in readers(axis.parameter)))
    if ablation is None or not ablation.smallest.left_out.effects:
        return PlannedSweep(sweep, ablation)
    chosen = reduced_scene(scene, ablation)
    corners = compare_at_corners(scene, chosen, design.axes, ablation.accuracy, step)
    return PlannedSweep(replace(sweep, scene=chosen), ablation, corners)


def _with_swept(scene: Scene, over: tuple[str, ...]) -> Scene:
    """Give the scene the first value of each swept parameter that it and the parameter itself have none of."""
    values = dict(scene.values)
    for word in over:
        name, _, numbers = word.partition("=")
        parameter = all_parameters().get(name.strip())
        if parameter is not None and parameter.assumed is None and parameter.name not in values:
            with contextlib.suppress(ValueError):  # what is no number is refused where the axis is read
                first = float(numbers.replace(",", ":").split(":")[0])
                values[parameter.name] = Value(first, why="it is swept")
    return replace(scene, values=values)


def error_bars_of(on_all: bool, share: str | None) -> float:
    """Return the share of the scenes that have error bars, 0 for none; raises `UsageError` for words that are none."""
    if share is None:
        return 1.0 if on_all else 0.0
    text = share.strip()
    try:
        number = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        number = 0.0
    if not 0.0 < number <= 1.0:
        raise UsageError(
            f"--error-bars-on {share} is no share above 0 and at most 100%: write for example --error-bars-on 5%."
        )
    return number


def _design(request: SweepRequest, scene: Scene) -> Design:
    if request.sample is not None:
        return sobol(ranges_of(request.over, scene.effects), request.sample, request.seed or 0)
    if request.seed is not None:
        raise UsageError("--seed draws a sample, and a grid has none: add --sobol COUNT, or leave --seed out.")
    return grid(axes_of(request.over, scene.effects))
