"""What the figures of ch. 3 have in common: how the two controllers look, and the instants of a jump."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from matplotlib.axes import Axes

from reports.figures.style import BLUE, GREY, VERMILLION

MILLI = 1e3


@dataclass(frozen=True, slots=True)
class ControllerLook:
    """How one controller is drawn in every figure of ch. 3: told apart by colour and by dashes."""

    label: str
    colour: str
    line_style: Literal["-", "--"]


CE_LOOK = ControllerLook("compression-extension (CE)", VERMILLION, "--")
AD_LOOK = ControllerLook("active damping (AD)", BLUE, "-")


def mark_instant(axes: Axes, time_s: float, words: str = "") -> None:
    """Draw a thin line at an instant; words stand beside it, at the top."""
    axes.axvline(time_s, color=GREY, linewidth=0.6, zorder=1)
    if words:
        axes.annotate(
            words,
            (time_s, 1.0),
            xycoords=axes.get_xaxis_transform(),
            xytext=(-2, -2),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="top",
            fontsize=6,
            color=GREY,
        )
