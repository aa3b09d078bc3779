"""What an entry of a journal may hold: its hash shows that a line is what somebody wrote, not that labbook did.

Entries come in from files that others hand over, by `labbook merge`, `labbook restore` or a book that was copied, and
their hashes name files of the store. What is wrong with the thing that an entry speaks of, the tables say when it takes
effect.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from datetime import datetime
from typing import Any

from data_schema.errors import BookDamaged, InputRefused
from data_schema.journal import MEND_FILE, Entry
from data_schema.tables import FACTS
from data_schema.vocabulary import USING, Action, Verdict

MOST_NESTED = 20
"""How deep lists and tables of an entry may lie in each other; none of labbook's has more than 7."""
_LARGEST = 2**53
_TIME = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,6})?Z", re.ASCII)
_UID = re.compile(r"[\w.:-]{1,80}", re.ASCII)
_SHA256 = re.compile(r"[0-9a-f]{64}", re.ASCII)
_USED = ("run", "file", "charge", "decision")
_KINDS: Mapping[Action, Collection[str]] = {
    Action.SET: FACTS.keys() - {"note", "plan", "report"},
    Action.EXCLUDE: (*_USED, "plan"),
    Action.INCLUDE: _USED,
    Action.MERGE: ("book",),
}
"""What entries are about, by action; the others are about the kind of their name."""
BESIDE = {
    "condition": {"levels"},
    "plan": {"runs", "looks"},
    "file": {"run", "role", "part", "runs", "charges"},
}
"""What statements on a kind hold that is no column of its table."""
_COLUMNS = {kind: {column.name for column in table.c} | BESIDE.get(kind, set()) for kind, table in FACTS.items()}
_NEEDED: Mapping[str, Collection[str]] = {
    Action.INGEST: ("sha256", "original_name", "options", "settings", "reader", "reader_version", "rows"),
    Action.REPORT: ("where", "made_at", "numbers", "versions", "folder", "files"),
    Action.MERGE: ("until", "uids"),
    **dict.fromkeys((Action.SET, Action.NOTE, Action.PLAN), ()),
    "decision": ("target_kind", "target_uid", "verdict"),
}
"""What `new` must have, by action, and of a decision; for others it may be missing."""

_SHAPES: Mapping[tuple[Action, str], tuple[bool, Collection[str] | None]] = {
    **dict.fromkeys([(Action.NOTE, "note"), (Action.PLAN, "plan"), (Action.REPORT, "report")], (False, None)),
    **dict.fromkeys([(action, "decision") for action in (Action.SET, *USING)], (False, None)),
    **dict.fromkeys([(Action.SET, "file"), (Action.SET, "run_file")], (True, None)),
    **dict.fromkeys([(action, "run") for action in USING], (True, ("state",))),
    **dict.fromkeys([(action, "charge") for action in USING], (False, ())),
}
"""Whether `old` must be there or must not, and what alone `new` may hold; for others both are as they like."""


def checked(entries: Iterable[Entry], remedy: str = MEND_FILE) -> Iterator[Entry]:
    """Pass entries on that come in; raises `BookDamaged`, with the `remedy`, at the first that labbook never writes."""
    for entry in entries:
        fault = next(_faults(entry), None)
        if fault is not None:
            raise BookDamaged(f"journal entry {str(entry.seq)[:20]} is none that labbook writes ({fault}): {remedy}.")
        yield entry


@contextlib.contextmanager
def wrong_kinds_refused() -> Iterator[None]:
    """Raise `InputRefused` where an entry takes effect whose values have the right names and are of a wrong kind."""
    try:
        yield
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise InputRefused(f"{type(error).__name__}: {error}") from error


def _faults(entry: Any) -> Iterator[str]:  # of any kind are the values that JSON can hold
    for name, least in (("seq", 1), ("following", 0)):
        number = getattr(entry, name)
        if type(number) is not int or not least <= number < _LARGEST:
            yield f"{name} {number!r} is no number of an entry"
    if not (isinstance(entry.at_utc, str) and _is_time(entry.at_utc)):
        yield f"at_utc {_shown(entry.at_utc)} is no time in UTC"
    if not (isinstance(entry.person, str) and entry.person):
        yield f"person {_shown(entry.person)} is no name"
    if not isinstance(entry.entity_kind, str) or entry.entity_kind not in _KINDS.get(entry.action, (entry.action,)):
        yield f"entity_kind {_shown(entry.entity_kind)} is nothing that one can {entry.action}"
    if not (isinstance(entry.entity_uid, str) and _UID.fullmatch(entry.entity_uid)):
        yield f"entity_uid {_shown(entry.entity_uid)} is no name of a row"
    if not (entry.reason is None or isinstance(entry.reason, str)):
        yield f"reason {_shown(entry.reason)} is no text"
    for name in ("old", "new", "origin"):
        if not (getattr(entry, name) is None or isinstance(getattr(entry, name), dict)):
            yield f"{name} {_shown(getattr(entry, name))} is no table"
    if not _is_hash(entry.prev_hash):
        yield f"prev_hash {_shown(entry.prev_hash)} is no SHA-256"
    if (origin := entry.origin) is not None and not (type(origin.get("seq")) is int and _is_hash(origin.get("hash"))):
        yield f"origin {_shown(origin)} names no entry"
    line = entry.line
    if line.count("{") + line.count("[") > MOST_NESTED and _nested(entry.old, entry.new) > MOST_NESTED:
        yield f"its values lie more than {MOST_NESTED} deep in each other"
        return
    if "\\u0000" in line and _has_nul([entry.person, entry.reason, entry.old, entry.new]):
        yield "a text in it holds NUL"
    yield from _faults_of_values(entry, entry.new or {})


def _faults_of_values(entry: Entry, new: Mapping[str, Any]) -> Iterator[str]:
    about = "decision" if entry.entity_kind == "decision" else entry.action
    missing = [name for name in _NEEDED.get(about, ()) if name not in new]
    if missing or (entry.new is None and about in _NEEDED):
        yield f"its values lack {', '.join(missing) or 'everything'}"
    if about == "decision" and new["verdict"] not in [one for one in Verdict if one.action is entry.action]:
        yield f"verdict {_shown(new['verdict'])} is none by which one can {entry.action}"
    changes, alone = _SHAPES.get((entry.action, entry.entity_kind), (None, None))
    if entry.old == {} or changes not in (None, entry.old is not None):
        yield f"old {_shown(entry.old)} is nothing that stood there before"
    if entry.entity_kind in _COLUMNS and entry.action is not Action.REPORT:
        odd = sorted(new.keys() - (_COLUMNS[entry.entity_kind] if alone is None else alone))
        if odd:
            yield f"{_shown(odd[0])} is nothing that a {entry.entity_kind} has"
    for name, value in new.items():
        if name.endswith("sha256") and not (value is None or _is_hash(value)):
            yield f"{name} {_shown(value)} is no SHA-256"
    listed = {name: new[name] for name in ("signals", "times") if name in new and entry.action is Action.INGEST}
    if entry.action is Action.REPORT:
        as_of = new.get("as_of", 1)
        if type(as_of) is not int or not 1 <= as_of < (_LARGEST if entry.origin else entry.seq):
            yield f"as_of {_shown(as_of)} is no entry before it"
        listed["files"] = [*new["files"].values()] if isinstance(new["files"], dict) else None
    for name, values in listed.items():
        if not isinstance(values, list) or not all(value is None or _is_hash(value) for value in values):
            yield f"{name} {_shown(values)} are no SHA-256"


def _is_time(text: str) -> bool:
    if not _TIME.fullmatch(text):
        return False
    try:
        datetime.fromisoformat(text)
    except ValueError:
        return False
    return True


def _is_hash(value: object) -> bool:
    return isinstance(value, str) and _SHA256.fullmatch(value) is not None


def _nested(*values: object) -> int:
    """Return how deep values lie in each other, found without going down into them one in the other."""
    depth, level = 0, [value for value in values if isinstance(value, dict | list)]
    while level and depth <= MOST_NESTED:
        inside = [part for value in level for part in (value.values() if isinstance(value, dict) else value)]
        depth, level = depth + 1, [part for part in inside if isinstance(part, dict | list)]
    return depth


def _has_nul(value: object) -> bool:
    if isinstance(value, dict):
        return any(map(_has_nul, (*value.keys(), *value.values())))
    if isinstance(value, list):
        return any(map(_has_nul, value))
    return isinstance(value, str) and "\0" in value


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
