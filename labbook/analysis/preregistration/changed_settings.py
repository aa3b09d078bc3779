"""What labbook.toml says otherwise than before the first measurement: [analysis], and rules which jumps count."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.outcomes import Outcome
from data_schema.queries.first_measurement import StatedConfiguration
from labbook.analysis.preregistration.departures import Departure
from labbook.config.analysis import kept_jump_rules
from labbook.config.model import AnalysisSettings, Bounds, Configuration

History = Sequence[tuple[StatedConfiguration, AnalysisSettings | None]]
"""Every labbook.toml that the journal keeps, with what its [analysis] said."""


def changed_settings(stood: AnalysisSettings, now: AnalysisSettings | None, history: History) -> list[str]:
    """Say field by field what labbook.toml says otherwise than before the first measurement, and since when."""
    if now is None:
        return ["labbook.toml has no [analysis] any more: what it said before the first run was ingested stands"]
    return [
        f"[analysis] had {_NAMES.get(field, field)} {_shown(was)} before the first run was ingested and has "
        f"{_shown(value)} in labbook.toml{_since_when(history, field, value)}: "
        + ("it is used, and exploratory" if was is None else "what was stated before stands")
        for field in AnalysisSettings.__slots__
        for was, value in [(getattr(stood, field), getattr(now, field))]
        if was != value
    ]


def changed_jump_rules(text: str, configuration: Configuration) -> list[Departure]:
    """Say which rules of the protocol on jumps are others than before the first measurement; today's are used."""
    now = configuration.protocol
    values = (now.detector, now.exclude_first_jumps, now.exclude_gap_jumps)
    return [
        Departure(
            f"{name} of [protocol] was {_shown(was)} before the first run was ingested and is {_shown(value)} in "
            "labbook.toml: it is used, and apex heights are exploratory",
            (Outcome.APEX,),
        )
        for name, was, value in zip(_JUMP_RULES, kept_jump_rules(text), values, strict=True)
        if was != value
    ]


def _since_when(history: History, field: str, value: object) -> str:
    found = None
    for item, said in reversed(history):
        if getattr(said, field, None) != value:
            break
        found = item
    return "" if found is None else f" since {found.at_utc[:10]} ({found.person})"


_JUMP_RULES = ("detector", "exclude_first_jumps", "exclude_gap_jumps")
_NAMES = {"primary_outcome": "primary outcome", "apex_bounds": "apex bounds"}


def _shown(value: object) -> str:
    if isinstance(value, Outcome):
        return value.key
    if isinstance(value, Bounds):
        return f"{value.low:g} to {value.high:g} {'%' if value.percent else 'm'}"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return ", ".join(map(str, value)) or "none"
    return "none" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
