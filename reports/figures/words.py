"""A figure of words alone: where there is nothing to draw, why, in place of a picture of nothing."""

from __future__ import annotations

import textwrap

from matplotlib.figure import Figure

from reports.figures.style import BLACK, new_figure, publication_style

_HEIGHT_IN = 0.9
_SIZE_PT, _LETTER_PT = 8.0, 4.8
"""Size of the words, and the width of a letter."""


def draw_words(words: str, width_in: float) -> Figure:
    """Write a sentence in the middle of a low figure, broken to its width."""
    with publication_style():
        figure = new_figure(width_in, _HEIGHT_IN)
        letters = int(72.0 * width_in / _LETTER_PT)
        figure.text(0.5, 0.5, textwrap.fill(words, letters), ha="center", va="center", fontsize=_SIZE_PT, color=BLACK)
        return figure
