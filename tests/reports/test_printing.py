"""Page one alone, and both pages as PDF: one sheet of A4, and a sentence where no browser is."""

import re

import pytest

from reports.page import printing
from reports.page.printing import NO_BROWSER, browser, print_pdf
from reports.page.writing import report_files, write_report
from tests.helpers.pages import quick_page
from tests.helpers.wording import says

needs_browser = pytest.mark.skipif(browser() is None, reason="Chromium is not installed: nothing is printed")


@pytest.fixture(scope="module")
def summarised(content, tmp_path_factory):
    return write_report(report_files(content, summary=True), tmp_path_factory.mktemp("summarised"))


def test_page_one_alone_has_the_answer_and_links_to_nothing_else(content, summarised):
    html = summarised.with_name("summary.html").read_text(encoding="utf-8")
    assert re.findall(r'<section id="([^"]*)"', html) == ["answer"]
    assert html.count("<figure") == 2
    assert html.count("<table") == 1
    assert "href=" not in re.sub(r"<svg.*?</svg>", "", html, flags=re.DOTALL)
    assert content.claims[0].provenance[0] in html
    assert summarised.exists()


def test_page_one_is_written_only_where_it_is_asked_for(written):
    assert not (written.parent / "summary.html").exists()


@needs_browser
def test_page_one_is_one_sheet_of_a4(summarised, tmp_path):
    assert print_pdf(summarised.with_name("summary.html"), tmp_path / "page.pdf", one_sheet=True) == ""
    assert [path.name for path in tmp_path.iterdir()] == ["page.pdf"]
    data = (tmp_path / "page.pdf").read_bytes()
    assert len(re.findall(rb"/Type\s*/Page\b", data)) == 1
    assert [round(float(width)) for width in re.findall(rb"/MediaBox \[0 0 ([\d.]+)", data)] == [595]


def test_where_no_browser_is_one_sentence_says_so(content, tmp_path, monkeypatch):
    monkeypatch.setattr(printing, "browser", lambda: None)
    page = tmp_path / "page.html"
    page.write_text(quick_page(content), encoding="utf-8")
    assert print_pdf(page, tmp_path / "page.pdf") == NO_BROWSER
    assert not (tmp_path / "page.pdf").exists()


def test_a_browser_that_prints_nothing_is_told_of(content, tmp_path, monkeypatch):
    monkeypatch.setattr(printing, "browser", lambda: "/bin/false")
    page = tmp_path / "page.html"
    page.write_text(quick_page(content), encoding="utf-8")
    says(print_pdf(page, tmp_path / "page.pdf"), "did not print", "1")
