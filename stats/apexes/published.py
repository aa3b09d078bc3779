"""The thesis's detector (4.3.3): local maxima of the height smoothed by a moving average of 10 samples.

The thesis had a person look at every jump; here the rule is confined to the flight that follows a stance, so that
hand motion on the clamp is not counted. Which jumps are then left out (the first two, those with a dropped packet)
is the protocol's business. Nothing is masked: a spike or a dropout inside the average moves it, as it did there.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.apexes.cleaning import Floats, clean_signal
from stats.apexes.jumps import Jump
from stats.apexes.stance import (
    StanceParameters,
    find_hops,
    gap_in_flight,
    jump_without_apex,
    landing,
    liftoff_from_leg,
)


@dataclass(frozen=True, slots=True)
class PublishedParameters:
    """Parameters of the published detector."""

    window_samples: int = 10
    """Moving average, samples (thesis 4.3.3)."""
    stance: StanceParameters = field(default_factory=StanceParameters)
    """Where a maximum may be an apex: our addition, in place of the person who looked."""

    def __post_init__(self) -> None:
        if self.window_samples < 1:
            raise InputRefused(f"a moving average of {self.window_samples} samples: give 1 or more (thesis: 10).")

    @property
    def smoothed_samples(self) -> int:
        """Samples that are averaged before an apex is read off."""
        return self.window_samples


def published_jumps(
    time_s: Floats,
    body_height_m: Floats,
    leg_length_m: Floats | None,
    gaps: Floats,
    rest_length_m: float,
    parameters: PublishedParameters,
) -> tuple[Jump, ...]:
    """Return the jumps of a log; arrays of shape (n,) in seconds and metres, gaps (n_gaps, 2): start and length.

    The apex is the highest value of the moving average in the flight after a stance, its time the mean time of the
    samples averaged. The rule has no standard error and fits no curvature.
    """
    signal = clean_signal(time_s, body_height_m, leg_length_m, gaps, parameters.stance.cleaning)
    hops = find_hops(signal, rest_length_m, parameters.stance)
    width = parameters.window_samples
    jumps = []
    for number, hop in enumerate(hops, start=1):
        if isinstance(hop.apex, Undefined):
            jumps.append(jump_without_apex(number, hop, hop.apex.reason, signal, gaps, parameters.stance))
            continue
        end_s = float(signal.time_s[min(hop.fallen, signal.time_s.size - 1)])
        first, last = np.searchsorted(time_s, [signal.time_s[hop.end], end_s]).tolist()
        # Averages whose middle lies in the flight: half a window more on either side.
        first = max(first - width // 2, 0)
        smooth = _moving_average(body_height_m[first : last + 1 + width // 2], width)
        if not np.isfinite(smooth).any():
            reason = f"fewer than {width} samples in a row after this stance"
            jumps.append(jump_without_apex(number, hop, reason, signal, gaps, parameters.stance))
            continue
        highest = int(np.argmax(np.where(np.isfinite(smooth), smooth, -np.inf)))
        apex_s = float(np.mean(time_s[first + highest : first + highest + width]))
        height_m = float(smooth[highest])
        following = hops[number] if number < len(hops) else None
        liftoff_s = liftoff_from_leg(signal, hop, rest_length_m, parameters.stance)
        if isinstance(liftoff_s, Undefined):
            liftoff_s = float(signal.time_s[hop.end])
        landing_s, extrapolated = landing(
            apex_s, height_m, parameters.stance.gravity_m_s2, following, rest_length_m, parameters.stance
        )
        if isinstance(landing_s, float) and not extrapolated:
            end_s = landing_s + parameters.stance.gap_margin_s
        jumps.append(
            Jump(
                number=number,
                touchdown_s=hop.touchdown_s,
                liftoff_s=liftoff_s,
                apex_s=apex_s,
                apex_height_m=height_m,
                apex_height_se_m=Undefined("the published rule has no standard error"),
                flight_time_s=landing_s if isinstance(landing_s, Undefined) else landing_s - liftoff_s,
                samples_used=width,
                curvature_m_s2=Undefined("the published rule fits no curvature"),
                gap_touched=gap_in_flight(gaps, signal, hop, liftoff_s, end_s, parameters.stance),
                flags=("landing_extrapolated",) if extrapolated else (),
            )
        )
    return tuple(jumps)


def smoothing_bias_m(window_samples: int, interval_s: float, gravity_m_s2: float) -> float:
    """Return by how much a moving average lowers an apex on average: g (w / fs)^2 / 24.

    Exact for an apex that falls anywhere between two samples with equal probability: the average lowers an apex on
    a sample by g (w^2 - 1) / (24 fs^2), and the sampling grid adds g / (24 fs^2).
    """
    return gravity_m_s2 * (window_samples * interval_s) ** 2 / 24.0


def _moving_average(values: Floats, width: int) -> Floats:
    """Return the averages of `width` samples in a row, shape (n - width + 1,); empty when there are fewer."""
    if values.size < width:
        return np.empty(0)
    finite = np.where(np.isfinite(values), values, np.nan)
    return np.convolve(finite, np.full(width, 1.0 / width), mode="valid")
