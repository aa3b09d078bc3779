"""The how-to pages of docs: every command on them works, on books as the pages describe them."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from pathlib import Path

import pytest
from PIL import Image

from data_schema.outcomes import Outcome
from labbook.actions.report_command import state_report
from labbook.actions.runs.attention import CHECKS, Gravity
from labbook.config.parsing import parse_configuration
from labbook.config.studies import STUDIES
from labbook.demo.files import book_toml
from labbook.demo.truth import CHAPTER_5
from tests.cli.shell import Answer, good, labbook, rows
from tests.helpers.books import SmallBook, reported_book, small_book
from tests.helpers.kernels import python

DOCS = Path(__file__).parents[2] / "docs"


def commands(page: str) -> list[list[str]]:
    """The indented commands of a page, in order."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return [shlex.split(line)[1:] for line in re.findall(r"^ {4}(labbook .*)$", text, re.MULTILINE)]


def works(words: list[str], at: Path) -> Answer:
    return good(labbook(*words, at=at))


@pytest.fixture
def book(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SmallBook:
    monkeypatch.setenv("LABBOOK_AS", "Ada Nwosu")
    return small_book(tmp_path / "book")


def test_a_book_is_backed_up_and_brought_back(book: SmallBook) -> None:
    back_up, today, check, restore, prune = commands("back-up.md")
    (book.folder.parent / "stick").mkdir()
    works(back_up, book.folder)
    assert str(book.folder.parent / "stick" / "mybook") in works(today, book.folder).out
    works(check, book.folder)
    works(restore, book.folder)
    again = book.folder.parent / "again"
    query = "SELECT uid, charge_mah FROM charge ORDER BY uid"
    assert rows(again, query) == rows(book.folder, query)
    works(prune, book.folder)


def test_a_day_at_the_rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LABBOOK_AS", "Ada Nwosu")
    book = small_book(tmp_path / "book", ingested=False)
    for words in commands("day-at-the-rig.md"):
        works(words, book.folder)
    page = (DOCS / "day-at-the-rig.md").read_text(encoding="utf-8")
    assert [code for code in CHECKS if f"`{code}`" not in page] == []
    assert [gravity for gravity in Gravity if f"`{gravity}`" not in page] == []


def test_folders_are_watched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LABBOOK_AS", "Ada Nwosu")
    stated = small_book(tmp_path / "book", ingested=False)
    watch, today, for_programs = commands("watch.md")
    works(watch, stated.folder)
    works(today, stated.folder)
    assert rows(stated.folder, "SELECT count(*) FROM file") == [(14,)]
    assert {json.loads(line)["event"] for line in works(for_programs, stated.folder).out.splitlines()} == {
        "watching",
        "known",
        "ended",
    }


def test_two_laptops(book: SmallBook) -> None:
    laptop = book.folder.parent / "laptop"
    shutil.copytree(book.folder, laptop)
    works(["note", "r001", "squeaked on the laptop"], laptop)
    works(["note", "r002", "squeaked at home"], book.folder)
    dry_run, merge = commands("two-laptops.md")
    told = works([*dry_run, "--json"], book.folder).json
    assert (told["entries"], told["raw_copies"]) == ({"note": 1}, 0)
    works(merge, book.folder)
    notes = {text for (text,) in rows(book.folder, "SELECT text FROM note")}
    assert notes >= {"squeaked on the laptop", "squeaked at home"}


def test_a_shared_book(tmp_path: Path, postgres_url: str) -> None:
    init, _move = commands("shared-book.md")
    there = {"postgresql+psycopg://lab@server/mybook": postgres_url, "/srv/lab/mybook-store": str(tmp_path / "drive")}
    at_server = [there.get(word, word) for word in init]
    works(at_server, tmp_path)
    assert works(["db", "status"], tmp_path / "mybook").out.startswith("postgresql")
    assert (tmp_path / "drive" / "journal.jsonl").is_file()
    other = labbook(*at_server[:-1], str(tmp_path / "elsewhere"), at=tmp_path)
    assert other.code != 0
    assert "[store] path" in other.err


@pytest.mark.soak
def test_a_book_moves_to_a_server(tmp_path: Path, book: SmallBook, postgres_url: str) -> None:
    _init, move = commands("shared-book.md")
    works([word.replace("postgresql+psycopg://lab@server/mybook", postgres_url) for word in move], book.folder)
    assert works(["db", "status"], book.folder).out.startswith("postgresql")


@pytest.mark.soak
def test_a_reviewer_looks_and_recomputes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LABBOOK_AS", "Ada Nwosu")
    book = reported_book(tmp_path / "book")
    number = works(["reports", "show", "last", "--json"], book.folder).json["numbers"][0]["id"]
    for words in commands("reviewer.md"):
        works([number if word == "ID" else word for word in words], book.folder)
    assert list((book.folder.parent / "review").rglob("report.html"))
    assert {file.name for file in (book.folder.parent / "number").iterdir()} == {"number.py", "number.R", "runs.csv"}


def test_a_capsule_is_made_and_checked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LABBOOK_AS", "Ada Nwosu")
    book = small_book(tmp_path / "book")
    sharing, privacy = re.findall(r"```toml\n(.*?)```", (DOCS / "capsule.md").read_text(encoding="utf-8"), re.DOTALL)
    book.toml.write_text(f"{book.toml.read_text(encoding='utf-8')}\n{sharing}\n{privacy}", encoding="utf-8")
    report, capsule, for_sharing, verify = commands("capsule.md")
    works([*report, "--unsaved", "--out", "../drawn"], book.folder)
    with book.open() as opened:
        state_report(opened, None, None, lambda _step: None)
    works(capsule, book.folder)
    works(for_sharing, book.folder)
    for words in (verify, ["verify", for_sharing[2]]):
        assert "whole" in works(words, book.folder).out


def test_a_foot_goes_into_grains(tmp_path: Path) -> None:
    few = ["--grain", "width=0.16", "--grain", "depth=0.14", "--diameter", "0.02"]
    for words in commands("grains.md"):
        size = words.index("--diameter") if "--diameter" in words else len(words)
        told = works([*words[:size], *words[size + 2 :], *few], tmp_path).out
        assert "one-way" in told
    assert (tmp_path / "grains.png").is_file()


def test_a_scene_is_changed_and_a_sweep_becomes_a_table_and_a_figure(tmp_path: Path) -> None:
    for words in commands("scenes.md"):
        works(words[: words.index("#")] if "#" in words else words, tmp_path)
    (script,) = re.findall(r"```python\n(.*?)```", (DOCS / "scenes.md").read_text(encoding="utf-8"), re.DOTALL)
    python(["-W", "error", "-c", f"import os\nos.chdir({str(tmp_path)!r})\n{script}"], MPLBACKEND="agg")
    header, *lines = (tmp_path / "sweep.csv").read_text(encoding="utf-8").splitlines()
    assert header.split(",")[:2] == ["b_ad", "gain"]
    assert len(lines) == 51 * 2
    assert all("touchdown" in line for line in lines)
    with Image.open(tmp_path / "sweep.png") as drawn:
        assert min(drawn.size) > 400


def test_jumps_are_reviewed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LABBOOK_AS", "Ada Nwosu")
    book = small_book(tmp_path / "book", two_people=True)
    for words in commands("review.md"):
        works(words[: words.index("#")] if "#" in words else words, book.folder)
    assert (book.folder / "r001-2.png").is_file()


def test_a_damaged_book(book: SmallBook) -> None:
    for words in commands("damaged-book.md"):
        works(words, book.folder)


@pytest.mark.soak
def test_hypotheses_and_a_ground_of_ones_own(book: SmallBook) -> None:
    table, contrasts = re.findall(r"```toml\n(.*?)```", (DOCS / "hypotheses.md").read_text(encoding="utf-8"), re.DOTALL)
    bed = book_toml(CHAPTER_5, predicted=False, decided=False).decode()
    planned = parse_configuration(bed + contrasts, "labbook.toml").analysis
    assert planned is not None
    assert len(planned.contrasts) == 3
    scene = '\n[simulation]\nscene = "bed"\nfactors = { foot = "foot_radius", b_ad_gain = "b_ad" }\n'
    book.toml.write_text(book.toml.read_text(encoding="utf-8") + scene + table, encoding="utf-8")
    (compare,) = commands("hypotheses.md")
    assert works(compare, book.folder).out.startswith("A jump of CE costs the same with either foot")
    (calibrate,) = commands("calibration.md")
    works(calibrate, book.folder)
    assert (book.folder / "ground.toml").is_file()


def test_grounds_that_refute_are_looked_for(tmp_path: Path) -> None:
    at_height, at_gains, _compare = commands("falsify.md")
    told = works([*at_height, "--grounds", "64", "--json"], tmp_path).json
    assert (told["equal"], told["grounds"], sum(told["verdicts"].values())) == ("height", 64, 64)
    more = works([*at_gains, "--grounds", "64", "--json"], tmp_path).json
    assert more["share_failing"] > told["share_failing"] == 0.0
    for file in ("falsify.png", "gains.png"):
        with Image.open(tmp_path / file) as drawn:
            assert min(drawn.size) > 900


@pytest.mark.soak
def test_what_the_page_says_of_grounds_that_refute_is_what_is_found(book: SmallBook) -> None:
    at_height, _at_gains, compare = commands("falsify.md")
    page = " ".join((DOCS / "falsify.md").read_text(encoding="utf-8").split())
    told = works([*at_height, "--json"], book.folder).json
    for sentence in told["sentences"]:
        assert " ".join(sentence.split()) in page
    assert [one["confirmed"] for one in told["counterexamples"]] == [True] * 5
    scene = '\n[simulation]\nscene = "bed"\nfactors = { foot = "foot_radius", b_ad_gain = "b_ad" }\n'
    book.toml.write_text(book.toml.read_text(encoding="utf-8") + scene, encoding="utf-8")
    assert "equal height" in works(compare, book.folder).out


def test_every_outcome_and_every_study_is_on_its_page() -> None:
    own_data, studies = ((DOCS / name).read_text(encoding="utf-8") for name in ("your-own-data.md", "studies.md"))
    assert [outcome.key for outcome in Outcome if outcome.key not in own_data.lower()] == []
    assert [name for name in STUDIES if name not in studies] == []
