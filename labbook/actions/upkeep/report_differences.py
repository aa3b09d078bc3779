"""The reports of a book by the names that people use, the numbers of one, and which numbers moved between two, and why.

Numbers of two reports are matched by their paths, for their ids change with their inputs. A number was moved by the
inputs, down to facts and bytes, that only one of the two has; where there is none, by a setting of labbook.toml.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import sqlalchemy as sa

from data_schema.errors import UnknownName, nearest, unknown_name
from data_schema.queries.reports import ReportRow, list_reports
from labbook.actions.upkeep.report_causes import (
    LOST_RUN,
    OF_RUN,
    REGROUPED,
    SETTINGS,
    VERSION,
    Cause,
    Thing,
    causes_between,
)
from labbook.analysis.comparison.deciding import DECISION, OVERALL
from labbook.analysis.comparison.pairing import POOLED
from labbook.analysis.results import equals_printed
from labbook.book.opening import Book
from labbook.book.report_numbers import ReportedNumber, ReportedResult, ReportNumbers, read_numbers

LAST = "last"


@dataclass(frozen=True, slots=True)
class MovedNumber:
    """A number of two reports that differs in the second one; `causes` are positions in the list of all causes."""

    was: ReportedNumber
    now: ReportedNumber
    causes: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ReportsCompared:
    """Two reports: how many numbers both have, which of these moved, which only one has, and the causes between them.

    The headlines that moved stand first.
    """

    before: ReportRow
    after: ReportRow
    common: int
    moved: tuple[MovedNumber, ...]
    only_before: tuple[ReportedNumber, ...]
    only_after: tuple[ReportedNumber, ...]
    causes: tuple[Cause, ...]


def report_named(connection: sa.Connection, name: str) -> ReportRow:
    """Return a report by its number from 1, by the beginning of its uid, or as `last` or `last-1` of those made here.

    Raises `UnknownName` for a name of no report, or of several.
    """
    reports = list_reports(connection)
    back = re.fullmatch(rf"{LAST}(?:-([0-9]+))?", name)
    own = [report.number for report in reports if not report.elsewhere]
    if back:
        place = own[-1 - steps] if (steps := int(back[1] or 0)) < len(own) else 0
    else:
        place = int(name) if re.fullmatch("[0-9]{1,9}", name) else 0
    if 1 <= place <= len(reports):
        return reports[place - 1]
    if back or (name.isdigit() and len(name) < 4):
        count = "there is 1" if len(own) == 1 else f"there are {len(own) if back else len(reports)}"
        raise UnknownName(f"{name!r} is not a known report: {count}. `labbook reports list` lists them.")
    begun = [report for report in reports if name and report.uid.startswith(name)]
    if len(begun) == 1:
        return begun[0]
    if not reports:
        raise unknown_name("report", name, [])
    # Numbers that look alike are of other reports: what may be misspelt is an id or a word
    near = None if name.isdigit() else nearest(name, [*(report.uid for report in reports), LAST])
    count = "there is 1" if len(reports) == 1 else f"there are {len(reports)}"
    hint = f"{count}." if near is None else f"did you mean {near!r}?"
    raise UnknownName(f"{name!r} is not a known report: {hint} `labbook reports list` lists them.")


def compare_reports(book: Book, connection: sa.Connection, before: ReportRow, after: ReportRow) -> ReportsCompared:
    """Find which numbers moved from one report to another, and the statements between the two that moved them."""
    both = tuple(read_numbers(book.store.root, report) for report in (before, after))
    old, new = ({number.path: number for number in one.numbers.values()} for one in both)
    pairs = [(old[path], number) for path, number in new.items() if path in old]
    moved = [(was, now) for was, now in pairs if not equals_printed(was.value, now.value, now.se)]
    causes = causes_between(connection, (before, after))
    inputs, found = _Inputs(*both), list[MovedNumber]()
    for was, now in moved:
        things = inputs.differing(was, now)
        places = [place for place, (_, things_touched) in enumerate(causes) if things & things_touched]
        found.append(MovedNumber(was, now, tuple(places)))
    counts = [sum(place in item.causes for item in found) for place in range(len(causes))]
    return ReportsCompared(
        before=before,
        after=after,
        common=len(pairs),
        moved=tuple(sorted(found, key=lambda item: _rank(item.now, both[1].result_of(item.now)))),
        only_before=tuple(number for path, number in old.items() if path not in new),
        only_after=tuple(number for path, number in new.items() if path not in old),
        causes=tuple(replace(cause, moved=count) for (cause, _), count in zip(causes, counts, strict=True)),
    )


def _rank(number: ReportedNumber, result: ReportedResult) -> int:
    """Put the headlines first: the savings over all groups, then each group's; all else stays as the report has it."""
    if number.name != "savings" or "variant" in result.scope:
        return 3
    if result.kind == OVERALL.kind:
        return 0
    return 1 if result.kind == DECISION.kind and result.scope.get("family") == POOLED else 3


_Leaf = tuple[str, str, str]
"""An input of a result that is no result: its kind, its uid and its hash, or what stands for these."""


class _Inputs:
    """The inputs at the bottom that the results of two reports depend on.

    A result of the later report with the content of one of the earlier stands for that one: inputs of only the newer of
    the two moved nothing.
    """

    def __init__(self, before: ReportNumbers, after: ReportNumbers) -> None:
        self.reports = before, after
        self.same = {one.content: uid for uid, one in before.results.items()}
        self.leaves_of_runs: dict[str, frozenset[_Leaf]] = {}  # they are asked for again and again
        self.compared: dict[tuple[str, str], frozenset[Thing]] = {}

    def differing(self, was: ReportedNumber, now: ReportedNumber) -> frozenset[Thing]:
        """Return the inputs in which the results of two numbers differ; nothing where they are one."""
        pair = was.result, now.result
        if was.result == now.result:
            return frozenset()
        if pair not in self.compared:
            before, after = self.reports
            self.compared[pair] = frozenset(
                _differing(self._leaves(before, was.result), self._leaves(after, now.result))
            )
        return self.compared[pair]

    def _leaves(self, of: ReportNumbers, uid: str) -> frozenset[_Leaf]:
        result = of.results[uid]
        if result.content in self.same:
            of = self.reports[0]
            result = of.results[self.same[result.content]]
        if result.content in self.leaves_of_runs:
            return self.leaves_of_runs[result.content]
        found = {(VERSION, result.kind, str(result.version))}
        for row in result.inputs:
            if row.input_kind == "result":
                found |= self._leaves(of, row.input_uid)
            elif row.input_kind == "detection":
                name, _, version = row.input_uid.partition(", version ")
                found.add((row.input_kind, name, version))
            else:
                found.add((row.input_kind, row.input_uid, row.input_sha256))
        if "run" in result.scope:
            settings = {name: value for name, value in result.scope.items() if name != "run"}
            found.add((*SETTINGS, f"{result.kind} {settings}"))
            self.leaves_of_runs[result.content] = frozenset(found)
        return frozenset(found)


def _differing(old: frozenset[_Leaf], new: frozenset[_Leaf]) -> set[Thing]:
    """Return, as causes name them, the inputs that only one result has; where all are the same, what groups them."""
    was = {leaf[:2] for leaf in old}
    both = was & {leaf[:2] for leaf in new}
    found: set[Thing] = set()
    for kind, uid, _sha256 in old ^ new:
        if kind == "detection" and (kind, uid) in both:
            found.add((VERSION, uid))
        elif kind in ("detection", "scene"):
            found.add(SETTINGS)
        else:
            found.add((kind, uid))
        if kind == "run" and (kind, uid) not in both:
            found |= {(OF_RUN, uid), (LOST_RUN if (kind, uid) in was else OF_RUN, uid)}
    return found or {SETTINGS} | {(REGROUPED, uid) for kind, uid, _sha256 in old if kind == "run"}
