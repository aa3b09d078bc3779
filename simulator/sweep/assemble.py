"""From the chunks on disk to the variables of the file, a block at a time: memory does not grow with the sweep."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simulator.sweep.blocks import blocks
from simulator.sweep.layout import Layout
from simulator.sweep.outputs import FLAGS, NOT_MADE, OUTCOME_FLAGS, OUTPUTS, PLACE, REFUSED
from simulator.sweep.parts import Parts
from simulator.sweep.writer import Writer

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


def assemble(parts: Parts, layout: Layout, path: Path, open_writer: Callable[[Path, Layout], Writer]) -> Summary:
    """Write the file of a sweep whose chunks are all done."""
    writer = open_writer(path, layout)
    jumps = parts.row_shape[0]
    names = dict(OUTCOME_FLAGS)
    counts = dict.fromkeys(names, 0)
    flagged = dict.fromkeys(FLAGS, 0)
    for slices, first, after in blocks(layout.shape):
        start, stop = first // jumps, -(-after // jumps)
        rows = parts.read(start, stop).reshape(-1, len(OUTPUTS))[first - start * jumps : after - start * jumps]
        shape = tuple(part.stop - part.start for part in slices)
        for place, output in enumerate(OUTPUTS):
            writer.put(output.name, slices, rows[:, place].astype(output.kind).reshape(shape))
        found, times = np.unique(rows[:, PLACE["outcome"]].astype(int), return_counts=True)
        for outcome, count in zip(found.tolist(), times.tolist(), strict=True):
            counts[outcome] += count
        for flag in FLAGS:
            flagged[flag] += int((rows[:, PLACE[flag]] == 1).sum())
    outcomes = {names[outcome]: count for outcome, count in counts.items() if count}
    summary = Summary(outcomes, flagged)
    writer.finish({_OUTCOMES: json.dumps(outcomes), **{_counted(flag): count for flag, count in flagged.items()}})
    return summary


def stored_summary(attributes: Mapping[str, Any]) -> Summary:
    """Return the summary that a file's attributes hold."""
    return Summary(json.loads(attributes[_OUTCOMES]), {flag: int(attributes[_counted(flag)]) for flag in FLAGS})


def _counted(flag: str) -> str:
    return f"{flag}_count"
