"""The paragraph on tests: it names every method that was used for this report, with how often, and no other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from data_schema.outcomes import Outcome
from data_schema.rounding import level_text
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparisons import Compared
from labbook.analysis.preregistration.planned import FAMILY_OF
from labbook.analysis.study import StudyAnalysis
from labbook.config.model import Bounds
from labbook.presenting.numbers import values_as
from labbook.presenting.report.error_rate_uses import uses
from labbook.presenting.report.known_error_rates import known_error_rates
from reports.display import stated_text
from reports.naming import SweptWords
from reports.numbers import Number
from reports.wording import count_text, list_text
from stats.days.blocked_result import MIXED_MODEL

_BY_DAY = {MIXED_MODEL: f"{MIXED_MODEL} (REML, degrees of freedom after Satterthwaite)"}


def tests_used(analysis: StudyAnalysis, called: SweptWords) -> str:
    """Return what conditions were compared by, or why nothing was compared."""
    if not analysis.compared:
        none = "no factor names a control level" if analysis.swept is None else "no group has a control and a treatment"
        return f"Nothing is compared: {none}. Intervals are at 95 %."
    sentences = [
        _route(analysis),
        _by_day(analysis.compared),
        _holm(analysis),
        _equivalence(analysis),
        _savings(analysis, called),
        "Levels of the treatment are compared by one-way analysis of variance." if analysis.anovas else "",
        "The same t-tests over single jumps stand in a table, as the thesis has them." if analysis.jump_tests else "",
        _levels(analysis),
    ]
    return " ".join(filter(None, sentences))


def known_errors(analysis: StudyAnalysis) -> tuple[str, ...]:
    """Return what is on record against the methods used: an introduction, and a sentence for each design."""
    return known_error_rates(uses(analysis))


def _route(analysis: StudyAnalysis) -> str:
    """Name the F-test and the t-tests that it chose."""
    found = [item.result for item in analysis.compared if _exists(item.result.t)]
    if not found:
        return "No comparison has enough runs for a test."
    chosen = Counter(result.test for result in found)
    tests = list_text([f"{name}'s t-test in {count_text(count, 'comparison')}" for name, count in chosen.items()])
    beside = " and Brown and Forsythe's" if any(_exists(result.brown_forsythe) for result in found) else ""
    return (
        f"Each comparison is an F-test for equal variances at alpha = {analysis.planned.settings.alpha:g}, which chose "
        f"{tests} (thesis 5.2.1). The p of claims and of tables is Welch's, which keeps its level where variances "
        f"differ; the chosen test{beside} stand{'' if beside else 's'} in the table of all tests."
    )


def _by_day(compared: Sequence[Compared]) -> str:
    found = [item.by_day for item in compared if item.by_day is not None]
    tested = [result for result in found if _exists(result.t)]
    if not tested:
        return "No comparison could be made by day." if found else ""
    methods = Counter(values_as("run", result.method) for result in tested)
    said = [f"{count_text(count, 'comparison')} by the {_BY_DAY.get(name, name)}" for name, count in methods.items()]
    untold = [f"{len(found) - len(tested)} could not be tested so"] if len(tested) < len(found) else []
    exact = " The exact test stands where the design is balanced." if set(methods) != {MIXED_MODEL} else ""
    rule = f"{exact} Either takes both sides to scatter alike." if tested else ""
    return (
        "Comparisons of each level, and of all pooled within a group, with its control were made again with the day as "
        f"a random effect, y ~ condition + (1 | day): {'; '.join([*said, *untold])}.{rule}"
    )


def _holm(analysis: StudyAnalysis) -> str:
    counts = []
    for quantity in Outcome:
        shown = [item.adjusted for item in analysis.compared if item.quantity is quantity and item.adjusted is not None]
        if shown:
            tests = len(shown[0].adjusted_p)
            not_shown = f" ({tests - len(shown)} not in this selection)" if tests > len(shown) else ""
            counts.append(f"{tests} of {quantity}{not_shown}")
    if not counts:
        return ""
    family = FAMILY_OF[analysis.planned.settings.family]
    return f"Welch's p is adjusted by Holm's method over the family, {family}: {list_text(counts)}."


def _equivalence(analysis: StudyAnalysis) -> str:
    bounds = analysis.planned.settings.apex_bounds
    tested = [item for item in analysis.compared if item.equivalent is not None and _exists(item.equivalent.p)]
    if bounds is None or not tested:
        return ""
    return (
        f"Equality of apex heights within {_bounds(bounds)} is tested by two one-sided Welch tests (TOST) in "
        f"{count_text(len(tested), 'comparison')}."
        f"{' Their p are not adjusted for their number.' if len(tested) > 1 else ''}"
    )


def _bounds(bounds: Bounds) -> str:
    factor, unit = (1.0, "% of the control's mean") if bounds.percent else (1000.0, "mm")
    return f"{stated_text(factor * bounds.low)} to {stated_text(factor * bounds.high)} {unit}"


def _savings(analysis: StudyAnalysis, called: SweptWords) -> str:
    if not saved(analysis):
        return ""
    ratio = f"({called.control} - {called.treatment_short}) / {called.control}"
    return f"Savings are the ratio of means {ratio} with Fieller's interval."


def saved(analysis: StudyAnalysis) -> bool:
    """Whether the report has savings."""
    return any(item.result.savings is not None for item in analysis.compared)


def _levels(analysis: StudyAnalysis) -> str:
    alpha = analysis.planned.settings.alpha
    comparisons = "" if alpha == 0.05 else f", those of comparisons at {level_text(1.0 - alpha)}"
    equivalence = any(item.equivalent is not None for item in analysis.compared)
    tost = f", those of tests of equivalence at {level_text(1.0 - 2.0 * alpha)}" if equivalence else ""
    return f"Intervals are at 95 %{comparisons}{tost}."


def _exists(number: Number) -> bool:
    return not isinstance(number.value, Undefined)
