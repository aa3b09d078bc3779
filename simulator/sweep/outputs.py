"""What a sweep gives for each jump: names, units, meanings and how they are stored."""

from __future__ import annotations

from dataclasses import replace

from simulator.error_bars import NOT_OUTPUTS
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.rows import KERNEL_OUTPUTS, Output

NOT_MADE = "not_made"
"""Outcome of the jumps of a scene after its last: the robot did not come down again."""
REFUSED = "refused"
"""Outcome of all jumps of a scene that cannot be simulated, since its values do not fit together."""
REFUSED_FLAG, NOT_MADE_FLAG = -2, -1


OUTCOME_FLAGS = ((REFUSED_FLAG, REFUSED), (NOT_MADE_FLAG, NOT_MADE), *enumerate(OUTCOMES))
_YES_OR_NO = ((NOT_MADE_FLAG, NOT_MADE), (0, "no"), (1, "yes"))
OUTPUTS = (
    replace(KERNEL_OUTPUTS[0], flags=OUTCOME_FLAGS),
    *KERNEL_OUTPUTS[1:],
    Output("passive_J", "J", "passive draw of the electronics from touchdown to the jump's end"),
    Output("cost_J", "J", "cost of the jump: heat, mechanical, drag and passive draw"),
    Output("ill_conditioned", "1", "whether the jump hangs on a decision or on rounding", "i1", _YES_OR_NO),
    Output("under_surface", "1", "whether the body gets under the surface of the grains", "i1", _YES_OR_NO),
    Output("open_book", "1", "whether the energy book does not close within the accuracy", "i1", _YES_OR_NO),
)
"""In the order of a chunk's columns: those of the kernel first, then what is computed from them."""

ERRORS = tuple(
    Output(f"{output.name}_error", output.unit, f"estimated error of {output.name}; NaN where none was estimated")
    for output in OUTPUTS
    if output.kind == "f8" and output.name not in NOT_OUTPUTS
)
"""What a sweep with error bars gives beside them: columns after those of the outputs."""

FLAGS = ("ill_conditioned", "under_surface", "open_book")
"""What may be remarked of a jump: a sweep counts the jumps."""
PLACE = {output.name: place for place, output in enumerate(OUTPUTS)}
