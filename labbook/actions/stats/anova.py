"""What `labbook stats anova` finds: all groups together, all pairs, and each against the control."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar, cast

from data_schema.rounding import alpha_of_level
from data_schema.vocabulary import Undefined
from labbook.actions.stats.answering import SHARED_NOTE, Answer, Question
from labbook.actions.stats.comparing import compared, holm_of
from labbook.presenting.stats.days import day_left_out, day_notes, one_day_groups
from labbook.presenting.stats.figures import estimation_of, number_of
from labbook.presenting.stats.plan import NO_ANOVA, plan_notes
from reports.figures.estimation import Estimation
from stats.checks import Missing
from stats.exact.numbers import as_interval
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.dunnett import AgainstControl, Dunnett, dunnett
from stats.groups.multiple import none_text, reasons_text
from stats.groups.tukey import AllPairs, PairDifference, Variances, compare_all_pairs
from stats.groups.variances import bartlett, brown_forsythe, levene
from stats.results import as_dict

PAIRS: dict[str, tuple[Variances, str]] = {
    "tukey": ("equal", "Tukey"),
    "games_howell": ("unequal", "Games and Howell"),
}
"""What all pairs are called among the data, the variances that they suppose, and whose method that is."""
_MOST_GROUPS_IN_PAIRS = 200
"""With more groups pairs are left out: the 19 900 of 200 groups take half a minute, and they grow with the square."""


def analyse(question: Question) -> Answer:
    """Analyse the variance of all groups; intervals of pairs and against the control are simultaneous."""
    observed = question.observed
    observed.others()
    level, missing = question.level, cast(Missing, question.source.missing)
    groups, control = observed.groups(), question.control
    question.step(f"{len(groups)} groups")
    pairs = {}
    for name, (variances_are, method) in PAIRS.items() if len(groups) <= _MOST_GROUPS_IN_PAIRS else ():
        question.step(f"all pairs by {method}")
        pairs[name] = compare_all_pairs(groups, variances=variances_are, level=level, missing=missing)
    question.step("Dunnett's test")
    treatments = {name: values for name, values in groups.items() if name != control}
    classic = one_way_anova(groups, level=level, missing=missing)
    welch = welch_anova(groups, level=level, missing=missing)
    variances = [test(groups, missing=missing) for test in (brown_forsythe, levene, bartlett)]
    against = dunnett(groups[control], treatments, control_name=control, level=level, missing=missing)
    family = holm_of(compared(question, "welch"), observed, question.alpha)
    confounded, by = one_day_groups(observed), observed.shown_by or observed.by
    notes = [
        *plan_notes(observed, False, question.alpha, NO_ANOVA),
        *day_notes(observed),
        *day_left_out(observed, question.source.day),
    ]
    if question.has_shared_errors:
        notes.append(f"{SHARED_NOTE} Holm's family has it.")
    of_pairs: dict[str, Any] = {name: as_dict(found) for name, found in pairs.items()}
    if not pairs:
        too_many = _too_many(len(classic.groups))
        notes.append(f"All pairs are left out: {too_many}")
        of_pairs = {key: value for name in PAIRS for key, value in ((name, None), (f"{name}_reason", too_many))}
    answer = Answer(
        [
            classic.sentence(by),
            welch.sentence(by),
            *(test.sentence() for test in variances),
            *(all_pairs_text(found, observed.unit) for found in pairs.values()),
            against_control_text(against, observed.unit),
            family.sentence(),
            *([f"{confounded}."] if confounded else []),
        ],
        {
            "one_way": as_dict(classic),
            "welch": as_dict(welch),
            "variances": [as_dict(test) for test in variances],
            **of_pairs,
            "dunnett": as_dict(against),
            "holm": as_dict(family),
        },
        lambda: _drawn(question, against),
        notes,
        quantile_level=level,
    )
    answer.add_fields("one-way ANOVA", classic)
    answer.add_fields("Welch ANOVA", welch)
    answer.add_table("equal variances", variances, left_out=("ratio_ci", "level"))
    for found in pairs.values():
        answer.add_table(f"all pairs by {found.method}", found.pairs)
    answer.add_table(f"Dunnett against {against.control}", against.comparisons)
    answer.add_fields("Holm", family)
    return answer


def _too_many(k: int) -> str:
    """Say why there are no pairs, and what to do."""
    return (
        f"{k} groups make {k * (k - 1) // 2} pairs, and up to {_MOST_GROUPS_IN_PAIRS} groups are compared here; "
        "choose groups with --where, or take stats.compare_all_pairs in Python, which has no limit but takes long."
    )


def _drawn(question: Question, against: Dunnett) -> Estimation:
    """Return all values and the differences from the control with their simultaneous intervals."""
    observed = question.observed
    differences = {
        label: number_of(one.difference, as_interval(one.ci_low, one.ci_high), question.level, observed.unit)
        for label, one in zip(observed.others(), against.comparisons, strict=True)
    }
    return estimation_of(observed, differences, interval="Dunnett's test")


Compared = TypeVar("Compared", PairDifference, AgainstControl)

MOST_IN_WORDS = 10
"""Of more comparisons only those with a small p are in the sentence; five groups have so many pairs."""


def all_pairs_text(found: AllPairs, unit: str) -> str:
    """Say all pairs, or of many those whose adjusted p is at most 1 - level, and how many there are."""
    if len(found.pairs) <= MOST_IN_WORDS:
        return found.sentence(unit)
    names = [f"{pair.a} minus {pair.b}" for pair in found.pairs]
    text = _counted(found.pairs, names, lambda pair: found.pair_text(pair, unit), found.level, "pairs")
    return f"{found.head_text()}: {text}; --full lists them all."


def against_control_text(found: Dunnett, unit: str) -> str:
    """Say all comparisons with the control, or of many those with an adjusted p of at most 1 - level, and how many."""
    if len(found.comparisons) <= MOST_IN_WORDS:
        return found.sentence(unit)
    names = [item.treatment for item in found.comparisons]
    text = _counted(found.comparisons, names, lambda item: found.comparison_text(item, unit), found.level, "groups")
    return f"{found.head_text()}: {text}; --full lists them all."


def _counted(
    items: Sequence[Compared], names: Sequence[str], text: Callable[[Compared], str], level: float, what: str
) -> str:
    """Say how many of the items have a small p, the smallest of these, and which have none and why."""
    alpha = alpha_of_level(level)
    untested = [(name, item.p.reason) for name, item in zip(names, items, strict=True) if isinstance(item.p, Undefined)]
    tested = len(items) - len(untested)
    if not tested:
        return f"none of {len(items)} {what} is tested{none_text(untested)}"
    small = [item for item in items if isinstance(item.p, float) and item.p <= alpha]
    of = f"{tested} {what} tested" if untested else f"{len(items)} {what}"
    has = "has" if len(small) < 2 else "have"
    which = "" if len(small) <= MOST_IN_WORDS else f"the {MOST_IN_WORDS} smallest: "
    listed = f" ({which}{'; '.join(map(text, _smallest(small)))})" if small else ""
    lacking = f"; {len(untested)} of {len(items)} have no test: {reasons_text(untested)}" if untested else ""
    return f"{len(small) or 'none'} of {of} {has} an adjusted p of at most {alpha:g}{listed}{lacking}"


def _smallest(small: Sequence[Compared]) -> list[Compared]:
    """Return those with the smallest p, in their order."""
    sizes = [item.log10_p if isinstance(item.log10_p, float) else 0.0 for item in small]
    named = sorted(range(len(small)), key=sizes.__getitem__)[:MOST_IN_WORDS]
    return [small[place] for place in sorted(named)]
