"""The emulator study: joules and apex by extension gain, and savings over the apex (thesis figures 4.6 and 4.7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.figures.style import BLUE, GREY, SKY, TWO_COLUMNS_IN, VERMILLION, light_grid, new_figure, publication_style

_LOOKS = (("o", VERMILLION), ("s", SKY), ("^", BLUE))
_ASIDE = 6.0
"""How far controllers stand beside each other, in gains."""


@dataclass(frozen=True, slots=True)
class ControllerPoints:
    """A controller at each gain: joules and apexes with standard errors, savings in percent with their intervals.

    `ce_apexes_cm` are the apexes under the control; savings are None of the control, or where there is no interval.
    """

    name: str
    gains: Sequence[float]
    joules: Sequence[tuple[float, float]]
    apexes_cm: Sequence[tuple[float, float]]
    ce_apexes_cm: Sequence[float]
    savings: Sequence[tuple[float, float, float] | None]


def draw_emulator(controllers: Sequence[ControllerPoints], left_out: Sequence[float], interval: str) -> Figure:
    """Draw the three panels; gains that are left out have a grey ground, and no saving."""
    with publication_style():
        figure = new_figure(TWO_COLUMNS_IN, 2.7)
        energy, height, savings = figure.subplots(1, 3)
        for place, one in enumerate(controllers):
            marker, color = _LOOKS[place]
            gains = [gain + (place - 1) * _ASIDE for gain in one.gains]
            look = {"fmt": marker, "color": color, "markersize": 4, "capsize": 2, "linewidth": 0.8}
            for axes, values in ((energy, one.joules), (height, one.apexes_cm)):
                axes.errorbar(gains, [value for value, _se in values], yerr=[se for _value, se in values], **look)
            known = [(x, y) for x, y in zip(one.ce_apexes_cm, one.savings, strict=True) if y is not None]
            if known:
                middles = [saving for _x, (saving, _low, _high) in known]
                ends = [[y[0] - y[1] for _x, y in known], [y[2] - y[0] for _x, y in known]]
                savings.errorbar([x + (place - 1.5) * 0.3 for x, _y in known], middles, yerr=ends, **look)
            energy.plot([], [], marker, color=color, label=one.name)
        for axes in (energy, height):
            _shade(axes, left_out)
            axes.set_xlabel("Extension gain")
        savings.axhline(0.0, color=GREY, linewidth=0.8)
        energy.set_ylabel("Energy of a jump (J)")
        height.set_ylabel("Apex height (cm)")
        savings.set_xlabel("Apex under CE (cm)")
        savings.set_ylabel(f"Saving (%), {interval}")
        for axes in (energy, height, savings):
            light_grid(axes)
        figure.legend(
            loc="outside lower center", ncols=4, title="Joules and apexes: means and standard errors over runs"
        )
        return figure


def _shade(axes: Axes, gains: Sequence[float]) -> None:
    for place, gain in enumerate(gains):
        axes.axvspan(gain - 40, gain + 40, color=GREY, alpha=0.2, linewidth=0, label="" if place else "left out")
