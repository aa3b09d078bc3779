"""What `labbook stats anova` does: all groups together, all pairs, and each against the control."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

from labbook.actions.stats.compare import compared, holm_of
from labbook.actions.stats.data import DataSource, observe
from labbook.actions.stats.output import CommandOutput, alpha_of, output_of
from labbook.actions.stats.pictures import Pictures
from labbook.analysis.observations import Observations
from labbook.presenting.stats.days import day_left_out, day_notes, days_untold
from labbook.presenting.stats.fields import field_lines
from labbook.presenting.stats.figures import estimation_of, number_of
from labbook.presenting.stats.many import against_control_text, all_pairs_text
from labbook.presenting.stats.plan import NO_ANOVA, plan_notes
from reports.figures.estimation import Estimation
from stats.checks import Missing
from stats.exact.finite import as_interval
from stats.groups.anova import Anova, one_way_anova
from stats.groups.dunnett import Dunnett, dunnett
from stats.groups.multiple import HolmFamily
from stats.groups.tukey import AllPairs, Variances, compare_all_pairs
from stats.groups.variances import VarianceTest, bartlett, brown_forsythe, levene
from stats.groups.welch_anova import WelchAnova, welch_anova
from stats.results import as_dict

PAIRS: dict[str, tuple[Variances, str]] = {
    "tukey": ("equal", "Tukey"),
    "games_howell": ("unequal", "Games and Howell"),
}
"""What all pairs are called among the data, the variances that they suppose, and whose method that is."""
MOST_GROUPS_IN_PAIRS = 200
"""With more groups pairs are left out: the 19 900 of 200 groups take half a minute, and they grow with the square."""

SHARED_NOTE = "The error of the passive drain, which groups share in part, is left out of this."


def analyse(
    given: DataSource, alpha: float | None, level: float | None, pictures: Pictures, step: Callable[[str], None]
) -> CommandOutput:
    """Analyse the variance of all groups; intervals of pairs and against the control are simultaneous."""
    pictures.check()
    observed = observe(given, step)
    observed.others()
    alpha = alpha_of(alpha, level, observed)
    return output_of(observed, pictures, lambda own, drawn: _answer(own, given, alpha, drawn, step))


@dataclass(frozen=True, slots=True)
class _Tested:
    """Every test of the groups of one set of observations; `level` is that of all intervals."""

    level: float
    classic: Anova
    welch: WelchAnova
    variances: tuple[VarianceTest, ...]
    pairs: tuple[AllPairs, ...]
    """By Tukey, then by Games and Howell; empty where there are too many groups."""
    against: Dunnett
    family: HolmFamily


def _answer(
    observed: Observations, given: DataSource, alpha: float, pictures: Pictures, step: Callable[[str], None]
) -> CommandOutput:
    found = _tested(observed, given, alpha, step)
    told = CommandOutput()
    told.lines += _sentences(observed, found)
    _add_tables(told, found)
    step("figures" if pictures.files else "tables")
    pictures.write(observed, lambda: _drawn(observed, found), found.level)
    notes = [
        *plan_notes(observed, False, alpha, NO_ANOVA),
        *day_notes(observed),
        *day_left_out(observed, given.day),
    ]
    if any(row.shared.se > 0.0 for row in observed.rows):
        notes.append(f"{SHARED_NOTE} Holm's family has it.")
    if not found.pairs:
        notes.append(f"All pairs are left out: {_too_many(found)}")
    return told.about(observed, pictures, notes)


def _tested(observed: Observations, given: DataSource, alpha: float, step: Callable[[str], None]) -> _Tested:
    others = observed.others()
    level, missing = 1.0 - alpha, cast(Missing, given.missing)
    groups, control = observed.groups(), observed.name(observed.control)
    step(f"{len(groups)} groups")
    classic = one_way_anova(groups, level=level, missing=missing)
    welch = welch_anova(groups, level=level, missing=missing)
    variances = tuple(test(groups, missing=missing) for test in (brown_forsythe, levene, bartlett))
    pairs = []
    for variances_are, method in PAIRS.values() if len(groups) <= MOST_GROUPS_IN_PAIRS else ():
        step(f"all pairs by {method}")
        pairs.append(compare_all_pairs(groups, variances=variances_are, level=level, missing=missing))
    step("Dunnett's test")
    treatments = {name: values for name, values in groups.items() if name != control}
    against = dunnett(groups[control], treatments, control_name=control, level=level, missing=missing)
    tests = {label: compared(observed, label, "welch", alpha, given.missing) for label in others}
    family = holm_of(tests, observed, alpha)
    return _Tested(level, classic, welch, variances, tuple(pairs), against, family)


def _too_many(found: _Tested) -> str:
    """Return why there are no pairs, and what to do."""
    k = len(found.classic.groups)
    return (
        f"{k} groups make {k * (k - 1) // 2} pairs, and up to {MOST_GROUPS_IN_PAIRS} groups are compared here; choose "
        "groups with --where, or take stats.compare_all_pairs in Python, which has no limit but takes long."
    )


def _sentences(observed: Observations, found: _Tested) -> list[str]:
    unit, by = observed.unit, observed.shown_by or observed.by
    untold = days_untold(observed)
    return [
        found.classic.sentence(by),
        found.welch.sentence(by),
        *(test.sentence() for test in found.variances),
        *(all_pairs_text(pairs, unit) for pairs in found.pairs),
        against_control_text(found.against, unit),
        found.family.sentence(),
        *([f"{untold}."] if untold else []),
    ]


def _add_tables(told: CommandOutput, found: _Tested) -> None:
    """Add all fields, as tables for people and as data for programs."""
    told.say("one-way ANOVA", field_lines(found.classic))
    told.say("Welch ANOVA", field_lines(found.welch))
    told.show("equal variances", found.variances, left_out=("ratio_ci", "level"))
    for pairs in found.pairs:
        told.show(f"all pairs by {pairs.method}", pairs.pairs)
    told.show(f"Dunnett against {found.against.control}", found.against.comparisons)
    told.say("Holm", field_lines(found.family))
    told.data |= {
        "one_way": as_dict(found.classic),
        "welch": as_dict(found.welch),
        "variances": [as_dict(test) for test in found.variances],
        **_pairs_data(found),
        "dunnett": as_dict(found.against),
        "holm": as_dict(found.family),
    }


def _pairs_data(found: _Tested) -> dict[str, Any]:
    if found.pairs:
        return {name: as_dict(pairs) for name, pairs in zip(PAIRS, found.pairs, strict=True)}
    why = _too_many(found)
    return {key: value for name in PAIRS for key, value in ((name, None), (f"{name}_reason", why))}


def _drawn(observed: Observations, found: _Tested) -> Estimation:
    """Return all values and the differences from the control with their simultaneous intervals."""
    differences = {
        label: number_of(one.difference, as_interval(one.ci_low, one.ci_high), found.level, observed.unit)
        for label, one in zip(observed.others(), found.against.comparisons, strict=True)
    }
    return estimation_of(observed, differences, interval="Dunnett's test")
