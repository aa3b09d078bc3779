"""Campaigns of runs on days with a known saving: the layouts and designs by which decision rules are judged.

Layouts are (control runs, treated runs) of each day. A design is the standard deviation of days in that of runs, the
control's standard deviation in that of treated runs, and how days act: added, multiplied, or all on the log scale.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stats.compare.shared_error import SharedError
from stats.days.decision import Contrast, contrast_by_day

Floats = NDArray[np.float64]
RUN_SD, APEX_SD, DRAIN_SE, DRAIN_DF = 0.10, 0.01, 0.013, 4
"""Of the control's mean: of a run's joules and apex, and the error that all joules have in common."""

LAYOUTS: dict[str, list[tuple[int, int]]] = {
    "5 days 4+11 3+11 3+11 4+12 2+5": [(4, 11), (3, 11), (3, 11), (4, 12), (2, 5)],
    "5 days 1+3 3+10 5+15 4+12 3+10": [(1, 3), (3, 10), (5, 15), (4, 12), (3, 10)],
    "10 days 1+2": [(1, 2)] * 10,
    "4 days 3+10": [(3, 10)] * 4,
    "3 days 4+12": [(4, 12)] * 3,
    "3 days 12+2 3+20 1+28": [(12, 2), (3, 20), (1, 28)],
    "3 days 1+3": [(1, 3)] * 3,
    "2 days 8+20": [(8, 20)] * 2,
    "2 days 3+10, 2 of AD": [(3, 10)] * 2 + [(0, 12)] * 2,
    "1 day 8+20": [(8, 20)],
    "1 day 4+10, 4 of AD": [(4, 10)] + [(0, 13)] * 4,
    "1 day 4+10, 1 of CE, 3 of AD": [(4, 10), (12, 0)] + [(0, 13)] * 3,
    "2 of CE, 4 of AD": [(8, 0)] * 2 + [(0, 12)] * 4,
    "1 of CE, 5 of AD": [(16, 0)] + [(0, 10)] * 5,
    "3 of CE, 3 of AD": [(5, 0)] * 3 + [(0, 15)] * 3,
    "5 of CE, 5 of AD": [(3, 0)] * 5 + [(0, 10)] * 5,
}

Days = Literal["added", "multiplied", "on the log scale"]


@dataclass(frozen=True, slots=True)
class Design:
    """How much days and conditions scatter."""

    day_sd: float
    control_sd: float
    days: Days


DESIGNS = [
    *(Design(day, ratio, how) for day in (0, 0.5, 1, 3) for ratio in (1, 1.5, 2) for how in ("added", "multiplied")),
    Design(1, 1, "on the log scale"),
    Design(1, 2, "on the log scale"),
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Campaign:
    """Runs of both conditions with their days, and what their means on each day scatter about."""

    control: Floats
    control_days: list[int]
    treated: Floats
    treated_days: list[int]
    truth: dict[int, tuple[float, float]]

    def contrast(self, shared: SharedError | None = None) -> Contrast:
        """Compare as a report does; `shared` is the error of every run."""
        return contrast_by_day(
            self.treated,
            self.control,
            days_treated=self.treated_days,
            days_control=self.control_days,
            shared_treated=None if shared is None else [shared] * self.treated.size,
            shared_control=None if shared is None else [shared] * self.control.size,
        )

    def saving_of_days(self, contrast: Contrast) -> float:
        """Return the saving in percent of the days that a contrast within days is about."""
        sizes = [day.control.n * day.treated.n / (day.control.n + day.treated.n) for day in contrast.shared_days]
        true = [self.truth[int(day.day)] for day in contrast.shared_days]
        control, treated = (sum(w * pair[side] for w, pair in zip(sizes, true, strict=True)) for side in (0, 1))
        return 100.0 * (1.0 - treated / control)


def campaign(
    layout: list[tuple[int, int]],
    design: Design,
    ratio: float,
    run_sd: float,
    rng: np.random.Generator,
    common: float = 0.0,
    levels: Floats | None = None,
) -> Campaign:
    """Draw a campaign whose control has mean 1 and whose treated runs have mean `ratio`, before days act.

    `common` is added to every run; `levels` are those of the days in standard deviations, drawn if not given.
    """
    level = rng.normal(size=len(layout)) if levels is None else levels
    truth: dict[int, tuple[float, float]] = {}
    values: tuple[list[Floats], list[Floats]] = ([], [])
    days: tuple[list[int], list[int]] = ([], [])
    for day, counts in enumerate(layout):
        means = []
        for side, (mean, sd) in enumerate(((1.0, run_sd * design.control_sd), (ratio, run_sd))):
            shift, noise = level[day] * design.day_sd * run_sd, rng.normal(size=counts[side]) * sd
            true = mean + shift if design.days == "added" else mean * np.exp(shift)
            own = true * np.exp(noise - sd**2 / 2) if design.days == "on the log scale" else true + noise
            values[side].append(own + common)
            days[side].extend([day] * counts[side])
            means.append(true)
        truth[day] = (means[0], means[1])
    return Campaign(np.concatenate(values[0]), days[0], np.concatenate(values[1]), days[1], truth)


def drain(rng: np.random.Generator) -> tuple[float, SharedError]:
    """Draw the error that all joules have in common, and its standard error as the fit of a drain line estimates it."""
    se = DRAIN_SE * float(np.sqrt(rng.chisquare(DRAIN_DF) / DRAIN_DF))
    return float(rng.normal() * DRAIN_SE), SharedError({("drain", "level"): se}, {"drain": float(DRAIN_DF)})
