"""Run a sweep: chunk by chunk to disk, then one file; killed at any moment, the same command goes on where it was."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from data_schema.errors import UsageError
from simulator.sweep.chunks import Block, Flags, insert_refused_rows, recipe_for
from simulator.sweep.compute import Compute
from simulator.sweep.identity import Identity, differences, identity_of
from simulator.sweep.outputs import FLAGS, NOT_MADE, NOT_MADE_FLAG, OUTCOME_FLAGS, PLACE, REFUSED
from simulator.sweep.parts import Parts, open_parts, part_folder, remove_parts, sync
from simulator.sweep.result_file import IDENTITY, Format, content_of, format_of
from simulator.sweep.sweep import Sweep

_OUTCOMES = "outcome_counts"


@dataclass(frozen=True, slots=True)
class Summary:
    """How many jumps had each outcome, and how many each flag."""

    outcomes: Mapping[str, int]
    flagged: Mapping[str, int]

    @property
    def jumps(self) -> int:
        """How many jumps were made."""
        return sum(count for outcome, count in self.outcomes.items() if outcome not in (NOT_MADE, REFUSED))


@dataclass(frozen=True, slots=True)
class Finished:
    """A sweep that is done. `chunks_before` of its chunks were done by earlier runs; all where the file was there.

    `jumps_made`: how many jumps this run made. `compute_time_s`: simulating and keeping the chunks;
    `write_time_s`: making the file of them. `why_scalar`: why the scenes were not simulated side by side in lanes.
    """

    out: Path
    sweep: Sweep
    summary: Summary
    chunks_before: int
    jumps_made: int = 0
    compile_time_s: float = 0.0
    compute_time_s: float = 0.0
    write_time_s: float = 0.0
    why_scalar: str | None = None


def run_sweep(sweep: Sweep, out: Path, compute: Compute, advance: Callable[[int], None] = lambda _: None) -> Finished:
    """Run a sweep to the file `out`, .nc or .zarr, and call `advance` with how many more jumps are done.

    Chunks are stored in the folder `out`.part until the file is there. An interrupted and continued sweep gives the
    same file as an undisturbed one, bit for bit. Raises `UsageError` where `out` or that folder holds something else.
    """
    format_ = format_of(out)
    recipe = recipe_for(sweep.scene, sweep.design, sweep.accuracy, error_bars=sweep.error_bars > 0.0)
    identity, chunks = identity_of(sweep), sweep.chunks
    if not out.parent.is_dir():
        raise UsageError(f"there is no folder {out.parent} for {out.name}: make it, or give another --out.")
    there = _finished(out, format_, identity)
    if there is not None and not part_folder(out).exists():
        advance(sweep.jumps_wanted)
        return Finished(out, sweep, there, chunks.count)
    with open_parts(out, identity, chunks, (sweep.scene.jumps, len(sweep.outputs))) as parts:
        there = _finished(out, format_, identity)  # another program may have made it a moment ago
        if there is not None:
            remove_parts(parts.folder)
            advance(sweep.jumps_wanted)
            return Finished(out, sweep, there, chunks.count)
        compile_time_s = compute.prepare(recipe)
        started = time.perf_counter()
        missing = parts.missing()
        waiting = {number: int((~sweep.refusals.rows(*chunks.bounds(number))).sum()) for number in missing}
        advance(sweep.jumps_wanted - sum(waiting.values()) * sweep.scene.jumps)

        made: list[int] = []

        def keep(number: int, block: Block) -> None:
            made.append(int((block[:, :, PLACE["outcome"]] != NOT_MADE_FLAG).sum()))
            parts.keep(number, insert_refused_rows(block, sweep.refusals.rows(*chunks.bounds(number))))

        for number in compute.run(recipe, lambda number: _legal_rows(sweep, number), missing, keep):
            advance(waiting[number] * sweep.scene.jumps)
        computed = time.perf_counter()
        result = parts.folder / f".result{out.suffix}"
        summary = _summary(parts)
        format_.write(content_of(sweep, identity, parts, _counts(summary)), result)
        result.rename(out)
        sync(out.parent)
        remove_parts(parts.folder)
        written = time.perf_counter()
    return Finished(
        out,
        sweep,
        summary,
        chunks_before=chunks.count - len(missing),
        jumps_made=sum(made),
        compile_time_s=compile_time_s,
        compute_time_s=computed - started,
        write_time_s=written - computed,
        why_scalar=recipe.why_scalar,
    )


def _legal_rows(sweep: Sweep, number: int) -> tuple[Block, Flags]:
    """Return the swept values of the scenes in a chunk that can be simulated, and which of these have error bars."""
    bounds = sweep.chunks.bounds(number)
    legal = ~sweep.refusals.rows(*bounds)
    return sweep.design.rows(*bounds)[legal], sweep.has_error_bars(*bounds)[legal]


def _finished(out: Path, format_: Format, identity: Identity) -> Summary | None:
    """Return what the sweep in the file gave, None where there is no file; raises `UsageError` for another sweep."""
    if not out.exists():
        return None
    attributes = format_.attributes(out)
    if IDENTITY not in attributes:
        raise UsageError(f"{out} is there already and is no sweep: give another --out, or remove it.")
    there = json.loads(attributes[IDENTITY])
    if there != identity:
        raise UsageError(
            f"{out} holds a sweep that differs in {differences(there, identity)}: give another --out, or remove it."
        )
    flagged = {flag: int(attributes[_counted(flag)]) for flag in FLAGS}
    return Summary(json.loads(attributes[_OUTCOMES]), flagged)


def _summary(parts: Parts) -> Summary:
    """Count the jumps of a sweep whose chunks are all done."""
    ends = parts.column(PLACE["outcome"])
    counts = {outcome: int((ends == flag).sum()) for flag, outcome in OUTCOME_FLAGS}
    return Summary(
        {outcome: count for outcome, count in counts.items() if count},
        {flag: int((parts.column(PLACE[flag]) == 1).sum()) for flag in FLAGS},
    )


def _counts(summary: Summary) -> dict[str, str | int]:
    """Return a summary as attributes of a file."""
    flagged = {_counted(flag): count for flag, count in summary.flagged.items()}
    return {_OUTCOMES: json.dumps(summary.outcomes), **flagged}


def _counted(flag: str) -> str:
    return f"{flag}_count"
