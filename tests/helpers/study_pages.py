"""Pages of docs that show a study: its sheet, its command, and what that says; and a study's own page, printed."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import pytest

from reports.page.printing import browser, print_pdf

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


def prints_page_one_on_a_sheet(page: Path) -> None:
    """See that what stands before the list of files and the long table of a study's page is one sheet of A4."""
    if browser() is None:
        pytest.skip("no browser that prints is installed")
    first, pdf = page.with_name("first.html"), page.with_name("first.pdf")
    text = page.read_text(encoding="utf-8")
    first.write_text(re.sub(r'<section class="behind">.*?</section>', "", text, flags=re.DOTALL), encoding="utf-8")
    assert print_pdf(first, pdf) == ""
    assert len(re.findall(rb"/Type\s*/Page\b", pdf.read_bytes())) == 1
