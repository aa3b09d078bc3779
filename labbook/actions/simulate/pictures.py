"""Pictures that commands draw where they are asked for."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure


def save_plot(draw: Callable[[], Figure], path: Path) -> None:
    """Draw a figure in the style of papers and save it."""
    from reports.figures.style import publication_style

    with publication_style():
        draw().savefig(path)
