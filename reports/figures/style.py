"""The look of every figure: widths of a paper's columns, type, and colours that the colour-blind can distinguish."""

from __future__ import annotations

import contextlib
import math
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend
    from matplotlib.ticker import MaxNLocator

ONE_COLUMN_IN = 3.5
"""Width of one column of a two-column paper, inches (89 mm)."""

TWO_COLUMNS_IN = 7.2
"""Width of both columns, inches (183 mm)."""

# Okabe and Ito 2008, "Color Universal Design"
BLACK = "#000000"
ORANGE = "#E69F00"
SKY = "#56B4E9"
GREEN = "#009E73"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#6B6B6B"
PALE = "#E4E4E4"

SERIES_COLOURS = ((BLUE, SKY), (VERMILLION, ORANGE), (GREEN, PURPLE), (BLACK, GREY))
"""Dark and light of one hue: the first factor chooses the pair, the second within it."""

_SETTINGS: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 8,
    "axes.titleweight": "bold",
    "figure.constrained_layout.h_pad": 0.03,
    "figure.constrained_layout.w_pad": 0.03,
    "figure.dpi": 100,
    "font.size": 8,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "pdf.fonttype": 42,
    "savefig.dpi": 100,
    "svg.fonttype": "path",
    "svg.hashsalt": "labbook",
    "text.parse_math": False,  # a dollar sign in a pack's name is a dollar sign
    "xtick.labelsize": 7,
    "xtick.major.width": 0.6,
    "ytick.labelsize": 7,
    "ytick.major.width": 0.6,
}


@contextlib.contextmanager
def publication_style() -> Iterator[None]:
    """Draw and save with our settings only; what a user's matplotlibrc says does not reach a report."""
    import matplotlib

    defaults = {key: value for key, value in matplotlib.rcParamsDefault.items() if "backend" not in key}
    settings: dict[Any, Any] = {**defaults, **_SETTINGS}
    others = {key: value for key, value in settings.items() if matplotlib.rcParams[key] != value}  # each takes time
    with matplotlib.rc_context(others), warnings.catch_warnings():
        # A name in a script that the font lacks is drawn as boxes; the page has it in full.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        # Where labels leave no room for the axes, as of absurd numbers, these keep matplotlib's margins.
        warnings.filterwarnings("ignore", message="constrained_layout not applied")
        yield


def is_narrow(width_in: float) -> bool:
    """Whether a figure has one column's width only."""
    return width_in < 5.0


def new_figure(width_in: float, height_in: float) -> Figure:
    """Make an empty figure of this size; margins are laid out so that no label is clipped."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), layout="constrained")


@contextlib.contextmanager
def paper_figure(height_in: float, width_in: float = TWO_COLUMNS_IN) -> Iterator[Figure]:
    """Give an empty figure to draw on with our settings, across both columns where nothing else is said."""
    with publication_style():
        yield new_figure(width_in, height_in)


def lay_out(figure: Figure) -> None:
    """Lay a figure out for SVG, once: every format has these positions, and none is drawn to find them, too.

    What is drawn afterwards has to lie within the axes.
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    engine = figure.get_layout_engine()
    if engine is not None and figure.axes:
        FigureCanvasSVG(figure)
        figure.set_dpi(FigureCanvasSVG.fixed_dpi)
        engine.execute(figure)
    figure.set_layout_engine(None)


def legend_below(
    figure: Figure, panels: Iterable[Axes], columns: int, more: Mapping[str, Artist] | None = None, **look: Any
) -> Legend:
    """Set one legend under all panels, of each label once and of `more` that they do not draw."""
    handles: dict[str, Artist] = {}
    for axes in panels:
        handles |= {str(name): artist for artist, name in zip(*axes.get_legend_handles_labels(), strict=True)}
    handles |= more or {}
    return figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=columns, **look)


def light_grid(axes: Axes, axis: Literal["both", "x", "y"] = "y") -> None:
    """Draw thin lines to read values by."""
    axes.grid(visible=True, axis=axis, color=PALE, linewidth=0.5)


def draw_line(
    axes: Axes,
    x: Sequence[float],
    y: Sequence[float],
    colour: str,
    *,
    band: tuple[Sequence[float], Sequence[float]] | None = None,
    points: tuple[Sequence[float], Sequence[float]] | None = None,
    marker: str = "o",
    label: str = "",
) -> None:
    """Draw a fitted line, its confidence band (low, high) and the points (x, y) that it was fitted to, all of them.

    The line is dashed where no point lies.
    """
    if band is not None:
        axes.fill_between(x, *band, color=colour, alpha=0.18, linewidth=0)
    ends = (min(points[0]), max(points[0])) if points is not None else (min(x), max(x))
    inside = [(at, value) for at, value in zip(x, y, strict=True) if ends[0] <= at <= ends[1]]
    axes.plot(x, y, "--", color=colour, linewidth=0.9)
    axes.plot([at for at, _ in inside], [value for _, value in inside], color=colour, linewidth=1.2)
    if points is not None:
        axes.plot(*points, marker, color=colour, markersize=3.5, alpha=0.75, label=label, zorder=4)


def spread(count: int) -> list[float]:
    """Return how far beside their place points lie, -0.5 to 0.5: apart by the golden ratio, the same each time."""
    step = (math.sqrt(5.0) - 1.0) / 2.0
    return [(index * step) % 1.0 - 0.5 for index in range(count)]


def plain_ticks(most: int = 6) -> MaxNLocator:
    """Return what places at most so many intervals between ticks at 1, 2, 2.5 or 5 times a power of ten: none at 8."""
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(most, steps=[1, 2, 2.5, 5, 10])
