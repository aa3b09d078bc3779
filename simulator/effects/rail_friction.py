"""Dry friction of the body on its vertical rail: a constant force against its motion, and a hold while it rests."""

from __future__ import annotations

from simulator.compiled import Function, Row, inner
from simulator.effects.effect import MODES, BodyForce, Effect, Energy, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    force, sign = at("rail_friction_force"), at("rail_sign")

    @inner
    def body_moves(p: Row, velocity_m_s: float) -> None:
        p[sign] = 1.0 if velocity_m_s > 0.0 else -1.0

    @inner
    def body_stops(p: Row, drive_n: float) -> None:
        held = abs(drive_n) <= p[force]
        p[sign] = 0.0 if held else 1.0 if drive_n > 0.0 else -1.0

    @inner
    def hold_guard(p: Row, drive_n: float, velocity_m_s: float) -> float:
        return abs(drive_n) - p[force] if p[sign] == 0.0 else -p[sign] * velocity_m_s

    return {
        "body_force_n": inner(lambda p, height_m, velocity_m_s: -p[sign] * p[force]),
        "body_held": inner(lambda p: p[sign] == 0.0),
        "body_moves": body_moves,
        "body_stops": body_stops,
        "hold_guard": hold_guard,
    }


EFFECT = Effect(
    name="rail_friction",
    meaning="dry friction of the body on its rail",
    source="thesis 4.2.4: the robot is constrained to a vertical rail",
    parameters=(Parameter("rail_friction_force", "robot", "N", "friction of the rail", 0.0, 1e3),),
    derived=("rail_sign",),
    body_force=BodyForce(
        loss=Energy("friction_loss", "energy lost to the rail's friction", -1, "lost to the rail"),
        modes=MODES,
        breaks_closed_form=(),
        holds=True,
    ),
    functions=_functions,
)
