"""`[analysis]` and `[hypotheses.NAME]`: what was decided and what is expected before the first run is measured.

Each hypothesis is tested on measured and on simulated data.

[hypotheses.foot_of_control]
text = "CE costs the same whatever the foot"
source = "thesis 3.3.1, prediction 1"
published = "p > .5"
claim = "same"
side = "control"
between = "foot"
within_percent = 10
"""

from __future__ import annotations

import math
import tomllib
from collections import Counter
from collections.abc import Mapping

from data_schema.errors import InputRefused, unknown_name
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, FactorKind, ReasonCode
from labbook.config.factors import unknown_factor
from labbook.config.model import (
    Alternative,
    AnalysisSettings,
    Bounds,
    ClaimKind,
    ContrastSettings,
    Detector,
    FactorSettings,
    Family,
    HypothesisSettings,
    Onset,
    Side,
    TakeOff,
    UnitOfAnalysis,
    number_label,
)
from labbook.config.tables import TableReader, as_number

HOW_TO_DECIDE = (
    "write [analysis] in labbook.toml (the one that `labbook init` writes has an example) before the first file or "
    "charge comes in, or the report calls every comparison exploratory."
)


def read_analysis(top: TableReader, factors: Mapping[str, FactorSettings] | None = None) -> AnalysisSettings | None:
    """Read `[analysis]`, None where the book has none; without `factors` the names in its contrasts stand."""
    if top.value("analysis") is None:
        return None
    table, default = top.table("analysis"), AnalysisSettings()
    settings = AnalysisSettings(
        primary_outcome=_primary_outcome(table, default.primary_outcome),
        family=table.word("family", Family, default.family),
        alpha=_alpha(table, default.alpha),
        apex_bounds=_apex_bounds(table),
        exclusions=_exclusions(table, default.exclusions),
        unit_of_analysis=table.word("unit_of_analysis", UnitOfAnalysis, default.unit_of_analysis),
        contrasts=_contrasts(table, factors),
        alternative=table.word("alternative", Alternative, default.alternative),
    )
    table.finish()
    return settings


def stored_analysis(text: str) -> AnalysisSettings | None:
    """Read `[analysis]` of a stored configuration; other tables may be of an older form that is not read any more."""
    faults: list[str] = []
    settings = read_analysis(TableReader(tomllib.loads(text), "", faults))
    if faults:
        raise InputRefused(f"a configuration that the book keeps cannot be read ({faults[0]}): use a newer labbook.")
    return settings


def stored_jump_rules(text: str) -> dict[str, object]:
    """Read from `[protocol]` of a stored configuration which jumps count and how they are measured, by key."""
    faults: list[str] = []
    table = TableReader(tomllib.loads(text), "", faults).table("protocol")
    rules: dict[str, object] = {
        "detector": table.word("detector", Detector, Detector.ROBUST),
        "exclude_first_jumps": table.whole("exclude_first_jumps", 0, least=0),
        "exclude_gap_jumps": table.flag("exclude_gap_jumps", True),
        "onset": table.word("onset", Onset, Onset.SDS_BACK_30MS),
        "take_off": table.word("take_off", TakeOff, TakeOff.FLIGHT_SDS),
    }
    if faults:
        raise InputRefused(f"a configuration that the book keeps cannot be read ({faults[0]}): use a newer labbook.")
    return rules


def _primary_outcome(table: TableReader, default: Outcome, key: str = "primary_outcome") -> Outcome:
    outcomes = {outcome.key: outcome for outcome in Outcome}
    given = table.value(key)
    return default if given is None else outcomes[table.known(key, given, outcomes, key.replace("_", " "))]


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


_CONTRAST_KEYS: Mapping[ContrastKind, tuple[str, ...]] = {
    ContrastKind.DIFFERENCE: ("factor", "side", "levels"),
    ContrastKind.INTERACTION: ("factor", "levels"),
    ContrastKind.TREND: ("levels",),
    ContrastKind.LEVELS_OFF: ("at",),
}
"""The keys of a contrast, beside `kind` and `outcome`."""


def _contrasts(table: TableReader, factors: Mapping[str, FactorSettings] | None) -> tuple[ContrastSettings, ...]:
    found = tuple(_contrast(each, factors) for each in table.list_of_tables("contrasts"))
    for one, times in Counter(found).items():
        if times > 1:
            table.fault("contrasts", f"{one} is there {times} times: keep one.")
    return found


def _contrast(table: TableReader, factors: Mapping[str, FactorSettings] | None) -> ContrastSettings:
    has_kind = table.value("kind") in list(ContrastKind)
    kind = table.word("kind", ContrastKind)
    if not has_kind:  # what it needs is not known
        return ContrastSettings(kind, Outcome.JOULES)
    keys = _CONTRAST_KEYS[kind]
    swept = next((name for name, factor in (factors or {}).items() if factor.control is not None), "")
    factor = table.text("factor") if "factor" in keys else swept
    levels = tuple(_label(level) for level in table.items("levels", "levels")) if "levels" in keys else ()
    if factors is not None:
        if factor not in factors or ("factor" in keys and factor == swept):
            others = [name for name in factors if "factor" not in keys or name != swept]
            table.fault("factor", unknown_factor(factor, others))
        else:
            _check_levels(table, "levels", factor, list(levels), factors)
            treated = [each for each in levels if kind is not ContrastKind.TREND or each != factors[factor].control]
            if len(treated) < len(levels):
                table.fault("levels", f"{factors[factor].control} is the control, which saves nothing: leave it out.")
            elif len(set(levels)) == 1:
                table.fault("levels", f"{levels[0]} alone is compared with nothing: name two or more, or leave it out.")
            if kind in (ContrastKind.TREND, ContrastKind.LEVELS_OFF) and factors[factor].kind is not FactorKind.NUMBER:
                table.fault("kind", f"the levels of {factor} are no numbers, so nothing rises with them: compare them.")
    at = table.number("at") if "at" in keys else None
    if at is not None and not math.isnan(at) and factor in (factors or {}):
        of = (factors or {})[factor]
        values = [each.value for each in of.levels if each.value is not None and each.label != of.control]
        if sum(each <= at for each in values) < 2 or sum(each >= at for each in values) < 2:
            table.fault("at", f"{at:g} has not two treated levels of {factor} on either side: name one that has.")
    found = ContrastSettings(
        kind=kind,
        outcome=_primary_outcome(table, Outcome.JOULES, "outcome"),
        factor=factor if "factor" in keys else "",
        side=table.word("side", Side) if "side" in keys else None,
        levels=levels,
        at=at,
    )
    table.finish()
    return found


_EQUAL = ("between", "side", "within_percent")
_KEYS: Mapping[ClaimKind, tuple[str, ...]] = {
    ClaimKind.SAME: _EQUAL,
    ClaimKind.NOT_LOWER: ("within_percent",),
    ClaimKind.SAVES: (),
    ClaimKind.LARGEST_SAVING: ("group",),
    ClaimKind.SMALLEST_SAVING: ("group",),
}
"""The keys that a claim needs, beside `text` and `claim`."""


def read_hypotheses(top: TableReader, factors: Mapping[str, FactorSettings]) -> tuple[HypothesisSettings, ...]:
    """Read every `[hypotheses.NAME]`."""
    return tuple(_hypothesis(name, table, factors) for name, table in top.tables("hypotheses"))


def _hypothesis(name: str, table: TableReader, factors: Mapping[str, FactorSettings]) -> HypothesisSettings:
    has_claim = table.value("claim") is not None
    claim = table.word("claim", ClaimKind)
    needed = _KEYS[claim] if has_claim else ()
    between = _factor(table, factors) if "between" in needed else ""
    found = HypothesisSettings(
        name=name,
        text=table.text("text"),
        source=table.optional_text("source") or "",
        published=table.optional_text("published") or "",
        claim=claim,
        outcome=_outcome(table, claim),
        side=table.word("side", Side) if "side" in needed else Side.TREATED,
        between=between,
        levels=_levels(table, between, factors) if between else (),
        group=_group(table.table("group", required=True), factors) if "group" in needed else {},
        within_percent=_part(table) if "within_percent" in needed else 0.0,
    )
    for key in ("outcome", "group", *_EQUAL, "levels") if not has_claim else ():
        table.value(key)  # known keys of some claim
    table.finish()
    if has_claim:
        _check_possible(table, found, factors)
    return found


def _check_possible(table: TableReader, found: HypothesisSettings, factors: Mapping[str, FactorSettings]) -> None:
    """Add a fault for a hypothesis that no runs of these factors could test."""
    swept = next((name for name, factor in factors.items() if factor.control is not None), None)
    if swept is None:
        return
    if found.claim is ClaimKind.SAME and found.between == swept:
        control = factors[swept].control
        if found.side is Side.CONTROL:
            table.fault("side", f"the control has one level of {swept}: compare another factor, or the treated side.")
        elif control in found.levels:
            table.fault("levels", f"{control} is the control, which is not on the treated side: leave it out.")
    elif "group" in _KEYS[found.claim]:
        others = [name for name in factors if name != swept]
        if set(found.group) != set(others):
            table.fault("group", f"a group has one level of each of {', '.join(others)}: name just these.")


def _part(table: TableReader) -> float:
    part = table.number("within_percent", above=0.0)
    if part >= 100.0:
        table.fault("within_percent", f"{part:g} bounds nothing: write percents below 100, such as 5.")
    return part


def _outcome(table: TableReader, claim: ClaimKind) -> Outcome:
    key = "outcome"
    saves = claim not in (ClaimKind.SAME, ClaimKind.NOT_LOWER)
    outcomes = {outcome.key: outcome for outcome in Outcome if outcome.has_savings or not saves}
    given = table.value(key)
    return Outcome.JOULES if given is None else outcomes[table.known(key, given, outcomes, key)]


def _factor(table: TableReader, factors: Mapping[str, FactorSettings]) -> str:
    name = table.text("between")
    if name and name not in factors:
        table.fault("between", unknown_factor(name, factors))
        return ""
    return name


def _levels(table: TableReader, factor: str, factors: Mapping[str, FactorSettings]) -> tuple[str, ...]:
    given = [_label(level) for level in table.items("levels", f"levels of {factor}")]
    _check_levels(table, "levels", factor, given, factors)
    if len(set(given)) == 1:
        table.fault("levels", f"{given[0]} alone is compared with nothing: name two or more, or leave levels out.")
    return tuple(given)


def _group(table: TableReader, factors: Mapping[str, FactorSettings]) -> dict[str, str]:
    found = {}
    for name in table.names():
        if name not in factors:
            table.fault(name, unknown_factor(name, factors))
            continue
        found[name] = _label(table.value(name))
        _check_levels(table, name, name, [found[name]], factors)
    return found


def _label(given: object) -> str:
    number = as_number(given)
    return str(given) if number is None else number_label(number)


def _check_levels(
    table: TableReader, key: str, factor: str, labels: list[str], factors: Mapping[str, FactorSettings]
) -> None:
    known = [level.label for level in factors[factor].levels]
    for label in labels:
        if label not in known:
            table.fault(key, str(unknown_name(f"level of {factor}", label, known)))
