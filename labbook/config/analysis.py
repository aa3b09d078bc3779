"""Read `[analysis]`: what was decided about the analysis before the first run was measured."""

from __future__ import annotations

import tomllib

from data_schema.errors import InputRefused
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ReasonCode
from labbook.config.model import AnalysisSettings, Bounds, Detector, Family, UnitOfAnalysis
from labbook.config.tables import TableReader, as_number

HOW_TO_DECIDE = (
    "write [analysis] in labbook.toml (the one that `labbook init` writes has an example) before the first file or "
    "charge comes in, or the report calls every comparison exploratory."
)


def read_analysis(top: TableReader) -> AnalysisSettings | None:
    """Read `[analysis]`, None where the book has none."""
    if top.value("analysis") is None:
        return None
    table, default = top.table("analysis"), AnalysisSettings()
    settings = AnalysisSettings(
        primary_outcome=_primary_outcome(table, default.primary_outcome),
        family=table.word("family", Family, default.family),
        alpha=_alpha(table, default.alpha),
        apex_bounds=_apex_bounds(table),
        exclusions=_exclusions(table, default.exclusions),
        unit_of_analysis=table.word("unit_of_analysis", UnitOfAnalysis, UnitOfAnalysis.RUN),
    )
    table.finish()
    return settings


def kept_analysis(text: str) -> AnalysisSettings | None:
    """Read `[analysis]` of a configuration as the book keeps it; nothing else of the text need be understood today."""
    faults: list[str] = []
    settings = read_analysis(TableReader(tomllib.loads(text), "", faults))
    if faults:
        raise InputRefused(f"a configuration that the book keeps cannot be read ({faults[0]}): use a newer labbook.")
    return settings


def kept_jump_rules(text: str) -> tuple[Detector, int, bool]:
    """Read which jumps count by `[protocol]` of a configuration as the book keeps it: detector and exclusions."""
    faults: list[str] = []
    table = TableReader(tomllib.loads(text), "", faults).table("protocol")
    rules = (
        table.word("detector", Detector, Detector.ROBUST),
        table.whole("exclude_first_jumps", 0, least=0),
        table.flag("exclude_gap_jumps", True),
    )
    if faults:
        raise InputRefused(f"a configuration that the book keeps cannot be read ({faults[0]}): use a newer labbook.")
    return rules


def _primary_outcome(table: TableReader, default: Outcome) -> Outcome:
    key, outcomes = "primary_outcome", {outcome.key: outcome for outcome in Outcome}
    given = table.value(key)
    return default if given is None else outcomes[table.known(key, given, outcomes, "primary outcome")]


def _alpha(table: TableReader, default: float) -> float:
    alpha = table.number("alpha", default, above=0.0)
    if alpha >= 0.5:
        table.fault("alpha", f"{alpha:g} is no level of a test: write one below 0.5, such as 0.05.")
    return alpha


def _apex_bounds(table: TableReader) -> Bounds | None:
    found = [
        bounds
        for key, percent in (("apex_bounds_m", False), ("apex_bounds_percent", True))
        for bounds in [_bounds(table, key, percent=percent)]
        if bounds is not None
    ]
    if len(found) > 1:
        table.fault("apex_bounds_m", "stands beside apex_bounds_percent: leave one of the two out.")
    return found[0] if found else None


def _bounds(table: TableReader, key: str, *, percent: bool) -> Bounds | None:
    if table.value(key) is None:
        return None
    given = table.items(key, "the lower and the upper bound")
    low, high = map(as_number, given) if len(given) == 2 else (None, None)
    if low is None or high is None or not low < 0.0 < high:
        example = "[-3, 3]" if percent else "[-0.005, 0.005]"
        table.fault(key, f"{given!r} are no bounds round no difference: write two numbers such as {example}.")
        return None
    return Bounds(low, high, percent)


def _exclusions(table: TableReader, default: tuple[ReasonCode, ...]) -> tuple[ReasonCode, ...]:
    if table.value("exclusions") is None:
        return default
    known = {str(reason): reason for reason in ReasonCode}
    found = []
    for given in table.items("exclusions", "reasons in quotes"):
        if isinstance(given, str) and given in known:
            found.append(known[given])
        else:
            table.fault("exclusions", f"{given!r} is no reason: write of {', '.join(known)} those that are allowed.")
    return tuple(found)
