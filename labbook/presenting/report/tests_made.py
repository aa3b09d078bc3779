"""What a report says of the tests that it made: the one that decides, and those that stand beside it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from data_schema.outcomes import Outcome
from data_schema.rounding import level_text
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparisons import Compared, Decided
from labbook.analysis.preregistration.planned import FAMILY_OF
from labbook.analysis.study import StudyAnalysis
from labbook.config.model import Bounds
from labbook.presenting.report.comparisons import method_by_day
from labbook.presenting.report.error_rates import is_defined
from reports.content import Source
from reports.display import count_text, given_text, list_text
from stats.days.blocked_result import MIXED_MODEL
from stats.days.decision import Rule

_BY_DAY = {MIXED_MODEL: f"{MIXED_MODEL} (REML, degrees of freedom after Satterthwaite)"}


def tests_used(analysis: StudyAnalysis, ratio: str) -> str:
    """Return what conditions were compared by, or why nothing was compared."""
    if not analysis.compared:
        none = "no factor names a control level" if analysis.swept is None else "no group has a control and a treatment"
        return f"Nothing is compared: {none}. Intervals are at 95 %."
    sentences = [
        _route(analysis),
        _by_day(analysis.compared),
        _holm(analysis),
        _equivalence(analysis),
        _savings(analysis, ratio, "the ratio of means ", ""),
        *_further(analysis),
        _levels(analysis),
    ]
    return " ".join(filter(None, sentences))


def _further(analysis: StudyAnalysis) -> list[str]:
    return [
        "Levels of the treatment are compared by one-way analysis of variance." if analysis.anovas else "",
        "The same t-tests over single jumps stand in a table, as the thesis has them." if analysis.jump_tests else "",
    ]


def deciding_test_sentences(analysis: StudyAnalysis, ratio: str) -> str:
    """Return the test that decides by shared days, and how many comparisons each of its rules fits."""
    rules = Counter(item.decided.result.rule for item in analysis.compared if item.decided is not None)
    texts = {
        Rule.PAIRED: "paired t on day means from four such days on",
        Rule.WITHIN: "a contrast within days on one to three, which holds for these days",
        Rule.NONE: "no test otherwise",
    }
    made = [rule for rule in texts if rules[rule]]
    numbers = [count_text(rules[rule], "comparison") if rule is made[0] else str(rules[rule]) for rule in made]
    counts = list_text([f"{texts[rule]} ({number})" for rule, number in zip(made, numbers, strict=True)])
    several = any(item.pair.family == pairing.POOLED and len(item.pair.b) > 1 for item in analysis.compared)
    weighted = ", pooled levels weighted by their runs" if several else ""
    sentences = [
        f"Treatment and control are compared on the days that hold runs of both{weighted}: {counts}.",
        _savings(analysis, ratio, "", " by the same contrast"),
        _holm(analysis),
        _equivalence(analysis),
        "The overall effect is the mean of the groups' savings (delta method), days' errors added before squaring. "
        "An F by the same errors (Box) tests whether groups agree."
        if analysis.overall.savings
        else "",
        _levels(analysis),
    ]
    return " ".join(filter(None, sentences))


def _route(analysis: StudyAnalysis) -> str:
    """Name the F-test and the t-tests that it chose."""
    found = [item.result for item in analysis.compared if is_defined(item.result.t)]
    if not found:
        return "No comparison has enough runs for a test."
    chosen = Counter(result.test for result in found)
    tests = list_text([f"{name}'s t-test in {count_text(count, 'comparison')}" for name, count in chosen.items()])
    beside = " and Brown and Forsythe's" if any(is_defined(result.brown_forsythe) for result in found) else ""
    alpha = f"{analysis.planned.settings.alpha:g}"
    if by_shared_days(analysis):
        return (
            f"Beside the tests that decide stand those of the thesis over all runs: an F-test for equal variances at "
            f"alpha = {alpha}, which chose {tests} (thesis 5.2.1){', Brown and Forsythe' if beside else ''}, and Welch."
        )
    return (
        f"Each comparison is an F-test for equal variances at alpha = {alpha}, which chose "
        f"{tests} (thesis 5.2.1). The p of claims and of tables is Welch's, which keeps its level where variances "
        f"differ; the chosen test{beside} stand{'' if beside else 's'} in the table of all tests."
    )


def _by_day(compared: Sequence[Compared]) -> str:
    found = [item.by_day for item in compared if item.by_day is not None]
    tested = [result for result in found if is_defined(result.t)]
    if not tested:
        return "No comparison could be made by day." if found else ""
    methods = Counter(method_by_day(result) for result in tested)
    texts = [f"{count_text(count, 'comparison')} by the {_BY_DAY.get(name, name)}" for name, count in methods.items()]
    untested = [f"{len(found) - len(tested)} could not be tested so"] if len(tested) < len(found) else []
    exact = " The exact test stands where the design is balanced." if set(methods) != {MIXED_MODEL} else ""
    rule = f"{exact} Either takes both sides to scatter alike." if tested else ""
    return (
        "Comparisons of each level, and of all pooled within a group, with its control were made again with the day as "
        f"a random effect, y ~ condition + (1 | day): {'; '.join([*texts, *untested])}.{rule}"
    )


def _holm(analysis: StudyAnalysis) -> str:
    counts = []
    for quantity in Outcome:
        of_quantity = [_deciding(item).adjusted for item in analysis.compared if item.quantity is quantity]
        shown = [adjusted for adjusted in of_quantity if adjusted is not None]
        if shown:
            tests = len(shown[0].adjusted_p)
            not_shown = f" ({tests - len(shown)} not in this selection)" if tests > len(shown) else ""
            counts.append(f"{tests} of {quantity}{not_shown}")
    if not counts:
        return ""
    family = FAMILY_OF[analysis.planned.settings.family]
    of = "p" if by_shared_days(analysis) else "Welch's p"
    return f"{of[0].upper()}{of[1:]} is adjusted by Holm's method over the family, {family}: {list_text(counts)}."


def _equivalence(analysis: StudyAnalysis) -> str:
    bounds = analysis.planned.settings.apex_bounds
    every = [_deciding(item).equivalent for item in analysis.compared]
    tested = [test for test in every if test is not None and is_defined(test.p)]
    if bounds is None or not tested:
        return ""
    by = "tests by that contrast" if by_shared_days(analysis) else "Welch tests"
    return (
        f"Equivalence of apex heights within {_bounds(bounds)} is tested by two one-sided {by} (TOST) in "
        f"{count_text(len(tested), 'comparison')}"
        f"{', unadjusted' if len(tested) > 1 else ''}."
    )


def _deciding(item: Compared) -> Compared | Decided:
    """Return where a comparison has the results that decide: by shared days, or Welch's."""
    return item.decided or item


def _bounds(bounds: Bounds) -> str:
    factor, unit = (1.0, "% of the control's mean") if bounds.percent else (1000.0, "mm")
    return f"{given_text(factor * bounds.low)} to {given_text(factor * bounds.high)} {unit}"


def _savings(analysis: StudyAnalysis, ratio: str, of: str, by: str) -> str:
    return f"Savings are {of}{ratio} with Fieller's interval{by}." if has_savings(analysis) else ""


def has_savings(analysis: StudyAnalysis) -> bool:
    """Whether the report has savings."""
    return any(item.result.savings is not None for item in analysis.compared)


def _levels(analysis: StudyAnalysis) -> str:
    settings = analysis.planned.settings
    alpha, outside = settings.alpha, settings.outside if has_savings(analysis) else settings.alpha
    comparisons = "" if alpha == 0.05 else f", those of comparisons at {level_text(1.0 - alpha)}"
    if outside != alpha:
        comparisons += f", those of savings, tested one-sided, at {level_text(1.0 - outside)}"
    equivalence = any(item.equivalent is not None for item in analysis.compared)
    tost = f", those of tests of equivalence at {level_text(1.0 - 2.0 * alpha)}" if equivalence else ""
    return f"Intervals are at 95 %{comparisons}{tost}."


def tests_beside(analysis: StudyAnalysis) -> str:
    """Return what the tests in full are, where others decide; "" where they decide themselves."""
    if not by_shared_days(analysis):
        return ""
    sentences = [_route(analysis), _by_day(analysis.compared), *_further(analysis)]
    return " ".join(filter(None, sentences))


def sources(analysis: StudyAnalysis, after_satterthwaite: bool) -> tuple[Source, ...]:
    """Return the sources of the methods used; `after_satterthwaite` where intervals of means are joined so."""
    routed = [item.result for item in analysis.compared if is_defined(item.result.t)]
    rules = {item.decided.result.rule for item in analysis.compared if item.decided is not None}
    by_day = [item.by_day for item in analysis.compared if item.by_day is not None and is_defined(item.by_day.t)]
    mixed = any(method_by_day(result) == MIXED_MODEL for result in by_day)
    holm, equivalence = bool(_holm(analysis)), bool(_equivalence(analysis))
    of_welch = bool(routed) or (not rules and (holm or equivalence))
    used = {
        Source.THESIS: bool(routed or analysis.jump_tests),
        Source.BROWN_FORSYTHE: any(is_defined(result.brown_forsythe) for result in routed),
        Source.FIELLER: has_savings(analysis),
        Source.HOLM: holm,
        Source.PAIRED_ON_DAY_MEANS: Rule.PAIRED in rules,
        Source.MIXED_MODEL: mixed,
        Source.SATTERTHWAITE: mixed or after_satterthwaite,
        Source.TOST: equivalence,
        Source.WELCH: of_welch or after_satterthwaite,
    }
    return tuple(source for source, is_used in used.items() if is_used)


def by_shared_days(analysis: StudyAnalysis) -> bool:
    """Whether comparisons are decided by the days that their sides share."""
    return any(item.decided is not None for item in analysis.compared)
