"""Which comparison by day is stated: the exact test's where the design is balanced, else the mixed model's.

Both are one where REML finds that days differ. Where it puts their variance at 0 the model counts days and values
together, and errs a little too often if days do differ; the exact test keeps its size whatever days do.
"""

from __future__ import annotations

from dataclasses import dataclass

from stats.days.blocked_result import BlockedByDay, Contrast, ExactTest

MIXED_MODEL = "mixed model"


@dataclass(frozen=True, slots=True)
class Leading:
    """The differences from the control that are stated, and the test that they come from; None is the mixed model."""

    contrasts: tuple[Contrast, ...]
    exact: ExactTest | None

    @property
    def method(self) -> str:
        """The method in words: "mixed model", "exact test on values, day held fixed", "exact test on day means"."""
        if self.exact is None:
            return MIXED_MODEL
        held = "" if self.exact.block == "nothing" else f", {self.exact.block} held fixed"
        return f"exact test on {self.exact.unit}s{held}"


def leading(found: BlockedByDay) -> Leading:
    """Return what a comparison over days states: that of its sentence, of a figure and of a report alike."""
    exact = found.exact
    if isinstance(exact, ExactTest) and exact.balanced:
        return Leading(exact.contrasts, exact)
    return Leading(found.contrasts, None)
