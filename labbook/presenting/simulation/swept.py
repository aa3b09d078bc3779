"""A finished sweep as lines for people and as data for programs.

How far the smallest set of effects is off at the corners of a sweep, in a sentence and as data.
"""

from __future__ import annotations

from typing import Any

from data_schema.vocabulary import Undefined
from labbook.presenting.simulation.effects_ablation import difference_data, difference_text, percent
from labbook.presenting.simulation.simulated import set_by_user_line
from reports.display import time_text
from simulator.ablation.corners import Corners
from simulator.ablation.outputs import Difference
from simulator.ablation.study import Ablation
from simulator.error_bars import finer_accuracy
from simulator.sweep.run import Finished


def sweep_data(done: Finished) -> dict[str, Any]:
    """Return what a sweep made, for JSON; `jump_time_us` is None where no jump was simulated now.

    `jumps`: those that were made, without those of refused scenes and those after a scene's last.
    """
    scene, chunks = done.sweep.scene, done.sweep.chunks
    return {
        "out": str(done.out),
        "scene": scene.name,
        "dims": done.sweep.dims,
        "jumps": done.summary.jumps,
        "variables": len(done.sweep.outputs),
        "accuracy": done.sweep.accuracy,
        "error_bars": {"share": done.sweep.error_bars, "scenes": done.sweep.n_with_error_bars},
        "sampling": done.sweep.design.description,
        "outcomes": done.summary.outcomes,
        "refused": {"scenes": done.sweep.refusals.count, "why": done.sweep.refused or None},
        **done.summary.flagged,
        "assumed": {name: scene.values[name].why for name in done.sweep.assumed},
        "set_by_user": {name: scene[name] for name in scene.set_by_user},
        "chunks": chunks.count,
        "chunks_before": done.chunks_before,
        "compile_time_s": done.compile_time_s,
        "compute_time_s": done.compute_time_s,
        "write_time_s": done.write_time_s,
        "in_lanes": done.why_scalar is None if done.jumps_made else None,
        "jump_time_us": 1e6 * done.compute_time_s / done.jumps_made if done.jumps_made else None,
    }


def sweep_lines(done: Finished) -> list[str]:
    """Return the lines for people, with the assumed parameters."""
    data = sweep_data(done)
    dims = " x ".join(f"{name} ({length})" for name, length in done.sweep.dims.items())
    outcomes = ", ".join(f"{name} {count}" for name, count in done.summary.outcomes.items())
    assumed = [f"{name} is assumed: {why}" for name, why in data["assumed"].items()]
    return [
        f"{done.sweep.scene.name}: {_jumps(data['jumps'])} over {dims}, {data['sampling']}.",
        *([f"note: {done.sweep.refused}"] if done.sweep.refused else []),
        f"outcomes: {outcomes}; ill-conditioned: {data['ill_conditioned']}.",
        *_error_bars(done),
        *_warnings(done),
        *set_by_user_line(done.sweep.scene),
        *assumed,
        _how(done),
        f"{done.out}: {data['variables']} variables, for xarray.{_opener(done)}({str(done.out)!r}).",
    ]


def _error_bars(done: Finished) -> list[str]:
    sweep = done.sweep
    if not sweep.error_bars:
        return []
    return [
        f"error bars: on {sweep.n_with_error_bars} of {sweep.legal_rows} scenes, simulated again to "
        f"{finer_accuracy(sweep.accuracy):g} or finer; there the columns NAME_error hold them, and ill_conditioned is "
        "by them."
    ]


def _warnings(done: Finished) -> list[str]:
    """Say of how many jumps a number is none that a robot could have, or none that is as accurate as was asked for."""
    under, unclosed = (_jumps(done.summary.flagged[flag]) for flag in ("under_surface", "open_book"))
    sentences = {
        "under_surface": f"warning: in {under} the body gets under the surface of the grains, which act on the foot "
        "alone, so that no robot jumps like this (under_surface in the file).",
        "open_book": f"warning: in {unclosed} the energy book does not close within the accuracy, and the numbers may "
        "be off by more than was asked for (open_book in the file).",
    }
    return [sentence for flag, sentence in sentences.items() if done.summary.flagged[flag]]


def _how(done: Finished) -> str:
    made, jumps = done.jumps_made, done.summary.jumps
    if not made:
        return "nothing was left to simulate."
    beside = "side by side in lanes" if done.why_scalar is None else f"one after the other ({done.why_scalar})"
    earlier = f"; {jumps - made} of {_jumps(jumps)} were there from before" if made < jumps else ""
    return (
        f"{time_text(done.compute_time_s)}, {time_text(done.compute_time_s / made)} a jump, {beside}, for a relative "
        f"error of {done.sweep.accuracy:g}; {done.write_time_s:.2g} s for the file, after {done.compile_time_s:.2g} s "
        f"of compiling{earlier}."
    )


def _jumps(count: int) -> str:
    return "1 jump" if count == 1 else f"{count} jumps"


def _opener(done: Finished) -> str:
    return "open_zarr" if done.out.suffix == ".zarr" else "open_dataset"


def corners_lines(corners: Corners | None, ablation: Ablation | None) -> list[str]:
    """Say where the set is farthest off and by how much; beyond the tolerance it is a warning with what to do.

    Nothing where no set was chosen or nothing was left out.
    """
    if corners is None or ablation is None:
        return []
    worst = corners.worst
    if worst is None:
        return [
            "warning: at no corner of what is swept can all effects be simulated, and the set was not checked there."
        ]
    left_out = f" ({corners.refused} more cannot be simulated)" if corners.refused else ""
    at = ", ".join(f"{name} = {number:g}" for name, number in worst.at.items())
    where = f"Of {len(corners.compared)} corners of what is swept{left_out}, the set is farthest off at {at}"
    ended = _ended(worst.difference)
    changed = f"it changes {difference_text(worst.difference, ablation)}"
    changed = changed if ended is None else f"the jump ends otherwise than with all effects ({ended})"
    found = f"{where}: there {changed}."
    if worst.difference.within(ablation.tolerance):
        return [found]
    return [
        f"warning: the chosen set of effects does not stay within {percent(ablation.tolerance)} in all of this sweep. "
        f"{found} Sweep less far, give a smaller --within, or name the effects instead of auto."
    ]


def corners_data(corners: Corners | None, ablation: Ablation | None) -> dict[str, Any]:
    """Return the worst corner for JSON; nothing where no set was chosen or nothing was left out."""
    if corners is None or ablation is None:
        return {}
    worst = corners.worst
    at_worst = worst and {
        "at": dict(worst.at),
        **difference_data(worst.difference),
        "undefined": _ended(worst.difference),
    }
    return {
        "corners": {
            "compared": len(corners.compared),
            "refused": corners.refused,
            "worst": at_worst,
            "within": worst is not None and worst.difference.within(ablation.tolerance),
        }
    }


def _ended(difference: Difference) -> str | None:
    """Return how the jump ended where that is not how it ends with all effects."""
    return next((change.reason for change in difference.changes if isinstance(change, Undefined)), None)
