"""A journal whose hashes fit and that no labbook wrote: refused in a sentence wherever it comes in, nothing written."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from data_schema.errors import BookDamaged
from data_schema.journal import Entry
from data_schema.journal_rules import checked
from data_schema.vocabulary import Action
from labbook.actions.upkeep.merging import merge
from labbook.actions.upkeep.restoring import restore
from tests.helpers.books import ADA, SmallBook, reported_book, small_book
from tests.helpers.folders import contents
from tests.helpers.journals import renumbered
from tests.helpers.statements import in_file, note, state
from tests.helpers.upkeep import health, rebuilt, untold

EVIL = "../../../../evil"


def with_new(**said: Any) -> Callable[[Entry], Entry]:
    return lambda entry: replace(entry, new={**(entry.new or {}), **said})


def about_run(action: Action, **said: Any) -> Callable[[Entry], Entry]:
    """Change a note on a run into another statement on it."""
    return lambda entry: replace(
        entry, action=action, entity_kind="run", entity_uid=(entry.new or {})["target_uid"], **said
    )


def nested(depth: int) -> list[Any]:
    inner: list[Any] = []
    for _ in range(depth):
        inner = [inner]
    return inner


INGEST, NOTE = Action.INGEST, Action.NOTE
VERDICT = {"target_kind": "run", "target_uid": "x", "verdict": "accept", "reason_code": "other", "blind": 0}
SET, EXCLUDE, INCLUDE = Action.SET, Action.EXCLUDE, Action.INCLUDE
OF_ANOTHER_SHAPE: Mapping[str, tuple[Action, Callable[[Entry], Entry]]] = {
    "old of a note": (NOTE, lambda entry: replace(entry, old={"text": "the first word"})),
    "old of a plan": (
        NOTE,
        lambda entry: replace(entry, action=Action.PLAN, entity_kind="plan", old={"seed": 1}, new={"seed": 2}),
    ),
    "old of a report": (Action.REPORT, lambda entry: replace(entry, old={"where": ""})),
    "old of a verdict": (
        NOTE,
        lambda entry: replace(entry, action=INCLUDE, entity_kind="decision", old={"verdict": "reject"}, new=VERDICT),
    ),
    "old of a set verdict": (
        NOTE,
        lambda entry: replace(
            entry, action=SET, entity_kind="decision", old={"blind": 1}, new={**VERDICT, "verdict": "clear"}
        ),
    ),
    "no old of a run that is void": (NOTE, about_run(EXCLUDE, new={"state": "void"})),
    "no old of a run that counts": (NOTE, about_run(INCLUDE, new={"state": "complete"})),
    "jumps of a run that is void": (NOTE, about_run(EXCLUDE, old={"jumps_made": 3}, new={"jumps_made": 9})),
    "jumps of a run that counts": (
        NOTE,
        about_run(INCLUDE, old={"state": "void"}, new={"state": "complete", "jumps_made": 9}),
    ),
    "values of a charge out of use": (
        NOTE,
        lambda entry: replace(entry, action=EXCLUDE, entity_kind="charge", new={"charge_mah": 5.0}),
    ),
    "old of a charge in use": (
        NOTE,
        lambda entry: replace(entry, action=INCLUDE, entity_kind="charge", old={"charge_mah": 5.0}, new=None),
    ),
    "no old of a file's run": (
        NOTE,
        lambda entry: replace(entry, action=SET, entity_kind="file", new={"run": None}),
    ),
    "no old of a link's run": (
        NOTE,
        lambda entry: replace(entry, action=SET, entity_kind="run_file", new={"run": None}),
    ),
    "nothing old": (NOTE, about_run(SET, old={}, new={"jumps_made": 9})),
}
FORGED: Mapping[str, tuple[Action, Callable[[Entry], Entry]]] = {
    "hash": (INGEST, with_new(sha256=EVIL)),
    "hash of samples": (INGEST, with_new(signals=[EVIL])),
    "no hash": (INGEST, lambda entry: replace(entry, new={"original_name": "x"})),
    "settings": (INGEST, with_new(settings={"declared": 5})),
    "values": (
        NOTE,
        lambda entry: replace(entry, action=SET, entity_kind="file", old={"runs": []}, new={"role": "log"}),
    ),
    "text": (NOTE, lambda entry: replace(entry, action=Action.SET, entity_kind="condition", new={"levels": 5})),
    "report": (Action.REPORT, with_new(files={"numbers.json": EVIL})),
    "entry of a report": (Action.REPORT, with_new(as_of=0)),
    "time": (NOTE, lambda entry: replace(entry, at_utc="2021-02-30T25:00:00Z")),
    "no time": (NOTE, lambda entry: replace(entry, at_utc=5)),
    "uid": (NOTE, lambda entry: replace(entry, entity_uid=EVIL)),
    "kind": (NOTE, lambda entry: replace(entry, entity_kind="sqlite_master")),
    "kind of an action": (NOTE, lambda entry: replace(entry, action=Action.EXCLUDE)),
    "verdict": (NOTE, lambda entry: replace(entry, action=Action.EXCLUDE, entity_kind="decision", new=VERDICT)),
    "column": (NOTE, with_new(id=5, no_such_column=1)),
    "value": (NOTE, with_new(text=nested(3))),
    "nul": (NOTE, with_new(text="a\0b")),
    "nesting": (NOTE, with_new(text=nested(300))),
    "deep nesting": (NOTE, with_new(text=nested(900))),
    "person": (NOTE, lambda entry: replace(entry, person="")),
    "number": (NOTE, with_new(target_uid=10**30)),
    "reason": (NOTE, lambda entry: replace(entry, reason={"a": 1})),
    "origin": (NOTE, lambda entry: replace(entry, origin={"seq": "1"})),
    "no values": (NOTE, lambda entry: replace(entry, new=None)),
    "read again": (INGEST, lambda entry: replace(entry, old={"reading": "x"})),
    **OF_ANOTHER_SHAPE,
}


@pytest.fixture(params=FORGED)
def forged(request: pytest.FixtureRequest, tmp_path: Path) -> SmallBook:
    """A book whose journal a forger changed: the last entry of one kind, or one more, and chained all anew."""
    book = reported_book(tmp_path / "forged")
    with book.open() as standing:
        state(standing, note, "the last word")
        entries = in_file(standing)
    action, change = FORGED[request.param]
    place = max(place for place, entry in enumerate(entries) if entry.action is action)
    entries[place] = change(entries[place])
    book.journal.write_text("".join(f"{entry.line}\n" for entry in renumbered(entries)), encoding="utf-8")
    return book


def refuses_it(do: Callable[[], object]) -> None:
    with pytest.raises(BookDamaged) as caught:
        do()
    assert "\n" not in str(caught.value)


def test_none_is_restored(forged: SmallBook, tmp_path: Path) -> None:
    (tmp_path / "a" / "b" / "c").mkdir(parents=True)
    target = tmp_path / "a" / "b" / "c" / "again"
    before = contents(tmp_path)
    refuses_it(lambda: restore(forged.folder, target, None, lambda _step: None, untold))
    after = {name for name in contents(tmp_path) if not name.startswith("a/b/c/again")}
    assert after == before.keys()


def test_none_is_merged(forged: SmallBook, tmp_path: Path) -> None:
    own = small_book(tmp_path / "own")
    rebuilt_from = shutil.copytree(forged.folder, tmp_path / "other")
    before = contents(own.folder)
    with own.open() as book:
        refuses_it(lambda: merge(book, rebuilt_from, ADA))
    after = contents(own.folder)
    assert {name for name in after if "labbook.db" not in name} == {name for name in before if "labbook.db" not in name}


def test_none_is_rebuilt_or_called_whole(forged: SmallBook) -> None:
    assert not health(forged, deep=True).whole
    refuses_it(lambda: rebuilt(forged))


@pytest.mark.parametrize("forged", OF_ANOTHER_SHAPE, indirect=True)
def test_none_of_another_shape_is_let_through(forged: SmallBook) -> None:
    with forged.open() as book:
        refuses_it(lambda: list(checked(in_file(book))))


PLAN = {"action": Action.PLAN, "entity_kind": "plan", "entity_uid": "p1"}


@pytest.mark.parametrize(
    "said",
    [
        {**PLAN, "new": {"runs": 5}},
        {**PLAN, "new": {"runs": [5]}},
        {**PLAN, "new": {}},
        {"entity_uid": "n1", "schema": 7},
    ],
)
def test_none_that_waits_is_applied(said: Mapping[str, Any], tmp_path: Path) -> None:
    book = small_book(tmp_path / "book")
    with book.open() as standing:
        state(standing, note, "the last word")
        entries = in_file(standing)
        forged = replace(entries[-1], **said)
        lines = [entry.line for entry in renumbered([*entries, forged])]
        book.journal.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
        refuses_it(lambda: state(standing, note, "a word"))
