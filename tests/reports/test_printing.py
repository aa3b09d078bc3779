"""Page one alone, and both pages as PDF: one sheet of A4, and a sentence where no browser is."""

import dataclasses
import hashlib
import html
import re

import pytest

from data_schema.outcomes import Outcome
from reports.claims import contrast_claims
from reports.figures.style import TWO_COLUMNS_IN, new_figure
from reports.numbers import Number
from reports.page import printing
from reports.page.printing import NO_BROWSER, browser, print_pdf
from reports.page.study import Study, study_page
from reports.page.writing import report_files, write_report
from reports.results import CoarseCharger, Favoured, Look, Plan
from stats.days.order import PositionsCompared
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


def test_sections_that_page_one_alone_refers_to_are_in_the_full_report(content):
    whole = dataclasses.replace(content, comparisons=tuple(content.pooled[:1]))
    pages = report_files(whole, summary=True)
    alone, full = (pages[name].decode("utf-8") for name in ("summary.html", "report.html"))
    assert "both (Methods, in the full report)" in alone
    assert "both (Methods)" in full


def test_page_one_is_written_only_where_it_is_asked_for(written):
    assert not (written.parent / "summary.html").exists()


def is_one_sheet_of_a4(page, pdf):
    assert print_pdf(page, pdf, one_sheet=True) == ""
    data = pdf.read_bytes()
    assert len(re.findall(rb"/Type\s*/Page\b", data)) == 1
    assert [round(float(width)) for width in re.findall(rb"/MediaBox \[0 0 ([\d.]+)", data)] == [595]


@pytest.fixture(scope="module")
def with_every_warning(content):
    """The longest first page: all that may be said of a campaign's order, charger, looks, charges and contrasts."""
    number = Number(11.234, "%", se=1.41, ci_low=8.12, ci_high=14.31)
    favoured = [
        Favoured(each.group, PositionsCompared(2.0, 6.5, 0.0012), {Outcome.JOULES: number, Outcome.APEX: number})
        for each in content.pooled
        if each.quantity is Outcome.JOULES
    ]
    names = tuple(f"r{place:03d}" for place in range(8))
    warned = dataclasses.replace(
        content,
        favoured=tuple(favoured),
        coarse_charger=CoarseCharger(10.0, 2.2),
        outside_limits=names,
        exchanged_charges=((names[0], names[1]),),
        flow=dataclasses.replace(
            content.flow, jumps_reviewed=1234, jumps_with_the_rest=234, jumps_rejected=567, verdicts_blind=89
        ),
        plan=Plan(stated=True, run_before="2021-06-01", departed=3, look=Look(7, 1, 140, None, 0.05, 0.05, 0.166)),
        contrasts=tuple(dataclasses.replace(each, exploratory="") for each in content.contrasts),
    )
    return dataclasses.replace(warned, claims=(*warned.claims[:2], *contrast_claims(warned)))


def test_page_one_with_every_warning_is_short(with_every_warning):
    page = quick_page(with_every_warning)
    answer = re.sub(r"<svg.*?</svg>", "", page[page.index('<section id="answer"') :], flags=re.DOTALL)
    words = re.sub("<[^>]+>", " ", answer[: answer.index("</section>")]).split()
    assert 500 < len(words) <= 1200


@needs_browser
@pytest.mark.soak
def test_page_one_with_every_warning_is_one_sheet_of_a4(with_every_warning, tmp_path):
    page = write_report(report_files(with_every_warning, summary=True), tmp_path / "warned")
    is_one_sheet_of_a4(page.with_name("summary.html"), tmp_path / "page.pdf")


@needs_browser
def test_what_is_a_little_longer_than_a_sheet_is_set_smaller(tmp_path):
    page = tmp_path / "long.html"
    style = "@page { margin: 10mm } body { margin: 0 }"
    page.write_text(f'<style>{style}</style><div style="height: 290mm">A page.</div>', encoding="utf-8")
    assert print_pdf(page, tmp_path / "two.pdf") == ""
    assert len(re.findall(rb"/Type\s*/Page\b", (tmp_path / "two.pdf").read_bytes())) == 2
    is_one_sheet_of_a4(page, tmp_path / "page.pdf")
    assert {path.name for path in tmp_path.iterdir()} == {"long.html", "two.pdf", "page.pdf"}


@pytest.mark.parametrize(
    ("program", "said"), [(None, NO_BROWSER), ("/bin/false", "did not print")], ids=["no browser", "prints nothing"]
)
def test_where_nothing_is_printed_one_sentence_says_why(tmp_path, monkeypatch, program, said):
    monkeypatch.setattr(printing, "browser", lambda: program)
    page = tmp_path / "page.html"
    page.write_text("A page.", encoding="utf-8")
    says(print_pdf(page, tmp_path / "page.pdf"), said)
    assert not (tmp_path / "page.pdf").exists()


class Slope(Study):
    title = "What came of it"

    def sentences(self):
        return ["The slope is -0.5 (2026-11-02, k-3)."]

    def draw(self):
        return new_figure(TWO_COLUMNS_IN, 3.0)

    def caption(self):
        return "Nothing."

    def table(self):
        return [("run", "offset s"), *((f"r{place:03d}", "-0.1") for place in range(60))]


def test_a_study_s_long_table_and_list_of_files_stand_behind_page_one():
    logs = [(f"log_{place}.csv", hashlib.sha256(bytes([place])).hexdigest()) for place in range(60)]
    text = study_page(Slope(), [("Study", "legs"), ("Runs", "all")], logs, "2026-11-26T16:44:46Z")
    first, behind = text.split('<section class="behind">')
    listed = "".join(f"{sha256}  {name}\n" for name, sha256 in logs)
    assert html.unescape(re.findall(r"<pre>(.*?)</pre>", behind, re.DOTALL)[0]) == listed
    assert f"log_0.csv and 59 more, SHA-256 of their list {hashlib.sha256(listed.encode()).hexdigest()}" in first
    assert "legs; all runs; page of 2026-11-26, 16:44 UTC." in first
    assert "The slope is \u22120.5 (2026-11-02, k-3)." in first
    assert behind.count("\u22120.1") == 60
