import dataclasses
import re
from html.parser import HTMLParser

import pytest

from data_schema.errors import UsageError
from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.figures.by_level import file_name
from reports.figures.registry import FIGURES, figures_of
from reports.numbers import Number
from reports.page.sections import FigureHere, FiguresBeside, sections_of
from reports.page.writing import inline_svg, report_files, write_report
from reports.results import Claim, Provenance
from reports.tables.each_run import name_points, run_anchors
from reports.tables.registry import TABLES
from tests.helpers.pages import FIGURE_NAMES, TABLE_NAMES, quick_page
from tests.helpers.wording import refuses, says
from tests.reports.made import changed

VOID = {"meta", "br", "hr", "img", "link", "input"}


class Checker(HTMLParser):
    """Every element is closed in its order; ids and targets are collected."""

    def __init__(self, html):
        super().__init__()
        self.open, self.ids, self.targets, self.text, self.faults = [], [], [], [], []
        self.feed(html)
        self.close()
        self.faults += [f"<{tag}> is never closed" for tag in self.open]

    def handle_starttag(self, tag, attrs):
        self._attributes(attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self._attributes(attrs)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.faults.append(f"</{tag}> at {self.getpos()} closes something else")

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("style", "script", "title", "desc"):
            self.text.append(data)

    def _attributes(self, attrs):
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
            if name in ("href", "xlink:href", "src"):
                self.targets.append(value)


def text_of(html):
    return re.sub(r"\s+", " ", "".join(Checker(html).text).replace("\u00a0", " "))


@pytest.fixture(scope="module")
def html(written):
    return written.read_text(encoding="utf-8")


def test_the_page_is_well_formed_and_whole(html):
    page = Checker(html)
    assert page.faults == []
    assert len(page.ids) == len(set(page.ids))
    assert {target[0] for target in page.targets} == {"#"}
    assert {target[1:] for target in page.targets} <= set(page.ids)


def test_the_page_asks_nothing_of_the_network(html):
    assert not re.search(r"https?:", html)
    assert "@import" not in html
    assert set(re.findall(r"url\((.)", html)) <= {"#"}
    assert html.count("<script") == 1
    assert not re.search(r"fetch|XMLHttpRequest|import\(|src=", html)


def test_every_number_and_id_of_the_tables_is_on_the_page(content, html):
    text = text_of(html)
    for name in ("headlines", "joules_by_condition", "apex_by_condition", "comparisons_joules", "tests_apex", "anovas"):
        table = TABLES[name].make(content)
        for row in table.rows:
            for cell in table.cells(row)[1:]:
                assert cell.text.replace("\u00a0", " ") in text


def test_the_page_traces_the_numbers_it_shows_and_the_file_all(content, written, html):
    page = Checker(html)
    linked = {target.removeprefix("#why-") for target in page.targets if target.startswith("#why-")}
    listed = {identity.removeprefix("why-") for identity in page.ids if identity.startswith("why-")}
    assert linked == listed
    assert content.claims[0].provenance[0] in listed
    assert {condition.summaries[Outcome.JOULES].mean.provenance for condition in content.conditions} <= listed
    lines = (written.parent / "tables" / "provenance.csv").read_text().splitlines()[1:]
    assert {line.split(",")[0] for line in lines} == {source.id for source in content.provenance} > listed


def test_the_headline_opens_the_page(content, html):
    text = text_of(html)
    claim = content.claims[0].text.replace("\u00a0", " ")
    assert text.index("Answer") < text.index(claim) < text.index("Table 1.") < text.index("Figure 1.")
    for other in content.claims:
        assert other.text.replace("\u00a0", " ") in text


def test_the_facts_of_the_report(html):
    text = text_of(html)
    for fact in (
        "granular bed", "k_gain in (300, 400)", "2021-05-03", "2021-05-21", "253", "255",
        "Ada Nwosu (AN) and Li Wei (LW)", "2021-07-30 14:05", "labbook 0.1.0, labbook.toml 9c41f2e07ab3", "robust",
        "outside the 20 to 60 min", "foot and day are confounded", "The bed was stirred by hand.",
        "uncertainty of the reference voltage", "k = 2.56 g + 67.36 N/m",
    ):  # fmt: skip
        assert fact in text


def test_figures_are_described_and_tables_headed(html):
    assert html.count("<figure") == len(FIGURE_NAMES)
    assert len(re.findall('role="(img|group)" aria-labelledby="', html)) == len(FIGURE_NAMES)
    assert html.count("<table") == html.count("<caption") >= 12
    assert html.count("<h1") == 1
    assert '<html lang="en">' in html


def test_a_person_s_text_is_only_text(content):
    nasty = '<script>alert("x")</script> & <img src=//a>'
    changed = dataclasses.replace(
        content,
        title=nasty,
        selection=nasty,
        people=(nasty,),
        claims=(Claim(nasty, (nasty,)),),
        limitations=(nasty,),
        days=(dataclasses.replace(content.days[0], conditions=(nasty,)),),
        provenance=(Provenance(nasty, nasty, 1),),
    )
    html = quick_page(changed)
    assert html.count("<script") == 1  # our own
    assert "<img" not in html
    page = Checker(html)
    assert page.faults == []
    assert nasty in "".join(page.text)


def test_each_robot_has_its_drain(content):
    numbers = dataclasses.replace(content.drains[0].result, run_duration_s=1800.0)
    second = dataclasses.replace(content.drains[0], robot="leg_rig 2", result=numbers)
    drains = (dataclasses.replace(content.drains[0], robot="Minitaur"), second)
    changed = dataclasses.replace(content, drains=drains)
    text = text_of(quick_page(changed))
    says(text, "Minitaur", "at 12 min", "leg_rig 2", "at 30 min")
    for name in ("passive_drain", "idle_runs"):
        assert [block for block, _ in TABLES[name].make(changed).blocks] == ["Minitaur", "leg_rig 2"]
        alone = dataclasses.replace(content, drains=drains[:1])
        assert [block for block, _ in TABLES[name].make(alone).blocks] == [""]


def test_what_does_not_exist_is_said(content):
    none = Number(Undefined(Reason.AS_SAID, said="the control is zero"), "%")
    text = text_of(quick_page(changed(content, lambda c: c.decision.savings is not None, savings=none)))
    says(text, "control is zero")


def test_every_figure_of_the_registry_has_a_place_on_the_page(content):
    parts = [part for section in sections_of(content) for part in section.parts]
    placed = {part.name for part in parts if isinstance(part, FigureHere)}
    placed |= {name for part in parts if isinstance(part, FiguresBeside) for name in part.names}
    without = sorted({kind.name for kind in figures_of(content)} - placed)
    assert without == []  # give them a section, or a FigureHere in reports/page/sections.py


def test_a_selection_with_little_in_it_says_why(minimal):
    html = quick_page(minimal)
    assert Checker(html).faults == []
    text = text_of(html)
    for name in ("savings", "passive_drain"):
        assert FIGURES[name].absent(minimal) in text
    no_control = tuple(dataclasses.replace(factor, swept=False) for factor in minimal.factors)
    says(text_of(quick_page(dataclasses.replace(minimal, claims=(), factors=no_control))), "`control = ...`")


def test_all_files_are_there_and_no_part_is_left_over(written, content):
    folder = written.parent
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    ends = [f"{width}.{kind}" for width in ("", "_one_column") for kind in ("svg", "pdf")]
    figures = {f"figures/{file_name(name, content)}{end}" for name in FIGURE_NAMES for end in ends}
    tables = {f"tables/{name}.{kind}" for name in TABLE_NAMES for kind in ("csv", "tex")}
    assert found == figures | tables | {".labbook-report", "report.html", "numbers.tex", "references.bib"}


def test_without_all_figures_only_those_of_the_page_are_there_and_none_of_before(content, tmp_path):
    write_report(report_files(content), tmp_path)
    for name in ("savings.pdf", "savings_one_column.svg", "mine.pdf"):
        (tmp_path / "figures" / name).write_text("of another day")
    written = write_report(report_files(content), tmp_path)
    ends = {name: "_one_column" if name in ("joules_by_level", "apex_by_level") else "" for name in FIGURE_NAMES}
    found = {path.name for path in (tmp_path / "figures").iterdir()}
    assert found == {f"{file_name(name, content)}{end}.svg" for name, end in ends.items()} | {"mine.pdf"}
    assert "--figures" in written.read_text(encoding="utf-8")


def test_the_inlined_drawing_is_the_file_s(content, written, html):
    for name in FIGURE_NAMES:
        kind = FIGURES[name]
        width = "_one_column" if name in ("joules_by_level", "apex_by_level") else ""
        svg = (written.parent / "figures" / f"{file_name(name, content)}{width}.svg").read_bytes()
        drawn = inline_svg(svg, name, kind.title, kind.alternative(content))
        assert name_points(drawn, name, content, run_anchors(content)) in html


def test_a_folder_that_cannot_be_written_is_one_sentence(minimal, tmp_path):
    blocked = tmp_path / "report"
    blocked.write_text("a file is here")
    with refuses(UsageError, "cannot be written", "--out"):
        write_report(report_files(minimal), blocked)
    assert blocked.read_text() == "a file is here"


def test_a_report_that_ended_as_its_folder_was_made_is_written_again(minimal, tmp_path):
    hindrance = tmp_path / "tables"
    hindrance.symlink_to("nowhere")
    with refuses(UsageError, "cannot be written"):
        write_report(report_files(minimal), tmp_path)
    hindrance.unlink()
    assert write_report(report_files(minimal), tmp_path).exists()


def test_where_one_file_cannot_be_written_an_earlier_report_stays_whole(minimal, tmp_path):
    """As on a full disk: its page would stand beside tables with other numbers."""
    write_report(report_files(minimal), tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    files = {name: data + b" " for name, data in report_files(minimal).items()}
    with refuses(UsageError, "cannot be written"):
        write_report({**files, f"{'long' * 100}.html": b""}, tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
