"""A finished sweep as lines for people and as data for programs."""

from __future__ import annotations

from typing import Any

from data_schema.grouping import grouped
from labbook.presenting.simulation.simulated import set_by_user_line
from reports.display import count_text, list_text, time_text
from simulator.error_bars import finer_accuracy
from simulator.sweep.chunks import NEVER_ROSE
from simulator.sweep.run import Finished

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
        "out": done.out,
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
    sweep, summary, flagged = done.sweep, done.summary, done.summary.flagged
    dims = " x ".join(f"{name} ({length})" for name, length in sweep.dims.items())
    lines = [f"{sweep.scene.name}: {count_text(summary.jumps, 'jump')} over {dims}, {sweep.design.description}."]
    if sweep.why_refused:
        lines.append(f"note: {sweep.why_refused}")
    small = f" ({summary.small_costs} of them as the cost is a small difference of larger energies)"
    lines.append(
        f"outcomes: {', '.join(f'{name} {count}' for name, count in summary.outcomes.items())}; ill-conditioned: "
        f"{flagged['ill_conditioned']}{small if summary.small_costs else ''}."
    )
    again = f"by simulating again to {finer_accuracy(sweep.accuracy):g} or finer"
    sampled, outside = summary.sampled, summary.outside
    if sweep.error_bars >= 1.0:
        lines.append(f"error bars: {again}, in the columns NAME_error.")
    elif sampled:
        kept = f"{outside} of them ({100.0 * outside / sampled:.3g} %) do not keep" if outside else "all keep"
        lines.append(
            f"error bars: of a sample of {count_text(sampled, 'jump')}, {again}: {kept} the accuracy of "
            f"{sweep.accuracy:g} (--error-bars for all)."
        )
    lines += [
        f"warning: in {count_text(flagged[flag], 'jump')} {remark} ({flag} in the file)."
        for flag, remark in _REMARKS.items()
        if flagged[flag]
    ]
    if summary.not_positive:
        lines.append(
            f"warning: in {count_text(summary.not_positive, 'jump')} the cost is not positive: braking gives back "
            "more than the jump takes. For a drive that gives nothing back add --effects +no_regeneration."
        )
    lines += set_by_user_line(sweep.scene)
    reasons = [sweep.scene.values[name].why for name in sweep.assumed]
    for why, names in grouped(sweep.assumed, reasons).items():
        lines.append(f"{list_text(names)} {'is' if len(names) == 1 else 'are'} assumed: {why}")
    if done.jumps_wanted:
        beside = "side by side in lanes" if done.why_scalar is None else f"one after the other ({done.why_scalar})"
        each = time_text(done.compute_time_s / done.jumps_wanted)
        before = f"; {done.chunks_before} of {len(sweep.chunks)} chunks were there from before"
        lines.append(
            f"{time_text(done.compute_time_s)}, {each} a jump, {beside}, for a relative error of {sweep.accuracy:g}; "
            f"{done.write_time_s:.2g} s for the file, after {done.compile_time_s:.2g} s of compiling"
            f"{before if done.chunks_before else ''}."
        )
    else:
        lines.append("nothing was left to simulate.")
    opener = "open_zarr" if done.out.suffix == ".zarr" else "open_dataset"
    return [*lines, f"{done.out}: {len(sweep.outputs)} variables, for xarray.{opener}({str(done.out)!r})."]
