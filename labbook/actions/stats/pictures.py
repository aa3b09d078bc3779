"""The figures that `labbook stats` writes beside its numbers."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from data_schema.errors import UsageError
from labbook.analysis.observations import Observations
from labbook.presenting.stats.figures import as_drawn, quantiles_of, residual_plot_of, residuals_of
from reports.figures.estimation import Estimation

KINDS = (".png", ".svg", ".pdf")
DOTS_PER_IN = 300


@dataclass(frozen=True, slots=True)
class Pictures:
    """Files wanted: an estimation plot, normal quantiles of the residuals, residuals against groups and days."""

    plot: Path | None = None
    qq: Path | None = None
    residuals: Path | None = None

    @property
    def files(self) -> dict[str, Path]:
        """Return the files that are wanted by option."""
        named = (("plot", self.plot), ("qq", self.qq), ("residuals", self.residuals))
        return {name: path for name, path in named if path is not None}

    def check(self) -> None:
        """Raise `UsageError` for a file whose name does not say which form it has."""
        for name, path in self.files.items():
            if path.suffix not in KINDS:
                raise UsageError(f"--{name} {path} does not say which form: end it in {', '.join(KINDS)}.")

    def write(
        self, observed: Observations, estimation: Callable[[], Estimation], level: float, *, by_day: bool = False
    ) -> None:
        """Draw and write what is wanted."""
        if not self.files:
            return
        from reports.figures.estimation import draw_estimation
        from reports.figures.kind import pdf_bytes, svg_bytes
        from reports.figures.quantiles import draw_quantiles
        from reports.figures.residuals import draw_residuals
        from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN, publication_style

        width_in = ONE_COLUMN_IN if len(observed.labels) <= 2 else TWO_COLUMNS_IN
        has_days = any(row.day for row in observed.rows)
        drawn = as_drawn(observed)
        residuals = functools.cache(lambda by_day: residuals_of(drawn, by_day=by_day))
        draw = {
            "plot": lambda: draw_estimation(estimation(), width_in),
            "qq": lambda: draw_quantiles(quantiles_of(drawn, residuals(by_day), level)),
            "residuals": lambda: draw_residuals(
                residual_plot_of(drawn, residuals(False)), TWO_COLUMNS_IN if has_days else width_in
            ),
        }
        for name, path in self.files.items():
            figure = draw[name]()
            match path.suffix:
                case ".svg":
                    path.write_bytes(svg_bytes(figure))
                case ".pdf":
                    path.write_bytes(pdf_bytes(figure))
                case _:
                    with publication_style():
                        figure.savefig(path, dpi=DOTS_PER_IN)
