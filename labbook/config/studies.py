"""`[studies.NAME]` in `labbook.toml`: what `labbook study NAME` is asked with where the command line does not say it.

[studies.compaction]
grain_mm = 3.4

[studies.emulator]
where = "foot=small"
same_percent = 2
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from data_schema.errors import unknown_name
from labbook.config.model import StudyProtocol
from labbook.config.tables import TableReader

SHEET_KEYS, BOOK_KEYS = ("sheet", "decimal", "level"), ("where", "level")
STUDY_KEYS: Mapping[str, tuple[str, ...]] = {
    "force-plate": ("window", *BOOK_KEYS),
    "characterisation": SHEET_KEYS,
    "emulator": ("constant", "ratio", "same_percent", *BOOK_KEYS),
    "bed": BOOK_KEYS,
    "compaction": ("grain_mm", *SHEET_KEYS),
    "field": SHEET_KEYS,
}
"""The keys of each study (thesis 3.2.2, 4.2.6, 4.3, 5.2, 5.1.2, 2.2.3)."""


def read_studies(top: TableReader) -> dict[str, StudyProtocol]:
    """Read every `[studies.NAME]`."""
    studies = top.table("studies")
    found = {}
    for name in studies.names():
        if name in STUDY_KEYS:
            found[name] = _protocol(studies.table(name, required=True), STUDY_KEYS[name])
        else:
            studies.fault(name, str(unknown_name("study", name, STUDY_KEYS)))
    return found


def _protocol(table: TableReader, keys: tuple[str, ...]) -> StudyProtocol:
    values: dict[str, Any] = {key: _READERS[key](table, key) for key in keys}
    for key, most in (("level", 1.0), ("same_percent", 100.0)):
        if (number := values.get(key)) is not None and number >= most:
            table.fault(
                key,
                f"{number:g} is too much: write a number between 0 and {most:g}, such as {0.95 if most == 1.0 else 2}.",
            )
    table.finish()
    return StudyProtocol(**values)


def _above_0(table: TableReader, key: str) -> float | None:
    return table.optional_number(key, above=0.0)


_READERS: Mapping[str, Callable[[TableReader, str], Any]] = {
    **dict.fromkeys(("sheet", "where", "decimal"), TableReader.optional_text),
    **dict.fromkeys(("grain_mm", "ratio", "same_percent", "level"), _above_0),
    "constant": TableReader.optional_number,
    "window": lambda table, key: table.whole(key, 0, least=1) or None,
}
