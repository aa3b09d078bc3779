"""What `labbook sim accuracy` does: a scene by every method at every setting, and the figure of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from data_schema.errors import UsageError
from simulator.accuracy.study import AccuracyStudy, accuracy_study
from simulator.changes import changed_by_words
from simulator.scene_file import load_scene

PLOT_KINDS = (".png", ".svg", ".pdf")


def study_scene(
    scene: str,
    sets: tuple[str, ...],
    effects: str | None,
    plot: Path | None,
    quick: bool,
    done: Callable[[str], object],
) -> AccuracyStudy:
    """Study a scene, changed by words; `done` is called after each run. The figure is drawn where one is asked for."""
    if plot is not None and plot.suffix not in PLOT_KINDS:
        raise UsageError(f"--plot {plot} does not say which form: end it in {', '.join(PLOT_KINDS)}.")
    study = accuracy_study(changed_by_words(load_scene(scene), sets, effects), quick, done)
    if plot is not None:
        from labbook.presenting.simulation.work_precision import work_precision_of
        from reports.figures.style import publication_style
        from reports.figures.work_precision import draw_work_precision

        with publication_style():
            draw_work_precision(work_precision_of(study)).savefig(plot)
    return study
