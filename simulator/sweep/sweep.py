"""A sweep: a scene, what of it is varied, and how accurately; which of its scenes cannot be; what identifies it."""

from __future__ import annotations

import contextlib
import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.changes import changed_by_words
from simulator.declared import all_parameters
from simulator.effects.registry import EFFECTS
from simulator.error_bars import finer_accuracy
from simulator.kernel.rows import Output
from simulator.scene import RULES, Scene, Value
from simulator.scene_file import load_scene, write_scene
from simulator.sweep.chunks import ERRORS, OUTPUTS, REFUSED, SAMPLED_ERROR, simulator_here
from simulator.sweep.design import Axis, Design, grid, sobol

JUMP = "jump"
"""Dimension of the jumps of scenes that have several."""
FEWEST_JUMPS, MOST_JUMPS, CHUNKS_WANTED = 128, 2048, 64
"""Jumps in a chunk: many enough to be worth a file, few enough that little is lost when a machine stops."""
Flags = NDArray[np.bool_]
_BLOCK = 65_536
SAMPLED, FEWEST_SAMPLED = 0.05, 20
"""Share of a sweep's scenes that have error bars where nothing else is asked for, and about their least number."""
_MIX = np.uint64(0xD6E8FEB86659FD93)
"""Odd, so that it mixes the number of a row to one that looks drawn by chance: no axis of a grid falls in step."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """A sweep that can be run; scenes whose values do not fit together are left out of it, and marked as refused.

    `error_bars` is the share of its scenes that are simulated again, a hundred times finer: all at 1, none at 0.
    `labbook` is the version of the program that made it, stored with the result; `refused`, shape (rows,): the scenes
    that cannot be simulated, `why_refused` how many these are and why, in a sentence. Raises `UsageError` for an axis
    that nothing reads or that leaves its parameter's range, where every scene would be refused, and for error bars that
    cannot be.
    """

    scene: Scene
    design: Design
    accuracy: float = 1e-6
    labbook: str = ""
    error_bars: float = SAMPLED
    refused: Flags = field(init=False, repr=False, compare=False)
    why_refused: str = field(init=False, compare=False)

    def __post_init__(self) -> None:
        _check_axes(self.scene, self.design)
        nothing_finer = finer_accuracy(self.accuracy) >= self.accuracy
        if nothing_finer and self.error_bars < 1.0:
            object.__setattr__(self, "error_bars", 0.0)
        elif nothing_finer:
            raise UsageError(
                f"nothing is simulated finer than an accuracy of {self.accuracy:g}, which error bars take: ask for a "
                "coarser one, or for no error bars."
            )
        refused, first = refused_rows(self.scene, self.design)
        count = int(refused.sum())
        if count == len(refused):
            raise UsageError(f"no scene of the sweep can be simulated: it comes to {first}")
        sentence = (
            f"{count} of {len(refused)} scenes cannot be simulated and {'is' if count == 1 else 'are'} marked "
            f"{REFUSED}, the first at {first}"
        )
        object.__setattr__(self, "refused", refused)
        object.__setattr__(self, "why_refused", sentence if count else "")

    @property
    def jumps_wanted(self) -> int:
        """How many jumps are simulated, where all scenes make theirs."""
        return int((~self.refused).sum()) * self.scene.jumps

    @property
    def rows_each(self) -> int:
        """The number of rows in a chunk; the last may have fewer."""
        jumps = self.design.row_count * self.scene.jumps
        wanted = min(MOST_JUMPS, max(FEWEST_JUMPS, math.ceil(jumps / CHUNKS_WANTED)))
        return max(1, wanted // self.scene.jumps)

    @property
    def chunks(self) -> list[slice]:
        """The rows of each chunk."""
        rows, each = self.design.row_count, self.rows_each
        return [slice(start, min(start + each, rows)) for start in range(0, rows, each)]

    @property
    def dims(self) -> dict[str, int]:
        """Dimensions of the result and their lengths."""
        jumps = {JUMP: self.scene.jumps} if self.scene.jumps > 1 else {}
        return {**self.design.dims, **jumps}

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What it gives for each jump."""
        barred = ERRORS if self.error_bars >= 1.0 else (SAMPLED_ERROR,) if self.error_bars else ()
        return (*OUTPUTS, *barred)

    def barred(self, rows: slice) -> Flags:
        """Which of these rows have error bars: a share of all, as good as drawn by chance, and about 20 at least."""
        share = max(self.error_bars, FEWEST_SAMPLED / self.design.row_count) if self.error_bars else 0.0
        mixed = np.arange(rows.start, rows.stop, dtype=np.uint64) * _MIX
        mixed = (mixed ^ mixed >> np.uint64(32)) * _MIX
        return np.asarray(mixed / 2.0**64 < share)

    @property
    def assumed(self) -> tuple[str, ...]:
        """Names of the parameters without a source that the result depends on; what is swept is not assumed."""
        swept = {axis.parameter for axis in self.design.axes}
        return tuple(name for name in self.scene.assumed if name not in swept)


def sweep_by_words(
    scene: str,
    over: Sequence[str],
    sets: Sequence[str] = (),
    effects: str | None = None,
    *,
    accuracy: float = 1e-6,
    sample: int | None = None,
    seed: int | None = None,
    error_bars: float = SAMPLED,
    labbook: str = "",
) -> Sweep:
    """Return the sweep of a scene (its name or file), changed by words, over a grid or a Sobol sample of `sample` rows.

    Raises `UsageError` where the sweep has no meaning or cannot be simulated.
    """
    given = _with_swept(load_scene(scene), over)
    changed = changed_by_words(given, sets, effects)
    if sample is not None:
        design = sobol(over, changed.effects, sample, seed or 0)
    elif seed is not None:
        raise UsageError("--seed draws a sample, and a grid has none: add --sobol COUNT, or leave --seed out.")
    else:
        design = grid(over, changed.effects)
    for axis in design.axes:
        value = changed.values.get(axis.parameter)
        if value is not None and value.set_by_user and value is not given.values.get(axis.parameter):
            raise UsageError(f"{axis.parameter} is both set and swept: leave out one of --set and --over.")
    return Sweep(changed, design, accuracy, labbook, error_bars)


def _with_swept(scene: Scene, over: Sequence[str]) -> Scene:
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


def _check_axes(scene: Scene, design: Design) -> None:
    """Raise `UsageError`, with one sentence, for an axis that nothing reads or that leaves its parameter's range."""
    for swept in design.axes:
        parameter = all_parameters()[swept.parameter]
        extremes = (float(swept.values.min()), float(swept.values.max()))
        outside = [number for number in extremes if not parameter.low <= number <= parameter.high]
        if outside or swept.parameter not in scene.read:
            scene.changed({swept.parameter: (outside or extremes)[0]})  # which refuses it in the scene's own words


def refused_rows(scene: Scene, design: Design) -> tuple[Flags, str]:
    """Return which rows break a rule, shape (rows,), and the first of them in words with its fault, empty where none.

    A rule is asked once for each combination of the swept values that it reads.
    """
    plain = {name: value.value for name, value in scene.values.items()}
    refused, first = np.zeros(tuple(design.dims.values()), np.bool_), ""
    for rule in RULES:
        axes = tuple(axis for axis in design.axes if axis.parameter in rule.reads)
        if not axes or not rule.effects <= scene.effects:
            continue
        part = Design(axes, design.seed)
        breaks, names = np.zeros(part.row_count, np.bool_), [axis.parameter for axis in axes]
        for start in range(0, part.row_count, _BLOCK):
            rows = part.rows(start, min(start + _BLOCK, part.row_count))
            met = rule.met({**plain, **dict(zip(names, rows.T, strict=True))})
            for place in np.flatnonzero(np.logical_not(met)):
                point = dict(zip(names, rows[place].tolist(), strict=True))
                fault = rule.fault({**plain, **point})
                if fault is not None:
                    breaks[start + place] = True
                    first = first or f"{', '.join(f'{name} = {number:g}' for name, number in point.items())}: {fault}"
        if design.seed is None:
            breaks = breaks.reshape([len(axis.values) if axis in axes else 1 for axis in design.axes])
        refused |= breaks
    return refused.ravel(), first


Identity = Mapping[str, str | float]
FORMAT = 3
"""Version of how sweeps are stored."""
_FOLLOWING = ("swept values", "text of the scene", "outputs", "chunk")
"""What says nothing to a person, and differs for itself only where nothing readable does."""


def identity_of(sweep: Sweep) -> dict[str, str | float]:
    """Return all that a sweep's numbers depend on, readable; equal for equal commands and simulators."""
    scene, design = sweep.scene, sweep.design
    return {
        "scene": scene.name,
        "effects": ", ".join(name for name in EFFECTS if name in scene.effects),
        "jumps": scene.jumps,
        **{name: value.value for name, value in scene.values.items()},
        "accuracy": sweep.accuracy,
        "error bars": f"{100.0 * sweep.error_bars:g} %",
        "sampling": design.description,
        **{f"sweep of {axis.name}": _extent(axis) for axis in design.axes},
        "swept values": design.content_hash()[:20],
        "text of the scene": hashlib.sha256(write_scene(scene).encode()).hexdigest()[:20],
        "chunk": sweep.rows_each,
        "outputs": hashlib.sha256(" ".join(output.name for output in sweep.outputs).encode()).hexdigest()[:20],
        "simulator": simulator_here(),
        "labbook": sweep.labbook,
        "format": FORMAT,
    }


def differences(there: Identity, now: Identity) -> str:
    """Return in words the first few things that differ; empty where nothing does."""
    names = [name for name in dict.fromkeys((*now, *there)) if there.get(name) != now.get(name)]
    readable = [name for name in names if name not in _FOLLOWING][:3]
    changed = [f"{name} ({_shown(there.get(name))} there, {_shown(now.get(name))} now)" for name in readable]
    return " and ".join(changed or names)


def _extent(axis: Axis) -> str:
    return f"{len(axis.values)} values from {axis.coordinates.min():.9g} to {axis.coordinates.max():.9g}"


def _shown(value: str | float | None) -> str:
    if value is None:
        return "none"
    return f"{value:.9g}" if isinstance(value, float) else str(value)
