"""The font of the figures: the simple letters of DejaVu Sans, so that a PDF's share of it is cut out quickly.

Every PDF embeds the glyphs it uses. Cutting them out of DejaVu Sans takes more than half of a PDF's time, most of it
spent in the tables for ligatures and for scripts that are written together. Kerning stays as it is.
"""

from __future__ import annotations

import functools
import os
import tempfile
from pathlib import Path

import matplotlib
from fontTools import subset
from matplotlib import font_manager

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
    for name in _FILES:
        made = Path(matplotlib.get_cachedir()) / f"labbook-{matplotlib.__version__}-{name}"
        if not made.exists():
            _make(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name, made)
        font_manager.fontManager.addfont(made)
    return FAMILY


def _make(source: Path, target: Path) -> None:
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
