"""A lab's own page and Word tables: what its folder has is used, what is wrong with it is refused, nothing is lost."""

from __future__ import annotations

import io
import re
import subprocess
import sys
from pathlib import Path

import docx
import pytest

from tests.cli.shell import good, labbook, refused
from tests.helpers.books import SmallBook, small_book

PAGE = (Path(__file__).parents[3] / "docs" / "own-page.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    return small_book(tmp_path_factory.mktemp("own-page"))


def test_what_the_page_says_works(small: SmallBook, tmp_path: Path) -> None:
    first, second = re.findall(r"^    ((?:mkdir|cp) .+)$", PAGE, re.MULTILINE)
    for command in (first, second.replace("python", sys.executable)):
        subprocess.run(["bash", "-c", command], cwd=tmp_path, check=True)
    style = tmp_path / "lab-page" / "report.css"
    style.write_text(style.read_text() + "\nh1 { color: teal; }\n")
    good(labbook("report", "--unsaved", "--out", tmp_path / "r", "--template", style.parent, at=small.folder))
    assert "h1 { color: teal; }" in (tmp_path / "r" / "report.html").read_text(encoding="utf-8")


def test_a_page_gets_what_is_listed(small: SmallBook, tmp_path: Path) -> None:
    names = re.findall(r"^\| `(\w+)` \|", PAGE, re.MULTILINE)
    (tmp_path / "report.html.j2").write_text("".join(f"<p>{name}: {{{{ {name} }}}}</p>" for name in names))
    good(labbook("report", "--unsaved", "--out", tmp_path / "r", "--template", tmp_path, at=small.folder))
    page = (tmp_path / "r" / "report.html").read_text(encoding="utf-8")
    assert all(f"<p>{name}: " in page for name in names)
    assert "<script" not in page


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "report.css"),
        ("\n{% for x %}", "line 2"),
        ("\n\n{{ contents.title }}", "line 3"),
        ("\udcff", "j2"),
        ("{% include '/etc/passwd' %}", "passwd"),
        ("{% include '../../content.py' %}", "content.py"),
        ("{{ ''.__class__.__mro__ }}", "__class__"),
    ],
)
def test_a_template_that_cannot_be_used_is_refused(
    small: SmallBook, tmp_path: Path, text: str | None, said: str
) -> None:
    (tmp_path / "mine").mkdir()
    if text is not None:
        (tmp_path / "mine" / "report.html.j2").write_text(text, errors="surrogateescape")
    journal = small.folder / "journal.jsonl"
    before = sorted(small.folder.rglob("reports/*")), journal.read_bytes()
    refused(labbook("report", "--template", tmp_path / "mine", at=small.folder), 2, said)
    assert (sorted(small.folder.rglob("reports/*")), journal.read_bytes()) == before


def test_word_has_the_tables_of_the_page(small: SmallBook, tmp_path: Path) -> None:
    good(labbook("report", "--unsaved", "--out", tmp_path / "r", "--docx", at=small.folder))
    document = docx.Document(io.BytesIO((tmp_path / "r" / "tables.docx").read_bytes()))
    captions = [one.text for one in document.paragraphs if one.style.name == "Caption"]
    assert len(captions) == len(document.tables) > 5
    page = re.sub(r"<[^>]+>", " ", (tmp_path / "r" / "report.html").read_text(encoding="utf-8"))
    heads = [cell.text for cell in document.tables[0].rows[0].cells]
    assert all(head.split(" (")[0] in page for head in heads)
    good(labbook("report", "--unsaved", "--out", tmp_path / "r", at=small.folder))
    assert not (tmp_path / "r" / "tables.docx").exists()
