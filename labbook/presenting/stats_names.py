"""What groups of a book are called in figures: as the report calls them, a gain by its physical value."""

from __future__ import annotations

from labbook.analysis import pairing
from labbook.analysis.observations import Observations
from reports.content import Factor, Level
from reports.naming import level_name, swept_words


def drawn_name(observed: Observations, label: str) -> str:
    """Name a group: "CE", "d = 185.7 kg/s", "active damping", "small foot"; groups of a table as the table does."""
    configuration = observed.configuration
    settings = None if configuration is None else configuration.factors.get(observed.by)
    if configuration is None or settings is None:
        return observed.name(label)
    gain = configuration.gains.get(observed.by)
    factor = Factor(
        name=observed.by,
        title=settings.title or observed.by.replace("_", " "),
        symbol=gain.symbol if gain else "",
        unit=gain.unit if gain else settings.unit or "",
        slope=gain.slope if gain else None,
        offset=gain.offset if gain else None,
        control=settings.control,
    )
    if observed.by == pairing.swept_factor(configuration):
        called = swept_words(factor)
        if label == observed.rest:
            return called.treatment
        if label == settings.control:
            return called.control
    try:
        value = float(label)
    except ValueError:
        return observed.name(label) if label == observed.rest else level_name(factor, Level(observed.by, label))
    if gain is None:
        return level_name(factor, Level(observed.by, label, value, factor.unit))
    return level_name(factor, Level(observed.by, label, gain.physical(value), gain.unit, value))
