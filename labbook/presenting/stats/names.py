"""What groups of a book are called in figures: as the report calls them, a gain by its physical value."""

from __future__ import annotations

from dataclasses import replace

from labbook.analysis.comparison import pairing
from labbook.analysis.observations import Observations
from reports.content import Factor, Level
from reports.display import NO_BREAK
from reports.naming import level_name, swept_words, title_of
from reports.wording import in_sentence

LONGEST = 48
"""Letters of a name that a figure has room for."""


def as_shown_to_people(observed: Observations) -> Observations:
    """Return a book's observations with their groups named as in the report; those of a table as they are.

    Where two levels would be shown alike, all keep the names that the book writes.
    """
    if observed.configuration is None:
        return observed
    shown = {label: drawn_name(observed, label, gain=True).replace(NO_BREAK, " ") for label in observed.labels}
    if len(set(shown.values())) < len(shown):
        return observed
    factor = _factor(observed)
    return replace(observed, shown=shown, shown_by="" if factor is None else in_sentence(title_of(factor)))


def drawn_axis(observed: Observations) -> str:
    """Name what the groups are levels of, at an axis: a factor of the book by its title."""
    factor = _factor(observed)
    return sentence_case(observed.by if factor is None else title_of(factor))


def sentence_case(words: str) -> str:
    """Return words as they begin at an axis; names such as x and b_ad_gain stay as they are."""
    named = len(words) == 1 or "_" in words
    return words if named else f"{words[:1].upper()}{words[1:]}"


def drawn_name(observed: Observations, label: str, *, gain: bool = False) -> str:
    """Name a group: "CE", "d = 186 kg/s", "active damping", "small foot"; groups of a table as the table does.

    With `gain` a level that is one has it behind: "d = 186 kg/s (gain 50)".
    """
    configuration, factor = observed.configuration, _factor(observed)
    if configuration is None or factor is None:
        return shortened(observed.name(label))
    of_gain = configuration.gains.get(observed.by)
    if observed.by == pairing.swept_factor(configuration):
        called = swept_words(factor)
        if label == observed.rest:
            return called.treatment
        if label == factor.control:
            return called.control
    try:
        value = float(label)
    except ValueError:
        return observed.name(label) if label == observed.rest else level_name(factor, Level(observed.by, label))
    if of_gain is None:
        return level_name(factor, Level(observed.by, label, value, factor.unit))
    return level_name(factor, Level(observed.by, label, of_gain.physical(value), of_gain.unit, value), gain=gain)


def shortened(name: str) -> str:
    """Return a name as a figure has room for it."""
    return name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}\u2026"


def _factor(observed: Observations) -> Factor | None:
    """Return the factor that makes the groups as the report knows it, None where no factor of a book does."""
    configuration = observed.configuration
    settings = None if configuration is None else configuration.factors.get(observed.by)
    if configuration is None or settings is None:
        return None
    gain = configuration.gains.get(observed.by)
    return Factor(
        name=observed.by,
        title=settings.title or observed.by.replace("_", " "),
        symbol=gain.symbol if gain else "",
        unit=gain.unit if gain else settings.unit or "",
        slope=gain.slope if gain else None,
        offset=gain.offset if gain else None,
        control=settings.control,
    )
