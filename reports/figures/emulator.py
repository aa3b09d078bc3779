"""The emulator study: joules, apex and lost apex by extension gain, savings over the apex (thesis fig. 4.6, 4.7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.figures.style import BLUE, GREY, SKY, TWO_COLUMNS_IN, VERMILLION, light_grid, new_figure, publication_style

_LOOKS = (("o", VERMILLION), ("s", SKY), ("^", BLUE))
_ASIDE, _ASIDE_CM = 12.0, 0.4
"""How far controllers stand beside each other, in gains and in cm."""


@dataclass(frozen=True, slots=True)
class ControllerPoints:
    """A controller at each gain: joules and apexes with standard errors, savings and apexes lost in percent.

    `ce_apexes_cm` are the apexes under the control; `savings` and `losses` have their intervals, and are None of the
    control. Errors and ends of intervals are NaN where there are none. `trend` has the ends of the line of savings over
    apexes, or is empty.
    """

    name: str
    gains: Sequence[float]
    joules: Sequence[tuple[float, float]]
    apexes_cm: Sequence[tuple[float, float]]
    ce_apexes_cm: Sequence[float]
    savings: Sequence[tuple[float, float, float] | None]
    losses: Sequence[tuple[float, float, float] | None]
    trend: Sequence[tuple[float, float]]


def draw_emulator(controllers: Sequence[ControllerPoints], left_out: Sequence[float], interval: str) -> Figure:
    """Draw the four panels; gains that are left out have a grey ground, and neither saving nor lost height."""
    with publication_style():
        figure = new_figure(TWO_COLUMNS_IN, 4.2)
        (energy, savings), (height, lost) = figure.subplots(2, 2)
        for place, one in enumerate(controllers):
            marker, color = _LOOKS[place]
            gains = [gain + (place - 1) * _ASIDE for gain in one.gains]
            apexes_cm = [apex_cm + (place - 1.5) * _ASIDE_CM for apex_cm in one.ce_apexes_cm]
            look = {"fmt": marker, "color": color, "markersize": 3, "capsize": 2.5, "linewidth": 0.8}
            for axes, values in ((energy, one.joules), (height, one.apexes_cm)):
                axes.errorbar(gains, [value for value, _se in values], yerr=[se for _value, se in values], **look)
            for axes, across, found in ((savings, apexes_cm, one.savings), (lost, gains, one.losses)):
                known = [(x, y) for x, y in zip(across, found, strict=True) if y is not None]
                ends = [[y[0] - y[1] for _x, y in known], [y[2] - y[0] for _x, y in known]]
                axes.errorbar([x for x, _y in known], [y[0] for _x, y in known], yerr=ends, **look)
            savings.plot([x for x, _y in one.trend], [y for _x, y in one.trend], color=color, linewidth=0.9)
            energy.plot([], [], marker, color=color, label=one.name)
        for axes in (energy, height, lost):
            _shade(axes, left_out, named=axes is energy)
            axes.set_xlabel("Extension gain")
        if any(one.trend for one in controllers):
            energy.plot([], [], color=GREY, linewidth=0.9, label="line of savings")
        savings.axhline(0.0, color=GREY, linewidth=0.8)
        lost.axhline(0.0, color=GREY, linewidth=0.8)
        energy.set_ylabel("Energy of a jump (J)")
        height.set_ylabel("Apex height (cm)")
        savings.set_xlabel("Apex under CE (cm)")
        savings.set_ylabel(f"Saving (%), {interval}")
        lost.set_ylabel(f"Apex lost (%), {interval}")
        for axes in figure.axes:
            light_grid(axes)
        figure.legend(
            loc="outside lower center", ncols=5, title="Joules and apexes: means and standard errors over runs"
        )
        return figure


def _shade(axes: Axes, gains: Sequence[float], *, named: bool) -> None:
    for place, gain in enumerate(gains):
        label = "left out" if named and place == 0 else ""
        axes.axvspan(gain - 40, gain + 40, color=GREY, alpha=0.2, linewidth=0, label=label)
