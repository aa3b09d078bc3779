"""Pages of docs that show a study: its sheet, its command, and what that says."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


@dataclass(frozen=True, slots=True)
class StudyPage:
    """The sheet, the command's words after `labbook`, and what the page says that it prints, None where it does not."""

    sheet: str
    words: tuple[str, ...]
    said: str | None


def study_page(name: str) -> StudyPage:
    """Read the example of a page."""
    text = (DOCS / name).read_text(encoding="utf-8")
    (sheet,) = re.findall(r"```csv\n(.*?)```", text, re.DOTALL)
    (words,) = re.findall(r"^ {4}labbook (study .*)$", text, re.MULTILINE)
    said = re.search(r"```text\n(.*?)```", text, re.DOTALL)
    return StudyPage(sheet, tuple(words.split()), said and said[1])
