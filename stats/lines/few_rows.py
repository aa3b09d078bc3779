"""Too few rows for a line that is nothing without its uncertainty."""

from __future__ import annotations

from data_schema.errors import InputRefused
from stats.wording import missing_text

MINIMUM_ROWS = 3
"""Two rows fix a line and leave nothing to measure its uncertainty with."""


def refuse_few(n: int, what: str, left_out: int) -> None:
    """Raise `InputRefused` for fewer rows, `what` in the plural, than show how well a line is known."""
    if n < MINIMUM_ROWS:
        raise InputRefused(
            f"the number of {what} is {n}{missing_text(left_out)}, and the line needs at least {MINIMUM_ROWS}, or "
            "nothing says how well it is known: give more (`fit_linear` gives the bare line of two)."
        )
