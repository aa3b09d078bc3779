"""A finished sweep as lines for people and as data for programs."""

from __future__ import annotations

from typing import Any

from labbook.presenting.simulation.simulated import set_by_user_line
from reports.display import count_text, list_text, time_text
from simulator.error_bars import finer_accuracy
from simulator.sweep.chunks import NEVER_ROSE
from simulator.sweep.run import Finished, Summary
from simulator.sweep.sweep import Sweep

_REMARKS = {
    "under_surface": "the body gets under the surface of the grains, which act on the foot alone, so that no robot "
    "jumps like this",
    NEVER_ROSE: "the lifted foot never rose above its print, and the body fell: no jump, whatever its apex and cost",
    "open_book": "the energy book does not close within the accuracy, and the numbers may be off by more than was "
    "asked for",
}


def as_data(done: Finished) -> dict[str, Any]:
    """Return what a sweep made, for JSON; `jump_time_us` is None where no jump was simulated now.

    `jumps`: those that were made, without those of refused scenes and those after a scene's last.
    """
    sweep, scene = done.sweep, done.sweep.scene
    return {
        "out": str(done.out),
        "scene": scene.name,
        "dims": sweep.dims,
        "jumps": done.summary.jumps,
        "variables": len(sweep.outputs),
        "accuracy": sweep.accuracy,
        "error_bars": sweep.error_bars,
        "sampled": done.summary.sampled,
        "sampled_outside": done.summary.outside,
        "sampling": sweep.design.description,
        "outcomes": done.summary.outcomes,
        "refused": {"scenes": int(sweep.refused.sum()), "why": sweep.why_refused or None},
        **done.summary.flagged,
        "small_cost": done.summary.small_costs,
        "cost_not_positive": done.summary.not_positive,
        "assumed": {name: scene.values[name].why for name in sweep.assumed},
        "set_by_user": {name: scene[name] for name in scene.set_by_user},
        "chunks": len(sweep.chunks),
        "chunks_before": done.chunks_before,
        "compile_time_s": done.compile_time_s,
        "compute_time_s": done.compute_time_s,
        "write_time_s": done.write_time_s,
        "in_lanes": done.why_scalar is None if done.jumps_wanted else None,
        "jump_time_us": 1e6 * done.compute_time_s / done.jumps_wanted if done.jumps_wanted else None,
    }


def as_lines(done: Finished) -> list[str]:
    """Return the lines for people, with the assumed parameters."""
    sweep, summary = done.sweep, done.summary
    dims = " x ".join(f"{name} ({length})" for name, length in sweep.dims.items())
    opener = "open_zarr" if done.out.suffix == ".zarr" else "open_dataset"
    return [
        f"{sweep.scene.name}: {count_text(summary.jumps, 'jump')} over {dims}, {sweep.design.description}.",
        *([f"note: {sweep.why_refused}"] if sweep.why_refused else []),
        f"outcomes: {', '.join(f'{name} {count}' for name, count in summary.outcomes.items())}; ill-conditioned: "
        f"{summary.flagged['ill_conditioned']}{_small_costs(summary)}.",
        *_error_bars(done),
        *(
            f"warning: in {count_text(summary.flagged[flag], 'jump')} {remark} ({flag} in the file)."
            for flag, remark in _REMARKS.items()
            if summary.flagged[flag]
        ),
        *_not_positive(done),
        *set_by_user_line(sweep.scene),
        *_assumed(sweep),
        _effort(done),
        f"{done.out}: {len(sweep.outputs)} variables, for xarray.{opener}({str(done.out)!r}).",
    ]


def _assumed(sweep: Sweep) -> list[str]:
    """Name the assumed parameters, those with the same reason in one line."""
    by_reason: dict[str, list[str]] = {}
    for name in sweep.assumed:
        by_reason.setdefault(sweep.scene.values[name].why, []).append(name)
    return [
        f"{list_text(names)} {'is' if len(names) == 1 else 'are'} assumed: {why}" for why, names in by_reason.items()
    ]


def _small_costs(summary: Summary) -> str:
    """Say how many jumps are ill-conditioned for their cost."""
    count = summary.small_costs
    return f" ({count} of them as the cost is a small difference of larger energies)" if count else ""


def _not_positive(done: Finished) -> list[str]:
    """Say in how many jumps braking gives back more than they take."""
    if not done.summary.not_positive:
        return []
    return [
        f"warning: in {count_text(done.summary.not_positive, 'jump')} the cost is not positive: braking gives back "
        "more than the jump takes. For a drive that gives nothing back add --effects +no_regeneration."
    ]


def _error_bars(done: Finished) -> list[str]:
    """Say of which jumps there are error bars, and of a sample how many do not keep the accuracy."""
    sweep, sampled, outside = done.sweep, done.summary.sampled, done.summary.outside
    again = f"by simulating again to {finer_accuracy(sweep.accuracy):g} or finer"
    if sweep.error_bars >= 1.0:
        return [f"error bars: {again}, in the columns NAME_error."]
    if not sampled:
        return []
    kept = f"{outside} of them ({100.0 * outside / sampled:.3g} %) do not keep" if outside else "all keep"
    return [
        f"error bars: of a sample of {count_text(sampled, 'jump')}, {again}: {kept} the accuracy of {sweep.accuracy:g} "
        "(--error-bars for all)."
    ]


def _effort(done: Finished) -> str:
    if not done.jumps_wanted:
        return "nothing was left to simulate."
    beside = "side by side in lanes" if done.why_scalar is None else f"one after the other ({done.why_scalar})"
    each = time_text(done.compute_time_s / done.jumps_wanted)
    before = f"; {done.chunks_before} of {len(done.sweep.chunks)} chunks were there from before"
    return (
        f"{time_text(done.compute_time_s)}, {each} a jump, {beside}, for a relative error of {done.sweep.accuracy:g}; "
        f"{done.write_time_s:.2g} s for the file, after {done.compile_time_s:.2g} s of compiling"
        f"{before if done.chunks_before else ''}."
    )
