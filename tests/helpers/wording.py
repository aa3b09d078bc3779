"""What the product says: a test names the facts of a sentence, and `tests/wording.json` has its words on record."""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TypeVar

import pytest

E = TypeVar("E", bound=BaseException)
ROOT = Path(__file__).parents[2]
RECORD = ROOT / "tests" / "wording.json"
WRITE = os.environ.get("LABBOOK_WORDING") == "write"  # the record is made anew, by one process
MASKS = (
    (re.compile(r"(?<=database )(labbook\.db|postgresql[+\w]*://[^\s:]+)"), "URL"),
    (re.compile(r"(/[\w.-]+)*/(pytest-of-\w+/pytest-\d+(/popen-gw\d+)?/[\w.-]+|labbook-[a-z]+-\w{8}\b)"), "TMP"),
    (re.compile(r"20(2[6-9]|[3-9]\d)-\d\d-\d\d([T ]\d\d:\d\d(:\d\d(\.\d+)?)?Z?)?|20\d{6}[Tt]\d{6,12}[Zz]"), "DATE"),
    (re.compile(r"(?<![.\w])([0-9a-f]{7}(?! %)|[0-9a-f]{12}|[0-9a-f]{16,64})(?![\w+]|\.\d)"), "HEX"),
)
LONG = 400
_record: dict[str, list[str]] = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
_said: Counter[str] = Counter()


def says(text: object, *facts: object) -> str:
    """Return the first line of `text`, or of a list of lines, that has all `facts`; its words must be those on record.

    Of a line beyond 400 characters it is a sentence, and where no line has all facts, the whole text. A space that does
    not break counts as a space; paths of the test run, dates of today and hashes are on record by their kind alone.
    """
    __tracebackhide__ = True
    whole = ("\n".join(map(str, text)) if isinstance(text, list | tuple) else str(text)).replace("\u00a0", " ")
    found = next((piece for piece in _pieces(whole) if all(str(fact) in piece for fact in facts)), None)
    if found is None:
        pytest.fail(f"nothing says all of {facts}:\n{whole}")
    key = _key(os.environ["PYTEST_CURRENT_TEST"].rpartition(" (")[0])
    place, masked = _said[key], found
    for pattern, kind in MASKS:
        masked = pattern.sub(kind, masked)
    _said[key] += 1
    if WRITE:
        _record[key] = [*_record.get(key, [])[:place], masked]
    recorded = _record.get(key, [])[place : place + 1]
    if recorded != [masked]:
        pytest.fail(
            f"{RECORD.name} has of {key}, sentence {place + 1},\n{recorded}\nand it is now\n{[masked]}\n"
            "where it is as it should be: LABBOOK_WORDING=write pytest -p no:xdist FILE"
        )
    return found


def refuses(error: type[E], *facts: object) -> pytest.RaisesExc[E]:
    """Expect an exception that says all `facts`, in the words on record."""
    return pytest.raises(error, check=lambda refused: bool(says(refused, *facts)))


def begin(nodeid: str) -> None:
    """Take the next sentence of a test for its first."""
    _said[_key(nodeid)] = 0


def finish(nodeid: str) -> None:
    """See that a test that passed said all that is on record of it."""
    key = _key(nodeid)
    recorded = _record.get(key, [])
    if len(recorded) > _said[key] and not WRITE:
        pytest.fail(f"{RECORD.name} has {len(recorded)} sentences of {key}, and it said {_said[key]}")
    if WRITE and recorded:
        del recorded[_said[key] :]
        kept = {key: sentences for key, sentences in sorted(_record.items()) if sentences}
        RECORD.write_text(json.dumps(kept, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


def forget(nodeids: Iterable[str]) -> None:
    """See that nothing is on record of tests that are no more, in the files whose tests all have been collected."""
    keys = set(map(_key, nodeids))
    files = set(map(_file, keys))
    gone = [key for key in _record if key not in keys and (_file(key) in files or not (ROOT / _file(key)).exists())]
    if gone and not WRITE:
        raise pytest.UsageError(f"{RECORD.name} has sentences of tests that are no more: {', '.join(gone)}")
    for key in gone:
        del _record[key]


def _key(nodeid: str) -> str:
    """The same name for both databases."""
    return re.sub(r"(?<=[\[-])(sqlite|postgresql)-?", "", nodeid).replace("-]", "]").replace("[]", "")


def _file(key: str) -> str:
    return key.partition("::")[0]


def _pieces(whole: str) -> Iterator[str]:
    """Yield what may be on record: lines, sentences of long ones, the whole text where it is not too long."""
    for line in whole.splitlines():
        yield from map(str.strip, re.split(r"(?<=\. )|(?<=>)(?=[^<])|(?=<)", line) if len(line) > LONG else [line])
    if len(whole) <= 5 * LONG:
        yield whole.strip()
