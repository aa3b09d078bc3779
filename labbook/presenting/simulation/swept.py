"""A finished sweep as lines for people and as data for programs."""

from __future__ import annotations

from typing import Any

from labbook.presenting.durations import time_text
from labbook.presenting.simulation.simulated import set_by_user_line
from simulator.sweep.outputs import OUTPUTS
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
        "variables": len(OUTPUTS),
        "accuracy": done.sweep.accuracy,
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
        "jump_time_us": 1e6 * done.compute_time_s / done.jumps_made if done.jumps_made else None,
    }


def sweep_lines(done: Finished) -> list[str]:
    """Return the lines that people read, with what the numbers rest on."""
    data = sweep_data(done)
    dims = " x ".join(f"{name} ({length})" for name, length in done.sweep.dims.items())
    outcomes = ", ".join(f"{name} {count}" for name, count in done.summary.outcomes.items())
    assumed = [f"{name} is assumed: {why}" for name, why in data["assumed"].items()]
    return [
        f"{done.sweep.scene.name}: {_jumps(data['jumps'])} over {dims}, {data['sampling']}.",
        *([f"note: {done.sweep.refused}"] if done.sweep.refused else []),
        f"outcomes: {outcomes}; ill-conditioned: {data['ill_conditioned']}.",
        *_warnings(done),
        *set_by_user_line(done.sweep.scene),
        *assumed,
        _how(done),
        f"{done.out}: {data['variables']} variables, for xarray.{_opener(done)}({str(done.out)!r}).",
    ]


def _warnings(done: Finished) -> list[str]:
    """Say of how many jumps a number is none that a robot could have, or none that is as accurate as was asked for."""
    under, unclosed = (_jumps(done.summary.flagged[flag]) for flag in ("under_surface", "open_book"))
    said = {
        "under_surface": f"warning: in {under} the body gets under the surface of the grains, which act on the foot "
        "alone, so that no robot jumps like this (under_surface in the file).",
        "open_book": f"warning: in {unclosed} the energy book does not close within the accuracy, and the numbers may "
        "be off by more than was asked for (open_book in the file).",
    }
    return [sentence for flag, sentence in said.items() if done.summary.flagged[flag]]


def _how(done: Finished) -> str:
    made, jumps = done.jumps_made, done.summary.jumps
    if not made:
        return "nothing was left to simulate."
    kept = f"; {jumps - made} of {_jumps(jumps)} were there from before" if made < jumps else ""
    return (
        f"{time_text(done.compute_time_s)}, {time_text(done.compute_time_s / made)} a jump, for a relative error "
        f"of {done.sweep.accuracy:g}; {done.write_time_s:.2g} s for the file, after {done.compile_time_s:.2g} s of "
        f"compiling{kept}."
    )


def _jumps(count: int) -> str:
    return "1 jump" if count == 1 else f"{count} jumps"


def _opener(done: Finished) -> str:
    return "open_zarr" if done.out.suffix == ".zarr" else "open_dataset"
