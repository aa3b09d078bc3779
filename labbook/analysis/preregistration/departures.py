"""What departs from what was decided, and which comparisons are exploratory for it.

Only what differs in the end is listed: a correction that was taken back has changed nothing. Facts are compared with
what was first recorded after the first measurement; a difference makes those comparisons exploratory that lost a number
by it. They are also compared with what each report saw: a number that somebody had seen could have been replaced to
please, so that its conditions are exploratory.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cache
from typing import Any

from data_schema.outcomes import SOURCES, Outcome
from data_schema.queries.history import EntryRow
from data_schema.vocabulary import FileRole, RunKind, RunState
from labbook.analysis.preregistration.book_state import (
    NO_RUN,
    BookHistory,
    BookState,
    Change,
    ChangeKind,
    difference,
    state_at,
)
from reports.display import list_text


class DepartureKind(Enum):
    """What departs; the value says it in words."""

    NO_ANALYSIS = "labbook.toml has no [analysis] any more: what it said before the first run was ingested stands"
    SETTING = (
        "[analysis] had {name} {was} before the first run was ingested and has {now} in labbook.toml{since}: {effect}"
    )
    JUMP_RULE = (
        "{name} of [protocol] was {was} before the first run was ingested and is {now} in labbook.toml: it is used, "
        "and {exploratory} are exploratory"
    )
    RUN_CORRECTED = "corrected after the first measurement: {column} of run {run} was {was} and is {now} ({by}){lost}"
    CHARGE_CORRECTED = (
        "corrected after the first measurement: {column} of the charge of run {run} was {was} and is {now} ({by}){lost}"
    )
    CHARGE_MOVED = "corrected after the first measurement: run of a charge was {was} and is {now} ({by}){lost}"
    LOG_REMOVED = "corrected after the first measurement: {name} was taken off run {run} ({by}){lost}"
    LOG_MOVED = (
        "corrected after the first measurement: {name} was taken off run {run} and given to run {now} ({by}){lost}"
    )
    CONDITION_CHANGED = (
        "the condition of run {run} was corrected after a report had been made: it was {was} and is {now} ({by})"
    )
    REPLACED = "{now} replaced {was} as the {source} of run {run} after a report had been made ({by})"
    ADDED = "{name} was added to the {source} of run {run} after a report had been made ({by})"
    SURPLUS = "{name} came to run {run} when it had its {source} ({by}){lost}"
    VOIDED = "{runs} made void ({reason}) after a report had been made ({by})"
    RUNS_UNSELECTED = "the selection leaves out {runs} of the condition {condition} and takes its other runs"
    LEVELS_UNSELECTED = "the selection compares some levels of a group and leaves out {count} of it whole: {conditions}"
    CONDITIONS_UNSELECTED = (
        "the selection leaves out {count} whole, whose comparisons belong to the planned family (Holm's p of a report "
        "counts them): {conditions}"
    )

    def __str__(self) -> str:
        """Return the name, for programs."""
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class Departure:
    """What departs, with what its words name, and what is exploratory for it.

    `quantities` are those whose comparisons are exploratory, none where it is only listed; `conditions` the keys of the
    conditions that it is about, None where it is about all. `sentence` is `kind` in words, filled with `parameters`.
    """

    kind: DepartureKind
    parameters: Mapping[str, str]
    quantities: tuple[Outcome, ...] = ()
    conditions: tuple[str, ...] | None = None
    sentence: str = field(init=False)

    def __post_init__(self) -> None:
        """Put it in words."""
        object.__setattr__(self, "sentence", self.kind.value.format(**self.parameters))

    def touches(self, quantity: Outcome, conditions: Collection[str] | None) -> bool:
        """Tell whether it affects a comparison of these conditions; None stands for any conditions."""
        about_them = conditions is None or self.conditions is None or not set(self.conditions).isdisjoint(conditions)
        return quantity in self.quantities and about_them


def in_order(outcomes: Collection[Outcome]) -> tuple[Outcome, ...]:
    """Return outcomes in the order in which they are declared."""
    return tuple(outcome for outcome in Outcome if outcome in outcomes)


@cache  # asked for each run, of few different sets
def _of_source(outcomes: frozenset[Outcome], source: FileRole) -> tuple[Outcome, ...]:
    return tuple(outcome for outcome in in_order(outcomes) if outcome.source is source)


_LOST_BY: Mapping[str, Collection[FileRole]] = {
    "kind": SOURCES,
    "starts": (FileRole.LOG,),
    **dict.fromkeys(("jumps_made", "duration_s", "mode"), (FileRole.CHARGE,)),
}
"""From which sources a run can have lost a number when a column of it or of its charge says otherwise."""


def departures_since(
    history: BookHistory,
    now: BookState,
    reports: Mapping[int, BookState],
    first_seq: int,
    reported_elsewhere: Collection[str] = (),
) -> list[Departure]:
    """List how the book departs from what was first recorded after an entry, and from what reports saw since.

    Void runs named in `reported_elsewhere` are left out.
    """
    states = _States(history, now, reports, first_seq)
    void = _voided(states, reported_elsewhere)
    return [*_corrected(states), *_condition_changed(states), *_replaced(states), *_came_late(states), *void]


class _States:
    """The book as it was first recorded, as reports saw it and as it is now, and what several departures share."""

    def __init__(self, history: BookHistory, now: BookState, reports: Mapping[int, BookState], first_seq: int) -> None:
        self.history, self.now = history, now
        self.before = state_at(history, first_seq, arrivals=False)
        self.reports = reports
        self.counting = [uid for uid, run in now.runs.items() if run.state is not RunState.VOID]
        self.last = {(change.item, change.column): entry for entry, change in reversed(history.changes)}
        self.moves: dict[str, list[tuple[EntryRow, str, bool]]] = {}
        for entry, change in reversed(history.changes):
            if change.column == "run_uid":
                self.moves.setdefault(change.item, []).extend([(entry, change.was, False), (entry, change.now, True)])
        seen = self.counting if reports else []
        self.exchanged = [item for uid in seen for source in SOURCES for item in self._exchanged(uid, source)]
        self.elsewhere = {uid: keys for uid in seen if (keys := self._other_conditions(uid))}

    def _exchanged(self, run_uid: str, source: FileRole) -> Iterator[tuple[str, FileRole, list[str], list[str]]]:
        """Find what a number came from at a report and comes not from now, and what it comes from instead."""
        gone, came, has = dict[str, None](), dict[str, None](), self.now.contents(run_uid, source)
        for state in self.reports.values():
            had = state.contents(run_uid, source)
            if (left := _without(had, has)) and len(had) <= self.now.most(run_uid, source):
                gone, came = gone | left, came | _without(has, had)
        if gone and self.outcomes(run_uid, source):
            yield run_uid, source, list(gone), list(came)

    def _other_conditions(self, uid: str) -> list[str]:
        """Return the keys of other conditions in which reports saw a run that has numbers."""
        run = self.now.runs[uid]
        seen = dict.fromkeys(state.runs[uid].condition_key for state in self.reports.values() if uid in state.runs)
        keys = [key or "none" for key in seen if key != run.condition_key and run.kind is RunKind.JUMPS]
        return keys if keys and self.now.given(uid) else []

    def lost(self, uid: str) -> frozenset[Outcome]:
        """Return what had a number from a run that counts, as first recorded or at a report, and has none now."""
        states = [state for state in self.reports.values() if uid in state.runs]
        had = self.before.given(uid, surplus=False).union(*(state.given(uid) for state in states))
        same_kind = self.now.runs[uid].kind is self.before.runs[uid].kind
        return had - (self.now.given(uid) if same_kind else frozenset())

    def outcomes(self, run_uid: str, source: FileRole) -> tuple[Outcome, ...]:
        """Return what has a number from a run by a source."""
        return _of_source(self.now.given(run_uid), source)

    def role_of(self, file_uid: str) -> FileRole:
        """Return whether a file holds logs of heights or of forces."""
        return FileRole(next(log.role for (uid, _), log in self.now.logs.items() if uid == file_uid))

    def _arrivals(self, item: str, run_uid: str) -> list[EntryRow]:
        """Return the entries with which a charge or a file came to a run, in order."""
        moves = [(entry, came) for entry, other, came in self.moves.get(item, ()) if other == run_uid]
        arrivals = [entry for entry, came in moves if came]
        if not moves or not moves[0][1]:
            known = [entry for entry in (self.history.entry_of(item), self.history.since.get(run_uid)) if entry]
            arrivals.insert(0, max(known, key=lambda entry: entry.seq))
        return arrivals

    def arrival(self, item: str, run_uid: str) -> EntryRow:
        """Return the entry with which a charge or a file came to its run; an absence that no report saw was none."""
        missed = max((seq for seq, state in self.reports.items() if not state.has(run_uid, item)), default=0)
        return next(entry for entry in self._arrivals(item, run_uid) if entry.seq > missed)

    def undone(self, item: str, run_uid: str, source: FileRole) -> bool:
        """Tell whether a charge or a file came to a run after all that it can have, and no report saw it there.

        Taken off again, it leaves the run as it was; what came with the same command may have been chosen from.
        """
        first = self._arrivals(item, run_uid)[0]
        others = [self._arrivals(other, run_uid)[0] for other in self.now.contents(run_uid, source) if other != item]
        earlier = [other for other in others if other.seq < first.seq and _command(other) != _command(first)]
        seen = any(state.has(run_uid, item) for state in self.reports.values())
        return not seen and len(earlier) >= self.now.most(run_uid, source)

    def was_added(self, item: str, run_uid: str, source: FileRole) -> bool:
        """Tell whether a person added a charge to that of a run of which a report had shown the number."""
        if source is not FileRole.CHARGE or not self.now.charges[item].added:
            return False
        had = (state.contents(run_uid, source) for state in self.reports.values())
        return any(some and item not in some for some in had)

    def moved(self, item: str, run_uid: str) -> bool:
        """Tell whether a charge or a file had been another run's when it came to its run."""
        since, moves = self.arrival(item, run_uid).seq, self.moves.get(item, ())
        return any(not came and run not in (run_uid, NO_RUN) and entry.seq <= since for entry, run, came in moves)

    def named(self, items: Iterable[str], *, typed: str = "a typed charge", read: str = "a charge of ") -> str:
        """Name charges by the files that they were read from, and logs by theirs."""
        of, names = self.history.file_of, self.history.file_names
        files = [(of.get(item, item), read if item in of else "") for item in items]
        return " and ".join(f"{charge}{names[uid]}" if uid else typed for uid, charge in files)

    def shown(self, column: str, value: Any) -> str:
        """Return how the value of a column is shown."""
        if value is None or value == "":
            return "none"
        shown = self.now.runs[value].name if column == "run_uid" else value
        return f"{shown:g}" if isinstance(shown, float) else str(shown)

    def about(self, run_uid: str) -> tuple[str, ...] | None:
        """Return the conditions that depend on a run: its own, or all (None) on an idle run."""
        run = self.now.runs[run_uid]
        return None if run.kind is RunKind.IDLE else (run.condition_key,)


def _without(some: Mapping[str, frozenset[Any]], others: Mapping[str, frozenset[Any]]) -> dict[str, None]:
    """Return those whose contents others have not."""
    return {uid: None for uid, of in some.items() if uid not in others and of.difference(*others.values())}


def _by(entry: EntryRow) -> str:
    return f"{entry.person}, {entry.at_utc[:10]}"


def _leaves(states: _States, run_uids: Collection[str], outcomes: Collection[Outcome]) -> str:
    names = ", ".join(run.name for uid, run in states.now.runs.items() if uid in run_uids)
    return f", which leaves run {names} without {list_text(in_order(outcomes))}" if names else ""


def _corrected(states: _States) -> Iterator[Departure]:
    """Find what differs from what was first recorded, and charges and logs that only reports saw elsewhere."""
    now, reported = states.now, set[tuple[str, str, Any]]()
    exchanged = {(item, run_uid): bool(came) for run_uid, _, gone, came in states.exchanged for item in gone}
    changes = difference(states.before, now)
    for state in states.reports.values():
        changes += [change for change in difference(state, now) if change.column == "run_uid"]
    for change in changes:
        left, seen = (change.item, change.was), (change.item, change.column, change.was)
        if change.column == "run_uid":
            # A part of a file may have left a run that has another, and what replaced a charge or a log is listed.
            hidden = not change.was or now.has(change.was, change.item) or bool(not change.now and exchanged.get(left))
            if change.kind is ChangeKind.CHARGE and not change.now:  # its sheet may have come anew
                charges = now.contents(change.was, FileRole.CHARGE).values()
                hidden |= frozenset([now.charges[change.item].charge_mah]) in charges
            elif not change.now and not hidden:
                hidden = states.undone(change.item, change.was, states.role_of(change.item))
        else:
            hidden = change.column == "condition_key" and change.item in states.elsewhere
        if change.kind is not ChangeKind.EXCLUSION and not hidden and seen not in reported:
            reported.add(seen)
            yield _correction(states, change, fewer=change.kind is ChangeKind.LOG and exchanged.get(left) is False)


def _correction(states: _States, change: Change, *, fewer: bool = False) -> Departure:
    """Make the departure of a change; it affects comparisons where a run lost numbers, or has `fewer` logs now."""
    column, ends = change.column.removesuffix("_key"), [change.was, change.now]
    entry, owners, sources = states.last[change.item, column], [change.item], _LOST_BY.get(column, ())
    if change.kind is ChangeKind.LOG:
        kind, owners = DepartureKind.LOG_MOVED if change.now else DepartureKind.LOG_REMOVED, ends
        sources = (states.role_of(change.item),)
        entry = next(entry for entry, run, came in states.moves[change.item][::-1] if run == change.was and not came)
    elif column == "run_uid":
        kind, owners, sources = DepartureKind.CHARGE_MOVED, ends, (FileRole.CHARGE,)
    elif change.kind is ChangeKind.CHARGE:
        charges = states.now.charges[change.item], states.before.charges[change.item]
        kind, owners = DepartureKind.CHARGE_CORRECTED, [charges[0].run_uid or charges[1].run_uid]
    else:
        kind = DepartureKind.RUN_CORRECTED
        sources = () if column in ("jumps_made", "duration_s") and change.now else sources
    counting = [uid for uid in owners if uid in states.now.runs and states.now.runs[uid].state is not RunState.VOID]
    lost = {uid: [item for item in states.lost(uid) if item.source in sources] for uid in counting}
    lost = {uid: items for uid, items in lost.items() if items}
    outcomes = {item for items in lost.values() for item in items}
    keys = [states.before.runs[uid].condition_key for uid in lost]
    parameters = {
        "column": column,
        "name": states.history.file_names.get(change.item, ""),
        "run": states.shown("run_uid", owners[0]),
        "was": states.shown(change.column, change.was),
        "now": states.shown(change.column, change.now),
        "by": _by(entry),
        "lost": _leaves(states, lost, outcomes),
    }
    if fewer:
        parameters["lost"] += f", after a report had been made: run {parameters['run']} keeps its other logs"
        outcomes, keys = (
            {*states.outcomes(change.was, states.role_of(change.item))},
            [*keys, states.now.runs[change.was].condition_key],
        )
    return Departure(kind, parameters, in_order(outcomes), tuple(keys) if keys and all(keys) else None)


def _condition_changed(states: _States) -> Iterator[Departure]:
    """Find runs that are in another condition than when a report was made."""
    for uid, were in states.elsewhere.items():
        run, by = states.now.runs[uid], _by(states.last[uid, "condition"])
        words = {"run": run.name, "was": " and ".join(were), "now": run.condition_key, "by": by}
        conditions = (*were, run.condition_key)
        yield Departure(DepartureKind.CONDITION_CHANGED, words, in_order(states.now.given(uid)), conditions)


def _replaced(states: _States) -> Iterator[Departure]:
    """Find charges and logs that took the place of others after a report; what nothing replaced was taken off."""
    for uid, source, gone, came in states.exchanged:
        if came:
            last = max((states.arrival(item, uid) for item in came), key=lambda entry: entry.seq)
            words = {"was": states.named(gone), "now": states.named(came), "source": str(source), "by": _by(last)}
            words |= {"run": states.now.runs[uid].name}
            yield Departure(DepartureKind.REPLACED, words, states.outcomes(uid, source), states.about(uid))


def _came_late(states: _States) -> Iterator[Departure]:
    """Find what came to a run that had all it can have, or was added to what it had at a report.

    The first acts as an exclusion, unless one command brought all.
    """
    for uid, source in ((uid, source) for uid in states.counting for source in SOURCES):
        items, most = list(states.now.contents(uid, source)), states.now.most(uid, source)
        if not states.reports and len(items) <= most:
            continue
        words = {"run": states.now.runs[uid].name, "source": str(source)}
        lost: list[Outcome] = []
        if len(items) > most:
            without_surplus, given = states.now.given(uid, surplus=False), states.now.given(uid)
            lost = [item for item in without_surplus - given if item.source is source]
        if lost:
            items.sort(key=lambda item: states.arrival(item, uid).seq)
            last = _command(states.arrival(items[most - 1], uid))
            for item in items[most:]:
                entry = states.arrival(item, uid)
                if _command(entry) != last and not states.moved(item, uid):
                    name = states.named([item], typed="a further charge", read="a further charge of ")
                    words |= {"name": name, "by": _by(entry), "lost": _leaves(states, [uid], lost)}
                    yield Departure(DepartureKind.SURPLUS, words, in_order(lost), states.about(uid))
        for item in items:
            if states.was_added(item, uid, source) and states.outcomes(uid, source):
                words |= {"name": states.named([item]), "by": _by(states.arrival(item, uid))}
                yield Departure(DepartureKind.ADDED, words, states.outcomes(uid, source), states.about(uid))


def _voided(states: _States, reported_elsewhere: Collection[str]) -> Iterator[Departure]:
    """Find runs that are void and had numbers when a report was made, by who voided them and why."""
    void_entries, found = {entry.uid: entry for entry in states.history.void}, dict[Any, dict[str, set[Outcome]]]()
    for uid, run in states.now.runs.items():
        if run.state is RunState.VOID and run.name not in reported_elsewhere:
            seen = {item for state in states.reports.values() if uid in state.runs for item in state.given(uid)}
            if seen:
                of_idle = run.kind is RunKind.IDLE
                found.setdefault((void_entries[uid].reason or "", _by(void_entries[uid]), of_idle), {})[uid] = seen
    for (reason, by, of_idle), of in found.items():
        names = [states.now.runs[uid].name for uid in of]
        runs = f"run {names[0]} was" if len(names) == 1 else f"runs {first_named(names)} were"
        keys = None if of_idle else tuple(dict.fromkeys(states.now.runs[uid].condition_key for uid in of))
        words = {"runs": runs, "reason": reason, "by": by}
        yield Departure(DepartureKind.VOIDED, words, in_order(set().union(*of.values())), keys)


def first_named(names: Sequence[str], between: str = ", ") -> str:
    """Name the first of many and count how many more there are."""
    more = [f"and {len(names) - _MOST_NAMED} more"] if len(names) > _MOST_NAMED else []
    return between.join([*names[:_MOST_NAMED], *more])


_MOST_NAMED = 4


def _command(entry: EntryRow) -> str:
    """Return an id that all entries of one command share; the files of one `labbook ingest` share a batch."""
    return entry.new.get("batch") or str(entry.command)
