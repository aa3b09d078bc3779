"""Savings of active damping, (CE - AD) / CE in percent, with their intervals (Fieller)."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from data_schema.vocabulary import Undefined
from reports.content import Comparison, ReportContent
from reports.display import EQUALS, common_places, interval_text, level_text, value_text
from reports.figures.forest import draw_estimate, tidy_rows
from reports.figures.kind import FigureKind
from reports.figures.style import BLACK, BLUE, GREY, VERMILLION, is_narrow, light_grid, new_figure
from reports.sentences import level_of, levels_name

_ROW_IN = 0.165


def shown_savings(content: ReportContent) -> list[tuple[str, list[Comparison]]]:
    """Return the comparisons that have savings by group, what the page opens with first."""
    groups: dict[str, list[Comparison]] = {}
    for comparison in content.comparisons:
        if comparison.savings is not None:
            groups.setdefault(levels_name(content, comparison.group), []).append(comparison)
    return [(name, sorted(found, key=lambda c: not c.opens)) for name, found in groups.items()]


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw one row a comparison under the name of its group; zero is no savings."""
    narrow = is_narrow(width_in)
    groups = shown_savings(content)
    rows = sum(len(found) + (len(found) > 1) for _, found in groups)
    figure = new_figure(width_in, 0.75 + _ROW_IN * max(rows, 2))
    axes = figure.add_subplot()
    axes.axvline(0.0, color=GREY, linewidth=0.8, zorder=1)
    every = [comparison.savings for _, found in groups for comparison in found]
    places = common_places(every)
    ticks: list[tuple[int, str, bool]] = []
    row = 0
    for name, found in groups:
        several = len(found) > 1
        if several:
            ticks.append((row, name or "all runs", True))
            row += 1
        for comparison in found:
            _draw_row(axes, comparison, row, places, narrow)
            level = level_of(content, comparison)
            ticks.append((row, level if several else f"{name or 'all runs'}, {level}", False))
            row += 1
    axes.set_yticks([at for at, _, _ in ticks], [text for _, text, _ in ticks])
    for label, (_, _, heading) in zip(axes.get_yticklabels(), ticks, strict=True):
        label.set_fontweight("bold" if heading else "normal")
        label.set_fontsize(6 if narrow else 7)
    tidy_rows(axes, row)
    axes.set_xlabel("Savings (CE − AD) / CE (%)")
    light_grid(axes, "x")
    return figure


def _draw_row(axes: Axes, comparison: Comparison, row: int, places: int, narrow: bool) -> None:
    savings = comparison.savings
    if savings is None:
        return
    colour, marker = (VERMILLION, "D") if comparison.opens else (BLUE, "o")
    draw_estimate(axes, savings, row, colour=colour, marker=marker)
    if narrow or isinstance(savings.value, Undefined):
        return
    text = f"{value_text(savings.value, places)} ({interval_text(savings, places, unit=False)})"
    counts = f"n{EQUALS}{comparison.n_control}, {comparison.n_treatment}"
    for offset_pt, words, ink in ((6, text, BLACK), (86, counts, GREY)):
        axes.annotate(
            words,
            (1.0, row),
            xycoords=axes.get_yaxis_transform(),
            xytext=(offset_pt, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
            color=ink,
            annotation_clip=False,
        )


def caption(content: ReportContent) -> str:
    """Say what is drawn."""
    numbers = [c.savings for c in content.comparisons if c.savings is not None]
    level = level_text(numbers[0]) if numbers else "confidence interval"
    return (
        f"Share of the energy of a jump that active damping saves, (CE − AD) / CE, with its {level} by "
        "Fieller's method. Diamonds: all active-damping coefficients pooled; circles: each coefficient d "
        "against the control of its group. Numbers at the right, in the wide form: percent (interval), runs of "
        "CE and of AD."
    )


def alternative(content: ReportContent) -> str:
    """Describe the plot in words: the pooled savings of each group."""
    parts = [
        f"{name}: {value_text(c.savings.value, common_places([c.savings]))} % ({interval_text(c.savings)})"
        for name, found in shown_savings(content)
        for c in found
        if c.opens and c.savings is not None
    ]
    return f"Forest plot of savings in percent. {'; '.join(parts)}."


def absent(content: ReportContent) -> str | None:
    """Give the reason where nothing was compared with a control."""
    if any(comparison.savings is not None for comparison in content.comparisons):
        return None
    return "This selection has no joules of both a control and a treatment to compare, so there are no savings."


SAVINGS = FigureKind("savings", "Savings", draw, caption, alternative, absent)
