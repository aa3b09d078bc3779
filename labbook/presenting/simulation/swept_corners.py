"""How far the smallest set of effects is off at the corners of a sweep, in a sentence and as data."""

from __future__ import annotations

from typing import Any

from data_schema.vocabulary import Undefined
from labbook.presenting.simulation.effects_ablation import difference_data, difference_text, percent
from simulator.ablation.corners import Corner, Corners
from simulator.ablation.outputs import Difference
from simulator.ablation.study import Ablation


def corners_lines(corners: Corners | None, ablation: Ablation | None) -> list[str]:
    """Return a sentence on the worst corner; none where no set was chosen or nothing was left out."""
    return [] if corners is None or ablation is None else [corners_line(corners, ablation)]


def corners_line(corners: Corners, ablation: Ablation) -> str:
    """Say where the set is farthest off and by how much; beyond the tolerance it is a warning with what to do."""
    worst = corners.worst
    if worst is None:
        return "warning: at no corner of what is swept can all effects be simulated, and the set was not checked there."
    left_out = f" ({corners.refused} more cannot be simulated)" if corners.refused else ""
    where = f"Of {len(corners.compared)} corners of what is swept{left_out}, the set is farthest off at {_at(worst)}"
    found = f"{where}: there {_changed(worst.difference, ablation)}."
    if worst.difference.within(ablation.tolerance):
        return found
    return (
        f"warning: the chosen set of effects does not stay within {percent(ablation.tolerance)} in all of this sweep. "
        f"{found} Sweep less far, give a smaller --within, or name the effects instead of auto."
    )


def corners_data(corners: Corners | None, ablation: Ablation | None) -> dict[str, Any]:
    """Return the worst corner for JSON; nothing where no set was chosen or nothing was left out."""
    if corners is None or ablation is None:
        return {}
    worst = corners.worst
    at_worst = None
    if worst is not None:
        ended = _ended(worst.difference)
        at_worst = {"at": dict(worst.at), **difference_data(worst.difference), "undefined": ended}
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


def _changed(difference: Difference, ablation: Ablation) -> str:
    ended = _ended(difference)
    if ended is not None:
        return f"the jump ends otherwise than with all effects ({ended})"
    return f"it changes {difference_text(difference, ablation)}"


def _at(corner: Corner) -> str:
    return ", ".join(f"{name} = {number:g}" for name, number in corner.at.items())
