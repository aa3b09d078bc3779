"""After lift-off the foot meets the ground again only once it has risen above its print.

Off, contact is at the print: where the leg's force under the gains of flight does not lift the foot, the lift-off is
cancelled, and the foot stays on the ground under these gains, the controller asleep, until it is lifted.
"""

from __future__ import annotations

from simulator.effects.effect import Effect

EFFECT = Effect(
    name="contact_once_risen",
    meaning="to reproduce published numbers alone: a lifted foot sinks unresisted until it has risen above its print; "
    "off, the ground goes on holding it",
    source="the numbers published with the simulations of ch. 3 rest on it",
    needs=(("hydrostatic_stiffness",),),
)
