"""Which axis of a file points up: force data are stored with z up, whatever frame their maker writes them in."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence

from data_schema.errors import unknown_name
from ingest.channels.columns import ColumnPlan
from ingest.model import FloatArray

Axes = Mapping[str, tuple[str, int]]
"""Each axis of the file, the axis it is stored as, its sign: proper rotations, so that moments turn as forces do."""

AXES: Mapping[str, Axes] = {
    "z up": {"x": ("x", 1), "y": ("y", 1), "z": ("z", 1)},
    "z down": {"x": ("x", 1), "y": ("y", -1), "z": ("z", -1)},
    "y up": {"x": ("x", 1), "y": ("z", 1), "z": ("y", -1)},
}
"""The frames of force data by the direction of their vertical axis; x stays where it is."""

_VECTOR = re.compile(r"(force|moment|free_moment|cop)_([xyz])((?:_\d+)?)")


def turn_axes(
    plans: Sequence[ColumnPlan], stored: dict[int, FloatArray], frame: str, reason: str
) -> tuple[ColumnPlan, ...]:
    """Return the plans with forces, moments and centres of pressure named by the stored axes.

    `frame` is a key of `AXES`. Components whose sign changes are turned round in `stored` (by position); `reason` is
    noted with every component that is renamed or turned round. Raises `UsageError` for a frame that is not known.
    """
    if frame not in AXES:
        raise unknown_name("frame of forces", frame, AXES)
    axes = AXES[frame]
    turned = []
    for plan in plans:
        vector = _VECTOR.fullmatch(plan.channel)
        axis, sign = axes[vector[2]] if vector else ("", 1)
        if vector is None or (axis == vector[2] and sign == 1):
            turned.append(plan)
            continue
        if sign == -1:
            stored[plan.position] = 0.0 - stored[plan.position]
        channel = f"{vector[1]}_{axis}{vector[3]}"
        turned.append(
            dataclasses.replace(plan, channel=channel, sign=plan.sign * sign, assumed=(*plan.assumed, reason))
        )
    return tuple(turned)
