"""The reports of a book by the names that people use, the numbers of one, and which numbers moved between two, and why.

Numbers of two reports are matched by kind, scope and name of their results, for their ids change with their inputs. A
number was moved by the inputs, down to facts and bytes, that only one of the two results has; where there is none, by a
setting of labbook.toml.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import sqlalchemy as sa

from data_schema.errors import UnknownName, nearest, unknown_name
from data_schema.queries.reports import ReportRow, ResultHead, ShownRow, list_reports, result_heads, shown_numbers
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
from labbook.analysis.results.result_cache import equals_printed

LAST = "last"


@dataclass(frozen=True, slots=True)
class ReportNumber:
    """A number of a report: its provenance id, its name and scope, and its value, None where it is undefined.

    Of a number whose result the book has no longer, only id and value are known.
    """

    uid: str
    kind: str | None
    scope: Mapping[str, object]
    name: str | None
    unit: str | None
    value: float | None


@dataclass(frozen=True, slots=True)
class MovedNumber:
    """A number of two reports that differs in the second one; `causes` are positions in the list of all causes."""

    was: ReportNumber
    now: ReportNumber
    causes: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ReportsCompared:
    """Two reports: how many numbers both have, which of these moved, which only one has, and the causes between them.

    The headlines that moved stand first. `unmatched` counts, for each report, the numbers whose results the book has no
    longer, so that they cannot be matched with those of the other one.
    """

    before: ReportRow
    after: ReportRow
    common: int
    moved: tuple[MovedNumber, ...]
    only_before: tuple[ReportNumber, ...]
    only_after: tuple[ReportNumber, ...]
    unmatched: tuple[int, int]
    causes: tuple[Cause, ...]


def report_named(connection: sa.Connection, name: str) -> ReportRow:
    """Return a report by its number from 1, as `last` or `last-1`, or by the beginning of its uid.

    Raises `UnknownName` for a name of no report, or of several.
    """
    reports = list_reports(connection)
    back = re.fullmatch(rf"{LAST}(?:-([0-9]+))?", name)
    place = len(reports) - int(back[1] or 0) if back else int(name) if re.fullmatch("[0-9]{1,9}", name) else 0
    if 1 <= place <= len(reports):
        return reports[place - 1]
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


def report_numbers(connection: sa.Connection, report: ReportRow) -> list[ReportNumber]:
    """List what a report shows."""
    return [_number(row) for row in shown_numbers(connection, report.uid)]


def compare_reports(connection: sa.Connection, before: ReportRow, after: ReportRow) -> ReportsCompared:
    """Find which numbers moved from one report to another, and the statements between the two that moved them."""
    old, new = ({_identity(row): row for row in shown_numbers(connection, report.uid)} for report in (before, after))
    pairs = [(old[what], row) for what, row in new.items() if what in old]
    moved = [(was, now) for was, now in pairs if not equals_printed(was.value, now.value, now.se)]
    causes = causes_between(connection, (before, after))
    heads = result_heads(connection) if moved else {}
    results, found = _Results(heads, (row.result_uid or "" for row in old.values())), list[MovedNumber]()
    for was, now in moved:
        things = results.differing_inputs(was.result_uid, now.result_uid)
        places = [place for place, (_, things_touched) in enumerate(causes) if things & things_touched]
        found.append(MovedNumber(_number(was), _number(now), tuple(places)))
    alone = [[row for what, row in one.items() if what not in other] for one, other in ((old, new), (new, old))]
    only = [tuple(_number(row) for row in rows if row.result_uid is not None) for rows in alone]
    counts = [sum(place in item.causes for item in found) for place in range(len(causes))]
    return ReportsCompared(
        before=before,
        after=after,
        common=len(pairs),
        moved=tuple(sorted(found, key=_rank)),
        only_before=only[0],
        only_after=only[1],
        unmatched=(len(alone[0]) - len(only[0]), len(alone[1]) - len(only[1])),
        causes=tuple(replace(cause, moved=count) for (cause, _), count in zip(causes, counts, strict=True)),
    )


def _number(row: ShownRow) -> ReportNumber:
    scope = json.loads(row.scope_json) if row.scope_json else {}
    return ReportNumber(row.number_uid, row.kind, scope, row.name, row.unit, row.value)


def _rank(moved: MovedNumber) -> int:
    """Put the headlines first: the savings over all groups, then each group's; all else stays as the report has it."""
    number = moved.now
    if number.name != "savings" or "variant" in number.scope:
        return 3
    if number.kind == OVERALL.kind:
        return 0
    return 1 if number.kind == DECISION.kind and number.scope.get("family") == POOLED else 3


def _identity(row: ShownRow) -> tuple[str | None, ...]:
    """Return the key by which a number is found in another report: for one that is gone its id, which is unique."""
    return (row.number_uid,) if row.result_uid is None else (row.kind, row.scope_json, row.name)


_Leaf = tuple[str, str, str]
"""An input of a result that is no result: its kind, its uid and its hash, or what stands for these."""


class _Results:
    """Every stored result, and the inputs at the bottom that results depend on.

    A result with the content of one that the report `before` depends on stands for that one: inputs of only the newer
    of the two moved nothing.
    """

    def __init__(self, heads: Mapping[str, ResultHead], before: Iterable[str]) -> None:
        self.heads = heads
        self.before: dict[bytes, ResultHead] = {}
        step = [uid for uid in before if uid in heads]
        while step:
            fresh = [heads[uid] for uid in step if heads[uid].content not in self.before]
            self.before |= {head.content: head for head in fresh}
            step = list({uid for head in fresh for kind, uid, _sha256 in head.inputs if kind == "result"})
        self.leaves_of_runs: dict[bytes, frozenset[_Leaf]] = {}  # they are asked for again and again
        self.compared: dict[tuple[str, str], frozenset[Thing]] = {}

    def differing_inputs(self, old: str | None, new: str | None) -> frozenset[Thing]:
        """Return the inputs in which two results differ; nothing where they are one, or are gone."""
        if old is None or new is None or old == new:
            return frozenset()
        if (old, new) not in self.compared:
            leaves = [self._leaves(self.heads[uid]) for uid in (old, new)]
            self.compared[old, new] = frozenset(_differing(*leaves))
        return self.compared[old, new]

    def _leaves(self, head: ResultHead) -> frozenset[_Leaf]:
        if head.content in self.leaves_of_runs:
            return self.leaves_of_runs[head.content]
        head = self.before.get(head.content, head)
        scope = json.loads(head.scope_json)
        run = scope.pop("run", None)
        found = {(VERSION, head.kind, str(head.version))}
        for kind, uid, sha256 in head.inputs:
            found |= self._leaves(self.heads[uid]) if kind == "result" else {(kind, uid, sha256)}
        if run is not None:
            found.add((*SETTINGS, f"{head.kind} {scope}"))
            self.leaves_of_runs[head.content] = frozenset(found)
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
