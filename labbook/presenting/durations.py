"""Times as people read them."""

from __future__ import annotations

_UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"))


def time_text(seconds: float) -> str:
    """Return a time with the unit that suits it, to three digits."""
    if seconds >= 100.0:
        return f"{seconds:.0f} s"
    size, unit = next(((size, unit) for size, unit in _UNITS if seconds >= 0.9995 * size), _UNITS[-1])
    return f"{seconds / size:.3g} {unit}"
