"""A stance on a platform with mass, written out from its equations and integrated by `scipy.integrate.solve_ivp`.

It shares no line with the kernel. It knows a platform that yields, is held by its ratchet, is pushed away by the foot
and slides on, stops, and is met again; it knows no reset, and so ends at the apex.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from simulator.scene import Scene

Row = NDArray[np.float64]
G = 9.81
X_B, V_B, X_F, V_F, X_P, V_P, HEAT, WORK = range(8)
RTOL = 1e-11
EVENT_M = 1e-12
"""How near to its stop the platform counts as at it, and for how long (s) after an event it is not looked for."""


def lever_1_m(scene: Scene, length_m: float) -> float:
    """How fast a motor's angle turns with the leg's length (thesis 3.2.1)."""
    a, b = scene["upper_link"], scene["lower_link"]
    u = (a * a - b * b + length_m * length_m) / (2.0 * a * length_m)
    slope = (length_m * length_m - a * a + b * b) / (2.0 * a * length_m * length_m)
    return slope / math.sqrt(1.0 - u * u)


@dataclass(slots=True)
class _Event:
    """A guard as `solve_ivp` wants its events; one that is at zero at the start is below it there."""

    guard: Callable[[Row], float]
    start_s: float
    late: bool
    terminal: bool = True
    direction: float = 1.0

    def __call__(self, t: float, y: Row) -> float:
        return -1.0 if self.late and t <= self.start_s + EVENT_M else self.guard(y)


@dataclass(slots=True)
class Stance:
    """The first jump of an emulator scene from its touchdown to its apex."""

    scene: Scene
    y: Row = field(default_factory=lambda: np.zeros(8))
    t: float = 0.0
    mode: str = "intruding"
    stiff: bool = False
    holds: bool = True
    slides: bool = False
    impact_j: float = 0.0
    deepest_m: float = 0.0
    liftoff_s: float = math.nan
    spent_j: tuple[float, float] = (math.nan, math.nan)
    modes: list[tuple[float, str]] = field(default_factory=list)
    """When each mode was entered."""

    def force_n(self, y: Row) -> float:
        """Leg force, tension positive, within the motors' torque."""
        s = self.scene
        length_m, speed_m_s = y[X_B] - y[X_F], y[V_B] - y[V_F]
        k, b = (s["k_extension"], s["b_extension"]) if self.stiff else (s["k_compression"], s["b_compression"])
        if self.stiff:
            b += s["b_ad"] * max(0.0, -y[V_F])
        most_n = 2.0 * s["stall_torque"] * lever_1_m(s, length_m)
        return float(np.clip(k * (length_m - s["rest_length"]) + b * speed_m_s, -most_n, most_n))

    def push_n(self, x_p: float, v_p: float) -> float:
        """The yielding platform's upward push."""
        s = self.scene
        return -s["platform_stiffness"] * x_p - s["platform_damping"] * v_p + s["platform_drag"] * v_p * v_p

    def foot_m_s2(self, y: Row, force_n: float) -> float:
        """Acceleration of foot and platform together."""
        s = self.scene
        moved_kg = s["foot_mass"] + s["platform_mass"]
        return (force_n + self.push_n(y[X_F], y[V_F]) - s["foot_mass"] * G) / moved_kg

    def rates(self, _: float, y: Row) -> Row:
        """Equations of motion in the present mode, and the powers of heat and work."""
        s, force_n = self.scene, self.force_n(y)
        speed_m_s = y[V_B] - y[V_F]
        out = np.zeros(8)
        out[X_B], out[V_B] = y[V_B], -force_n / s["body_mass"] - G
        if self.mode == "flight":
            out[X_F], out[V_F] = y[V_F], force_n / s["foot_mass"] - G
        elif self.mode == "intruding":
            out[X_F], out[V_F] = y[V_F], self.foot_m_s2(y, force_n)
            out[X_P], out[V_P] = out[X_F], out[V_F]
        if self.slides:
            out[X_P], out[V_P] = y[V_P], self.push_n(y[X_P], y[V_P]) / s["platform_mass"]
        current_a = force_n / (lever_1_m(s, y[X_B] - y[X_F]) * s["torque_constant"])
        out[HEAT], out[WORK] = 0.5 * s["motor_resistance"] * current_a**2, -force_n * speed_m_s
        return out

    def wants_stiff(self, y: Row) -> float:
        s = self.scene
        length_m, speed_m_s = y[X_B] - y[X_F], y[V_B] - y[V_F]
        slow = min(s["rest_length"] - s["switch_compression"] - length_m, speed_m_s + s["switch_speed_tolerance"])
        return float(max(slow, s["guard_length"] - length_m))

    def events(self) -> dict[str, Callable[[Row], float]]:
        """What may end this piece of motion: functions that rise through zero."""
        s, foot_kg = self.scene, self.scene["foot_mass"]
        found: dict[str, Callable[[Row], float]] = {
            "switch": lambda y: (
                y[X_B] - y[X_F] - s["rest_length"] + s["rest_tolerance"] if self.stiff else self.wants_stiff(y)
            )
        }
        if self.stiff and self.holds:
            near = s["rest_length"] - s["release_tolerance"]
            found["release"] = lambda y: y[X_B] - y[X_F] - near if self.t > s["shortest_hold"] else -1.0
        if self.mode == "intruding":
            found["stop"] = lambda y: y[V_F]
            found["bottom"] = lambda y: -y[X_F] - s["platform_travel"]
            found["leave"] = lambda y: self.force_n(y) - foot_kg * (self.foot_m_s2(y, self.force_n(y)) + G)
        elif self.mode == "jammed":
            found["leave"] = lambda y: self.force_n(y) - foot_kg * G
            if self.holds and self.y[X_P] > -s["platform_travel"]:
                found["yield"] = lambda y: foot_kg * G - self.force_n(y) + s["platform_stiffness"] * y[X_P]
        else:
            found["touch"] = lambda y: y[X_P] - y[X_F]
            found["apex"] = lambda y: -y[V_B]
            if self.slides:
                found["lock"] = lambda y: y[V_P]
                found["bottom"] = lambda y: -y[X_P] - s["platform_travel"]
        return found

    def enter(self, mode: str) -> None:
        self.mode = mode
        self.modes.append((self.t, mode))
        if mode != "flight":
            self.deepest_m = max(self.deepest_m, -float(self.y[X_F]))
        if mode == "flight":
            self.liftoff_s, self.spent_j = self.t, (float(self.y[HEAT]), float(self.y[WORK]))

    def stop(self, moved_kg: float, place: int) -> None:
        """What moves at this speed stops, and its energy is lost."""
        self.impact_j += 0.5 * moved_kg * float(self.y[place]) ** 2
        self.y[[V_P] if place == V_P else [V_F, V_P]] = 0.0

    def rest(self) -> None:
        """A foot that stands still is lifted, held, or makes the platform yield."""
        found = self.events()
        if found["leave"](self.y) > 0.0:
            self.enter("flight")
        elif "yield" in found and found["yield"](self.y) > 0.0:
            self.enter("intruding")

    def land(self) -> None:
        """Foot and platform go on at one speed; where the platform stands at its stop, the foot stops."""
        foot_kg, platform_kg = self.scene["foot_mass"], self.scene["platform_mass"]
        if self.y[X_F] <= EVENT_M - self.scene["platform_travel"]:
            self.stop(foot_kg, V_F)
            self.enter("jammed")
            return
        together_m_s = (foot_kg * self.y[V_F] + platform_kg * self.y[V_P]) / (foot_kg + platform_kg)
        before_j = 0.5 * (foot_kg * self.y[V_F] ** 2 + platform_kg * self.y[V_P] ** 2)
        self.impact_j += float(before_j - 0.5 * (foot_kg + platform_kg) * together_m_s**2)
        self.y[[V_F, V_P]], self.y[X_P], self.slides = together_m_s, self.y[X_F], False
        self.enter("intruding")

    def happen(self, event: str) -> None:
        s = self.scene
        if event == "switch":
            self.stiff = not self.stiff
        elif event == "touch":
            self.land()
        elif event == "leave":
            self.slides = self.mode == "intruding"
            self.enter("flight")
        elif event == "yield":
            self.enter("intruding")
        elif event in ("stop", "bottom", "release", "lock"):
            self.holds = self.holds and event != "release"
            if self.mode == "flight":
                if self.slides:
                    self.stop(s["platform_mass"], V_P)
                self.slides = False
            elif self.mode == "intruding":
                self.stop(s["foot_mass"] + s["platform_mass"], V_F)
                self.enter("jammed")
        if self.mode == "jammed":
            self.rest()

    def run(self) -> Stance:
        """Go to the apex; returns itself."""
        s = self.scene
        speed_m_s = -math.sqrt(2.0 * G * s["initial_height"] + s["initial_velocity"] ** 2)
        self.y[:4] = s["rest_length"], speed_m_s, 0.0, speed_m_s
        self.land()
        for _ in range(200):
            found = self.events()
            watched = [_Event(guard, self.t, guard(self.y) > -1e-14) for guard in found.values()]
            span, how = (self.t, self.t + 3.0), {"rtol": RTOL, "atol": 1e-13, "max_step": 1e-3}
            step = solve_ivp(self.rates, span, self.y, "DOP853", events=watched, **how)
            self.t, self.y = float(step.t[-1]), step.y[:, -1].copy()
            if self.mode != "flight":
                self.deepest_m = max(self.deepest_m, -float(self.y[X_F]))
            event_name = next(name for name, times in zip(found, step.t_events, strict=True) if len(times))
            if event_name == "apex":
                return self
            self.happen(event_name)
        raise AssertionError("the stance does not end")
