"""Lines of the thesis's own quantities: charge over time, stiffness over gain, packing over the container's size."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes.design import EVERY_N, RATIOS, Design, Floats, Groups
from benchmarks.stats_evidence.sizes.method import LEVEL, Method, alike, never, of_interval, of_one_interval, there
from stats.exact.numbers import Interval
from stats.lines.passive_drain import fit_passive_drain
from stats.lines.stiffness import fit_gain_line
from stats.packing import unbounded_fraction

DESIGNS = tuple(Design((n,), ratio) for n in EVERY_N for ratio in RATIOS)
Of = Literal["slope", "intercept", "middle", "at"]

SHORTEST_S, LONGEST_S = 300.0, 1800.0
DRAIN_READ_S: Mapping[Of, float] = {"middle": (SHORTEST_S + LONGEST_S) / 2.0, "at": LONGEST_S}
"""Where the drain is read: in the middle of the idle runs' durations, and at the longest."""
IDLE_MAH, DRAIN_MAH_S = 2.37, 0.0174
"""What the electronics take, with a scatter of 1 mAh: at once, and by the second (26 mAh from 5 to 30 minutes)."""
STEP_MAH, FINER_MAH = 1.0, 0.3
"""A charger's resolution, and the scatter of the idle runs that it is not enough for."""
DIGITS_APART = 1e6
"""Of a value of a study, the digits behind these say where on the steps its line lies."""
LOWEST_GAIN, HIGHEST_GAIN, OFFSET_N_M, OF_GAIN = 100.0, 300.0, 67.36, 2.56
"""Gains and what they stand for (thesis 5.1.1), with a scatter of 1 N/m."""
GRAIN_M, NARROWEST_M, WIDEST_M, UNBOUNDED, WALL_EFFECT, FRACTION_SD = 0.0015, 0.01, 0.05, 0.61, -0.3, 0.002
"""Grains, radii of containers and volume fractions (thesis 5.1.2)."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line that is fitted, the truth, and what the library says of it."""

    name: str
    x: Callable[[int], Floats]
    """So many equidistant places."""
    y: Callable[[Floats, Floats], Floats]
    """What is measured there, given the scatter in SDs."""
    library: Callable[[Floats, Floats], Mapping[Of, Interval]]
    truth: Mapping[Of, float]
    places: Mapping[Of, float]
    """Where the line is read."""
    least_sd: float = 0.0
    """Scatter that is counted at least."""
    exact: Callable[[Design], bool] = alike

    def data(self, groups: Groups, design: Design) -> tuple[Floats, Floats]:
        """Return x, shape (n,), and y of each study; the SD grows along x by `sd_ratio` in all."""
        (noise,) = groups
        n = design.n[0]
        x = self.x(n)
        return x, self.y(x, noise * design.sd_ratio ** np.linspace(0.0, 1.0, n) / design.sds[0])

    def one(self, groups: Groups, design: Design, of: Of) -> tuple[float, float, bool]:
        """Return the library's interval."""
        return of_one_interval(self.library(*self.data(groups, design))[of], self.truth[of])

    def many(self, groups: Groups, design: Design, of: Of) -> Floats:
        """Return Student's intervals of the slope, or of the line at a place."""
        x, y = self.data(groups, design)
        about, here = x - x.mean(), self.places.get(of, 0.0) - x.mean()
        slope, middle = y @ about / (about @ about), y.mean(axis=1)
        left = y - middle[:, None] - slope[:, None] * about
        df = x.size - 2
        sd = np.maximum(np.sqrt((left**2).sum(axis=1) / df), self.least_sd)
        half = -special.stdtrit(df, (1.0 - LEVEL) / 2.0) * sd
        if of == "slope":
            half, middle = half / math.sqrt(about @ about), slope
        else:
            half, middle = half * math.sqrt(1.0 / x.size + here * here / (about @ about)), middle + slope * here
        return of_interval(middle - half, middle + half, self.truth[of])

    def methods(self) -> Iterator[Method]:
        """Return an interval each of what is known of the line."""
        for of in self.truth:
            yield Method(
                f"{self.name}_{of}_ci",
                "coverage",
                DESIGNS,
                lambda groups, design, of=of: self.one(groups, design, of),  # type: ignore[misc]
                lambda groups, design, of=of: self.many(groups, design, of),  # type: ignore[misc]
                self.exact,
            )


def _drain(resolution_mah: float) -> Callable[[Floats, Floats], Mapping[Of, Interval]]:
    def of(duration_s: Floats, charge_mah: Floats) -> Mapping[Of, Interval]:
        found = fit_passive_drain(duration_s, charge_mah, resolution_mah)
        read = {of: found.at(place_s) for of, place_s in DRAIN_READ_S.items()}
        return {
            "slope": there(found.slope_ci_mah_s()),
            "intercept": there(found.intercept_ci_mah()),
            **{of: (there(at.ci_low), there(at.ci_high)) for of, at in read.items()},
        }

    return of


def _gains(gain: Floats, stiffness_n_m: Floats) -> Mapping[Of, Interval]:
    found = fit_gain_line(gain, stiffness_n_m)
    return {"slope": there(found.slope_ci), "intercept": there(found.offset_ci), "at": there(found.at(HIGHEST_GAIN).ci)}


def _packing(shares: Floats, fraction: Floats) -> Mapping[Of, Interval]:
    return {"intercept": there(unbounded_fraction(GRAIN_M / shares, fraction, GRAIN_M).ci)}


def _durations(n: int) -> Floats:
    return np.linspace(SHORTEST_S, LONGEST_S, n)


def _charges(duration_s: Floats, noise: Floats) -> Floats:
    return IDLE_MAH + DRAIN_MAH_S * duration_s + noise


def _in_steps(duration_s: Floats, noise: Floats) -> Floats:
    """Return charges that the charger rounds, less where on its steps each study's line happens to lie and to rise."""
    start, rise = (DIGITS_APART * noise[..., place, None] % 1.0 for place in (0, 1))
    place = STEP_MAH * (start + rise * (duration_s - SHORTEST_S) / (LONGEST_S - SHORTEST_S))
    steps = (_charges(duration_s, FINER_MAH * noise) + place) / STEP_MAH
    return np.asarray(STEP_MAH * np.round(steps) - place)


TRUE_DRAIN: Mapping[Of, float] = {
    "slope": DRAIN_MAH_S,
    "intercept": IDLE_MAH,
    **{of: IDLE_MAH + DRAIN_MAH_S * place_s for of, place_s in DRAIN_READ_S.items()},
}
TRUE_STIFFNESS: Mapping[Of, float] = {
    "slope": OF_GAIN,
    "intercept": OFFSET_N_M,
    "at": OFFSET_N_M + OF_GAIN * HIGHEST_GAIN,
}
ALL = (
    Line("passive_drain", _durations, _charges, _drain(0.0), TRUE_DRAIN, DRAIN_READ_S),
    Line(
        "passive_drain_in_steps",
        _durations,
        _in_steps,
        _drain(STEP_MAH),
        TRUE_DRAIN,
        DRAIN_READ_S,
        STEP_MAH / math.sqrt(12.0),
        never,
    ),
    Line(
        "gain_line",
        lambda n: np.linspace(LOWEST_GAIN, HIGHEST_GAIN, n),
        lambda gain, noise: OFFSET_N_M + OF_GAIN * gain + noise,
        _gains,
        TRUE_STIFFNESS,
        {"at": HIGHEST_GAIN},
    ),
    Line(
        "packing",
        lambda n: np.linspace(GRAIN_M / WIDEST_M, GRAIN_M / NARROWEST_M, n),
        lambda shares, noise: UNBOUNDED + WALL_EFFECT * shares + FRACTION_SD * noise,
        _packing,
        {"intercept": UNBOUNDED},
        {},
    ),
)
METHODS = tuple(method for line in ALL for method in line.methods())
