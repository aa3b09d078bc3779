"""Reports of too little: a page with sentences that say what is missing, never a crash, never a number from nothing."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pytest

from reports.figures.kind import draw_figure, svg_bytes
from reports.figures.registry import FIGURES
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN
from reports.page.writing import render_page
from reports.results import WITHOUT_EXCLUSIONS, StudyResults
from reports.tables.formats import csv_bytes, latex_bytes
from reports.tables.registry import TABLES
from reports.trust import flow_sentence
from tests.cli.shell import good, labbook, refused, rows
from tests.helpers.books import SmallBook, small_book
from tests.helpers.pages import content_of, quick_page

NO_LOG = "12 runs (r001, r002, r003, r004, r005, r006, r009, r010, ...) have no apex heights: no log"
BOTH = ("logs", "charger")
CASES: dict[str, tuple[str, str | None, str | None, tuple[str, ...]]] = {
    "no run fulfils it": ("No run matches this selection.", "day<2000-01-01", None, BOTH),
    "one condition": ("no joules of both a control and a treatment", "foot=small and b_ad_gain=0", None, BOTH),
    "no control": ("no joules of both a control and a treatment to compare", "b_ad_gain=100", None, BOTH),
    "one run a condition": ("no day has two runs of", "run in (r001, r002, r003, r005)", None, BOTH),
    "no file at all": (NO_LOG, None, None, ()),
    "no charges": ("r006, r009, r010, ...) have no joules: no charge recorded", None, None, ("logs",)),
    "no logs": (NO_LOG, None, None, ("charger",)),
    "no idle runs": ("the drain line needs at least 3 idle runs and there are 0", None, "idle", ("charger",)),
}
"""A sentence of each page, what is selected, the kind of runs left out, the instruments' files."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    return small_book(tmp_path_factory.mktemp("selected"))


def book_with(folder: Path, left_out: str | None, files: tuple[str, ...]) -> SmallBook:
    """A small book without the runs of one kind, and with only some of the instruments' files."""
    book = small_book(folder, runs=False, ingested=False)
    sheet = book.instruments / "runs.csv"
    lines = sheet.read_text().splitlines(keepends=True)
    sheet.write_text("".join(line for line in lines if left_out is None or f",{left_out}," not in line))
    good(labbook("runs", "import", sheet, at=book.folder))
    if files:
        good(labbook("ingest", *(book.instruments / name for name in files), at=book.folder))
    return book


def page_of(content: StudyResults, width_in: float) -> str:
    drawings = {}
    for name, kind in FIGURES.items():
        drawings[name] = drawings[f"{name}_one_column"] = svg_bytes(draw_figure(kind, content, width_in))
    tables = {kind.name: kind.make(content) for kind in TABLES.values()}
    for table in tables.values():
        latex_bytes(table)
        cells = [cell for row in csv.reader(csv_bytes(table).decode().splitlines()) for cell in row]
        assert not {cell.lower() for cell in cells} & {"nan", "inf", "-inf", "none"}
    return render_page(content, drawings, tables)


LIKE_ANOTHER = ("one condition", "no control", "no logs", "no charges", "no idle runs")
"""Cases in a soak alone."""


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.soak) if case in LIKE_ANOTHER else case for case in CASES]
)
def test_report_of_too_little_is_a_page_with_sentences(case: str, whole: SmallBook, tmp_path: Path) -> None:
    said, where, left_out, files = CASES[case]
    book = whole if where is not None else book_with(tmp_path, left_out, files)
    content = content_of(book.folder, where)
    page = page_of(content, ONE_COLUMN_IN if len(case) % 2 else TWO_COLUMNS_IN)
    text = re.sub(r"<style.*?</style>|<svg.*?</svg>", "", page, flags=re.DOTALL)
    text = re.sub(r"<[^>]+>", " ", text)
    assert not re.search(r"\b(nan|NaN|None|inf|Undefined)\b", text)
    assert ("Nothing is claimed from this selection:" in text) == (not content.claims)
    assert all(claim.text.endswith(".") for claim in content.claims)
    assert said in text
    assert not re.search(r"\bgroup [ab]\b", text), "a comparison's sides are called what the reader calls them"


def test_void_runs_are_counted_and_left_out(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    for (name,) in rows(book.folder, "SELECT name FROM run WHERE kind = 'jumps'"):
        good(labbook("void", name, "--reason", "the rail was bent", at=book.folder))
    content = content_of(book.folder)
    assert set(content.flow.runs_with.values()) == {0}
    assert "12" in quick_page(content)


def test_flow_says_where_an_exclusion_changed_the_test(tmp_path: Path) -> None:
    """Controls of one day and treated runs of the other are void: no day has both sides of the small foot any more."""
    book = small_book(tmp_path)
    assert "within days" not in flow_sentence(content_of(book.folder))
    for name in ("r001", "r006", "r010", "r012"):
        good(labbook("void", name, "--reason", "the rail was bent", at=book.folder))
    content = content_of(book.folder)
    changed = {
        each.group["foot"]
        for each, varied in content.headlines
        for one in varied
        if one.variant == WITHOUT_EXCLUSIONS and one.result.rule is not each.decision.rule
    }
    assert changed == {"small"}
    assert flow_sentence(content).count("within days") == 2


def test_report_of_an_empty_book_is_written_by_the_command(fresh: SmallBook) -> None:
    said = good(labbook("report", "--out", "paper", "--json", at=fresh.folder)).json
    page = (fresh.folder / "paper" / "report.html").read_text(encoding="utf-8")
    assert page.rstrip().endswith("</html>")
    assert said["claims"] == []
    assert "Nothing is claimed" in page
    assert rows(fresh.folder, "SELECT count(*) FROM report") == [(1,)]


def test_an_option_that_could_mean_a_factor_is_refused(fresh: SmallBook) -> None:
    """A study whose factor is called as an option of report: the level went into the name of a folder, unseen."""
    text = fresh.toml.read_text(encoding="utf-8")
    factors = "".join(f'[factors.{name}]\nkind = "label"\nlevels = ["far", "near"]\n' for name in ("out", "unsaved"))
    fresh.toml.write_text(f"{text}\n{factors}", encoding="utf-8")
    refused(labbook("report", "--out", "near", at=fresh.folder), 2, '--where "out=near"')
    refused(labbook("report", "--unsaved", "near", at=fresh.folder), 2, '--where "unsaved=far"')
    assert not (fresh.folder / "near").exists()
    good(labbook("report", "--out", "../near", at=fresh.folder))


def test_a_report_is_written_where_it_cannot_be_printed(fresh: SmallBook, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(fresh.folder))
    done = good(labbook("report", "--summary", "--pdf", "--out", "paper", at=fresh.folder))
    assert "look again: no PDF was made" in done.out
    assert {path.name for path in (fresh.folder / "paper").iterdir()} >= {"report.html", "summary.html"}


def test_nothing_of_an_earlier_report_stays_beside_the_page(fresh: SmallBook) -> None:
    paper = fresh.folder / "paper"
    good(labbook("report", "--summary", "--figures", "--out", "paper", at=fresh.folder))
    assert (paper / "figures" / "joules_by_b_ad_gain.pdf").read_bytes().startswith(b"%PDF")
    (paper / "summary.pdf").write_bytes(b"%PDF of the earlier report")
    (paper / "figures" / "joules_by_earlier_factor.svg").write_text("of the earlier report", encoding="utf-8")
    (paper / "notes.txt").write_text("mine", encoding="utf-8")
    (paper / "report.html").unlink()  # as where the report was killed before its page
    good(labbook("report", "--out", "paper", at=fresh.folder))
    left = {path.name for path in paper.iterdir() if path.is_file()}
    assert left == {".labbook-report", "report.html", "numbers.json", "numbers.tex", "references.bib", "notes.txt"}
    assert not [path for path in (paper / "figures").iterdir() if path.suffix == ".pdf" or "earlier" in path.name]


@pytest.mark.parametrize("name", ["figures/savings.pdf", "report.html"])
def test_files_of_a_paper_are_not_replaced(fresh: SmallBook, name: str) -> None:
    own = fresh.folder / "paper" / name
    own.parent.mkdir(parents=True)
    own.write_text("mine", encoding="utf-8")
    refused(labbook("report", "--out", "paper", at=fresh.folder), 2, name.partition("/")[0], "paper/report")
    assert own.read_text(encoding="utf-8") == "mine"
    assert [path.name for path in own.parent.iterdir()] == [own.name]
    good(labbook("report", "--out", "paper/report", at=fresh.folder))


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("b_ad_gain=50", ("'50' is not a known level of b_ad_gain (character 11", "nearest is 0 or 100")),
        ("foot=small and k_gain in (400, 900)", ("'900'", "nearest is 400")),
        ("day=2021-06-15", ("no run fulfils", "the nearest is day=2021-06-14 or 2021-06-16")),
        ("run=r300", ("no run fulfils", "the nearest is run=r")),
        ("duration_s>5000", ("no run fulfils", "the nearest is duration_s=3600")),
        ("foot=small and kind=idle", ("some run fulfils each part of it, and none all",)),
    ],
)
def test_a_selection_of_no_run_is_refused_with_what_is_nearest(
    where: str, said: tuple[str, ...], whole: SmallBook, tmp_path: Path
) -> None:
    refused(labbook("report", "--where", where, "--out", tmp_path / "page", at=whole.folder), 2, *said)
    assert not (tmp_path / "page").exists()


@pytest.mark.parametrize(
    "command", ["stats compare", "stats anova", "study bed", "study emulator", "study force-plate"]
)
def test_what_takes_where_refuses_a_selection_of_no_run(command: str, whole: SmallBook) -> None:
    refused(labbook(*command.split(), "--where", "b_ad_gain=50", at=whole.folder), 2, "nearest is 0 or 100")
    refused(labbook(*command.split(), "--where", "day<2000-01-01", at=whole.folder), 2, "no run fulfils")


def test_a_list_of_runs_may_be_empty_but_asks_for_levels_that_there_are(whole: SmallBook) -> None:
    assert good(labbook("runs", "list", "--where", "state=void", at=whole.folder)).out == "no runs.\n"
    refused(labbook("runs", "list", "--where", "b_ad_gain=50", at=whole.folder), 2, "nearest is 0 or 100")
