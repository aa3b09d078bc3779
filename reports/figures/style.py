"""The look of every figure: widths of a paper's columns, type, and colours that the colour-blind can distinguish.

The font is the simple letters of DejaVu Sans, so that a PDF's share of it is cut out quickly: every PDF embeds the
glyphs it uses. Cutting them out of DejaVu Sans takes more than half of a PDF's time, most of it
spent in the tables for ligatures and for scripts that are written together. Kerning stays as it is.
"""

from __future__ import annotations

import contextlib
import functools
import math
import os
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

FAMILY = "Labbook Sans"
"""What the font is called: a changed font may not go by its old name."""

_FILES = ("DejaVuSans.ttf", "DejaVuSans-Bold.ttf")
_LEFT_OUT = ("GSUB", "FFTM", "PfEd", "BDF", "meta")
_LETTERS = (range(0x20, 0x600), range(0x10A0, 0x1100), range(0x1E00, 0x2800), range(0xFB00, 0xFB50))
"""Latin, Greek, Cyrillic, Armenian, Hebrew and Georgian letters, punctuation, arrows, signs and symbols."""

_FAMILY_NAMES = (1, 4, 16)
"""Entries of a font's table of names that hold the family (OpenType specification, name table)."""


@functools.cache
def figure_font() -> str:
    """Make the font once a machine, in matplotlib's cache, and return its family.

    Letters that it lacks are drawn as boxes, as DejaVu Sans draws those of most scripts; the page has them in full.
    """
    import matplotlib
    from matplotlib import font_manager

    for name in _FILES:
        made = Path(matplotlib.get_cachedir()) / f"labbook-{matplotlib.__version__}-{name}"
        if not made.exists():
            _make(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name, made)
        font_manager.fontManager.addfont(made)
    return FAMILY


def _make(source: Path, target: Path) -> None:
    from fontTools import subset

    options = subset.Options(glyph_names=True, notdef_outline=True, name_IDs=["*"], layout_features=["kern"])
    options.drop_tables += _LEFT_OUT
    handle, part = tempfile.mkstemp(dir=target.parent, suffix=".part")
    os.close(handle)
    with subset.load_font(os.fspath(source), options) as font:
        cutter = subset.Subsetter(options)
        cutter.populate(unicodes=[code for block in _LETTERS for code in block])
        cutter.subset(font)
        for entry in font["name"].names:
            if entry.nameID in _FAMILY_NAMES:
                entry.string = entry.toUnicode().replace("DejaVu Sans", FAMILY)
        subset.save_font(font, part, options)
    Path(part).replace(target)


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
    settings: dict[Any, Any] = {**defaults, **_SETTINGS, "font.family": figure_font()}
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


def light_grid(axes: Axes, axis: Literal["both", "x", "y"] = "y") -> None:
    """Draw thin lines to read values by."""
    axes.grid(visible=True, axis=axis, color=PALE, linewidth=0.5)


def spread(count: int) -> list[float]:
    """Return how far beside their place points lie, -0.5 to 0.5: apart by the golden ratio, the same each time."""
    step = (math.sqrt(5.0) - 1.0) / 2.0
    return [(index * step) % 1.0 - 0.5 for index in range(count)]


def plain_ticks(most: int = 6) -> MaxNLocator:
    """Return what places at most so many intervals between ticks at 1, 2, 2.5 or 5 times a power of ten: none at 8."""
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(most, steps=[1, 2, 2.5, 5, 10])
