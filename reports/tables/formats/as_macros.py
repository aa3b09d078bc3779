r"""Numbers of page one and of planned comparisons as LaTeX macros, for `\input{numbers}`: `\labbookOverallSaving{}`.

A name says what the number is and of which group; levels are spelt out, for a macro's name has letters alone. It stays
the same from report to report, so that a paper takes over new numbers when it is typeset again. Numbers of groups whose
names would be the same ("a b" and "ab") have none: a paper must not get another group's number unseen.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.content import ReportContent
from reports.display import as_shown, interval_text, p_text, places_of, value_text, with_unit
from reports.evidence import Comparison, Decision, OverallEquivalence, OverallSavings
from reports.fields import MacroWords
from reports.naming import swept_factor
from reports.numbers import Number, Value
from reports.tables.formats.as_latex import latex_text

_HEAD = (
    "% Numbers of a report by labbook {}: \\input this file, and write \\labbookRunsDone{{}} in a sentence.\n"
    "% After each macro stands the provenance id of its number: labbook why ID.\n"
)
_SIGNS = {
    "0": "Zero",
    "1": "One",
    "2": "Two",
    "3": "Three",
    "4": "Four",
    "5": "Five",
    "6": "Six",
    "7": "Seven",
    "8": "Eight",
    "9": "Nine",
    ".": "Point",
    "-": "Minus",
    "\u2212": "Minus",
    "+": "Plus",
}


@dataclass(frozen=True, slots=True)
class Macro:
    """A macro: its name without the backslash, the text as the report prints it, the id that it comes from."""

    name: str
    text: str
    provenance: str = ""


def macros_of(content: ReportContent) -> tuple[Macro, ...]:
    """Return a macro a number of page one and of planned comparisons, but for those whose names would be the same."""
    found = (*_counts(content), *_over_groups(content), *_by_group(content), *_contrasts(content))
    times = Counter(macro.name for macro in found)
    return tuple(macro for macro in found if times[macro.name] == 1)


def macros_bytes(content: ReportContent) -> bytes:
    """Write the macros as a file for LaTeX, UTF-8."""
    lines = [
        rf"\newcommand{{\{macro.name}}}{{{latex_text(macro.text)}}}"
        + (f" % {macro.provenance}" * bool(macro.provenance))
        for macro in macros_of(content)
    ]
    return (_HEAD.format(content.software_version) + "\n".join(lines) + "\n").encode("utf-8")


def macro_name(*words: str) -> str:
    """Join words to a name for LaTeX: letters stay, each word begins with a capital, digits and signs are spelt out.

    A sign without a word of its own, such as a letter with an accent, has its code point.
    """
    coded = (re.sub(r"[^A-Za-z0-9_ .+\u2212-]", lambda sign: f" code {ord(sign[0])} ", word) for word in words)
    spelt = (re.sub(r"[0-9.+\u2212-]", lambda sign: f" {_SIGNS[sign[0]]} ", word) for word in coded)
    parts = re.findall(r"[A-Za-z]+", " ".join(spelt).replace("_", " "))
    return "labbook" + "".join(part[0].upper() + part[1:] for part in parts)


def _counts(content: ReportContent) -> Iterator[Macro]:
    flow = content.flow
    if flow.runs_planned is not None:
        yield Macro(macro_name(MacroWords.RUNS_PLANNED), str(flow.runs_planned))
    counts = {"done": flow.runs_done, "void": flow.runs_void, "idle": flow.runs_idle}
    for name, count in counts.items():
        yield Macro(macro_name(MacroWords.RUNS, name), str(count))
    for outcome in content.outcomes:
        yield Macro(macro_name(MacroWords.RUNS_WITH, outcome.key), str(flow.runs_with[outcome]))
    if flow.runs_with.get(Outcome.APEX):  # jumps are counted of the runs that have apex heights
        yield Macro(macro_name(MacroWords.JUMPS_MADE), str(flow.jumps_made))
        yield Macro(macro_name(MacroWords.JUMPS_ANALYSED), str(flow.jumps_analysed))
    yield Macro(macro_name(MacroWords.DAYS_MEASURED), str(len(content.days)))


def _over_groups(content: ReportContent) -> Iterator[Macro]:
    for overall in content.overall:
        name = (MacroWords.OVERALL_SAVING, "" if overall.quantity is Outcome.JOULES else overall.quantity.key)
        yield from _number(name, overall.savings, overall.test.p)
        yield from _scope(name, overall, overall.savings)
        yield from _value((*name, MacroWords.SPREAD), overall.spread, overall.savings)
    if content.overall_equivalence is not None:
        tested = content.overall_equivalence
        heights = (MacroWords.OVERALL_APEX_EQUIVALENCE,)
        yield from _number(heights, tested.estimate, tested.p.value)
        yield from _scope(heights, tested, tested.estimate)


def _scope(name: Iterable[str], scope: OverallSavings | OverallEquivalence, number: Number) -> Iterator[Macro]:
    yield Macro(macro_name(*name, MacroWords.GROUPS), str(len(scope.groups)), number.provenance)
    yield Macro(macro_name(*name, MacroWords.DAYS), str(len(scope.days)), number.provenance)


def _by_group(content: ReportContent) -> Iterator[Macro]:
    for comparison in (*content.pooled, *_planned_levels(content)):
        group = [f"{factor} {level}" for factor, level in comparison.group.items()]
        name = (comparison.quantity.key, *group, *_level(content, comparison))
        lead = comparison.decision
        if lead.savings is not None:
            yield from _number((*name, MacroWords.SAVING), lead.savings, lead.test.p)
        yield from _number((*name, MacroWords.DIFFERENCE), lead.difference, lead.test.p)
        yield from _runs(name, lead)
        if (tested := lead.equivalence) is not None:
            yield from _number((*name, MacroWords.EQUIVALENCE), tested.estimate, tested.p.value)


def _contrasts(content: ReportContent) -> Iterator[Macro]:
    for one in (each for each in content.contrasts if not each.exploratory):
        words = (str(one.kind), one.quantity.key, one.factor, *one.levels, one.side)
        at = () if one.at is None else (MacroWords.AT, f"{one.at:g}")
        yield from _number((MacroWords.CONTRAST, *filter(None, words), *at), one.estimate, one.test.p)


def _planned_levels(content: ReportContent) -> list[Comparison]:
    """Return the comparisons of one level with the control that the plan names."""
    return [each for each in content.by_group if not (each.opens or each.exploratory)]


def _level(content: ReportContent, comparison: Comparison) -> list[str]:
    swept = swept_factor(content)
    return [] if comparison.opens or swept is None else [f"{swept.name} {comparison.level}"]


def _runs(name: tuple[str, ...], lead: Decision) -> Iterator[Macro]:
    identity = lead.difference.provenance
    yield Macro(macro_name(*name, MacroWords.RUNS_CONTROL), str(lead.n_control), identity)
    yield Macro(macro_name(*name, MacroWords.RUNS_TREATMENT), str(lead.n_treatment), identity)
    yield Macro(macro_name(*name, MacroWords.DAYS), str(len(lead.days)), identity)
    if lead.adjusted is not None:
        yield Macro(macro_name(*name, MacroWords.HOLM), p_text(lead.adjusted.value), lead.adjusted.provenance)


def _number(name: Iterable[str], number: Number, p: Value) -> Iterator[Macro]:
    """Give a number, the ends of its interval, the interval in one, and p."""
    shown, places = as_shown(number), places_of(number)
    yield from _value(name, number, number)
    for end, value in ((MacroWords.LOW, shown.ci_low), (MacroWords.HIGH, shown.ci_high)):
        if value is not None:
            yield Macro(macro_name(*name, end), _with_unit(value, places, shown.unit), number.provenance)
    if interval := interval_text(number):
        yield Macro(macro_name(*name, MacroWords.INTERVAL), interval, number.provenance)
    yield Macro(macro_name(*name, MacroWords.P), p_text(p), number.provenance)


def _value(name: Iterable[str], number: Number, digits_of: Number) -> Iterator[Macro]:
    shown = as_shown(number)
    text = _with_unit(shown.value, places_of(digits_of), shown.unit)
    yield Macro(macro_name(*name), text, number.provenance)


def _with_unit(value: Value, places: int | None, unit: str) -> str:
    text = value_text(value, places)
    return text if isinstance(value, Undefined) else with_unit(text, unit)
