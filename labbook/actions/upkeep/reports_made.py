"""Reports that were made, as the journal has them: are their files as written, what says labbook.toml now?"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from data_schema.journal import Entry
from labbook.book.report_numbers import NUMBERS, numbers_files, numbers_path
from labbook.config.parsing import Configuration
from labbook.config.settings_of_numbers import settings_of_numbers
from reports.display import list_text
from reports.page.writing import MARK

_MOST_NAMED = 5
_TAKEN_OUT = {False: "nothing", True: "a table"}
"""What now stands instead of a setting, by whether it was nothing: tables of settings come and go as a whole."""


def wrong_numbers(store: Path, reports: Sequence[Entry]) -> tuple[list[str], list[str]]:
    """Return which numbers of reports made in this book were altered in its store, and which are not there."""
    altered, missing = [], []
    for called, sha256 in numbers_files(reports).items():
        path = numbers_path(store, sha256)
        mend = f"from a backup or as the {NUMBERS} beside the report's page"
        if not path.exists():
            missing.append(f"the numbers of report {called} are not in {path}: it can be put there {mend}.")
        elif not _is(path, sha256):
            altered.append(f"{path}, the numbers of report {called}, was altered. Put it back, {mend}, or remove it.")
    return altered, missing


def altered_reports(book_folder: Path, reports: Sequence[Entry]) -> tuple[int, list[str]]:
    """Return how many reports still have their folder, and of those whose files are not as written which and how.

    `reports` are all entries of reports, in the order of the journal. Those of another book were written elsewhere, and
    a folder holds the files of the last report written there.
    """
    standing = {}
    for number, entry in enumerate(reports, start=1):
        new = entry.new or {}
        if entry.origin is None and new.get("folder") is not None:
            standing[book_folder / new["folder"]] = number, new
    found, problems = 0, []
    for folder, (number, new) in standing.items():
        if not folder.is_dir() or _read(folder / MARK) not in (None, b"", new["made_at"].encode()):
            continue
        found += 1
        wrong = {name: _read(folder / name) for name, sha256 in new["files"].items() if not _is(folder / name, sha256)}
        if wrong:
            listed = [f"{name} {'is missing' if data is None else 'was altered'}" for name, data in wrong.items()]
            more = [f"{len(listed) - _MOST_NAMED} more files"] if len(listed) > _MOST_NAMED else []
            problems.append(
                f"report {number}, made {new['made_at']} of {new['where'] or 'all runs'}, is not as it was written: "
                f"{list_text([*listed[:_MOST_NAMED], *more])}. Put its files back, or remove its folder and make the "
                "report again."
            )
    return found, problems


def _read(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except OSError:
        return None


def _is(path: Path, sha256: str) -> bool:
    data = _read(path)
    return data is not None and hashlib.sha256(data).hexdigest() == sha256


def made_with_other_settings(configuration: Configuration, reports: Sequence[Entry]) -> list[str]:
    """Return what labbook.toml says otherwise now than when reports were made, of what their numbers rest on.

    What was added since, as a robot, bears on no earlier number.
    """
    now = settings_of_numbers(configuration)
    by_difference: dict[str, list[int]] = {}
    for number, entry in enumerate(reports, start=1):
        changes = [
            f"{name} {_shown(was)}, labbook.toml says {_shown(now[name]) if name in now else _TAKEN_OUT[was is None]}"
            for name, was in (entry.new or {}).get("settings", {}).items()
            if name not in now or was != now[name]
        ]
        more = [f"{len(changes) - _MOST_NAMED} more"] if len(changes) > _MOST_NAMED else []
        if changes:
            by_difference.setdefault("; ".join([*changes[:_MOST_NAMED], *more]), []).append(number)
    return [
        f"numbers of report{'s' if numbers[1:] else ''} {list_text([str(number) for number in numbers])} were computed "
        f"with {difference}."
        for difference, numbers in by_difference.items()
    ]


def _shown(value: Any) -> str:
    return "nothing" if value is None else json.dumps(value, ensure_ascii=False)
