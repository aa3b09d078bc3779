"""What a command is checked against holds what one before it had stated that was killed between journal and commit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from data_schema import journal
from data_schema.journal import Entry
from data_schema.vocabulary import Action
from tests.cli.shell import Answer, good, labbook
from tests.helpers.books import SmallBook, small_book
from tests.helpers.commands import KILLED, Commands
from tests.helpers.upkeep import health

MM = ("--column", "z=body_height:mm")
HOME_MADE = "t [ms],z\n" + "".join(f"{4 * place},{400 + place % 7}\n" for place in range(300))


def kill(book: SmallBook, commands: Commands, *words: str | Path) -> None:
    """Give a command that dies when the journal has it and the database not."""
    before = waiting(book)
    code, said = commands.run(*words, "--book", book.folder, die_after_sync=1, of="journal.jsonl")
    assert code == KILLED, said
    assert waiting(book) > before


def waiting(book: SmallBook) -> int:
    with book.open() as opened, opened.reading() as connection:
        return len(list(opened.mirror.entries())) - journal.head(connection)[0]


def stated(book: SmallBook) -> list[Entry]:
    with book.open() as opened:
        return list(opened.mirror.entries())


def give(book: SmallBook, *words: str | Path) -> Answer:
    return labbook(*words, at=book.folder)


def test_a_refused_command_leaves_what_it_caught_up_with(tmp_path: Path, commands: Commands) -> None:
    book = small_book(tmp_path)
    kill(book, commands, "note", "r001", "a cable came loose")
    assert give(book, "note", "r999", "no such run").code == 2
    assert waiting(book) == 0
    assert health(book).whole


def test_readers_say_that_entries_wait(tmp_path: Path, commands: Commands) -> None:
    book = small_book(tmp_path)
    kill(book, commands, "note", "r001", "a cable came loose")
    report = ("report", "--unsaved", "--out", tmp_path / "paper")
    for words in (("show", "r001"), ("runs", "list"), ("runs", "list", "--json"), report):
        done = give(book, *words)
        assert done.code == 0
        assert "1 entry waits" in done.err
    give(book, "note", "r001", "it was mended")
    assert give(book, "show", "r001").err == ""


def test_a_log_comes_to_a_run_that_only_the_journal_has(tmp_path: Path, commands: Commands) -> None:
    book = small_book(tmp_path, runs=False, ingested=False)
    kill(book, commands, "runs", "import", book.instruments / "runs.csv")
    assert "run r001" in good(give(book, "ingest", book.log("r001"), "--run", "r001")).out


@pytest.mark.parametrize("words", [("reject", "r003", "1", "--reason", "misfire"), ("move", "r003", "1", "--at")])
def test_no_verdict_on_a_log_that_was_taken_off(tmp_path: Path, commands: Commands, words: tuple[str, ...]) -> None:
    book = small_book(tmp_path)
    if words[-1] == "--at":
        found = good(give(book, "jumps", "list", "r003", "--json")).json
        words = (*words, str(found["jumps"][0]["jump"]["apex_s"]))
    kill(book, commands, "assign", "r003.csv", "none", "--why", "of another run")
    assert give(book, "jumps", *words).code == 2
    assert (stated(book)[-1].action, stated(book)[-1].entity_kind) == (Action.SET, "file")


def test_a_file_read_again_by_a_command_that_was_killed_is_read_again_once(tmp_path: Path, commands: Commands) -> None:
    book, log = small_book(tmp_path), tmp_path / "home made.csv"
    log.write_text(HOME_MADE)
    good(give(book, "ingest", log))
    kill(book, commands, "ingest", log, *MM)
    good(give(book, "ingest", log, *MM))
    assert [entry.reads and entry.old is not None for entry in stated(book)].count(True) == 1


def test_what_is_declared_adds_to_what_was_declared_meanwhile(tmp_path: Path, commands: Commands) -> None:
    book, log = small_book(tmp_path), tmp_path / "home made.csv"
    log.write_text(HOME_MADE)
    good(give(book, "ingest", log))
    kill(book, commands, "files", "reread", log.name, *MM)
    good(give(book, "files", "reread", log.name, "--column", "t=time:ms"))
    declared = (stated(book)[-1].new or {})["options"]
    assert declared["columns"].keys() == {"z", "t"}


def test_a_plan_after_a_killed_one_has_other_names(tmp_path: Path, commands: Commands) -> None:
    book = small_book(tmp_path)
    words = ("--n", "2", "--per-day", "8", "--start", "2021-06-21", "--out")
    kill(book, commands, "plan", "--seed", "7", *words, tmp_path / "one.csv")
    good(give(book, "plan", "--seed", "8", *words, tmp_path / "two.csv"))
    plans = [entry.new or {} for entry in stated(book) if entry.entity_kind == "plan"]
    names = [run["name"] for plan in plans for run in plan["runs"]]
    assert len(plans) == 2
    assert len(names) == len(set(names))


@pytest.mark.parametrize("wrong", [{"duration_s": "long"}, {"planned_run": "abcdefabcdef"}, {"name": "r001"}], ids=str)
def test_what_waits_and_cannot_take_effect_is_a_problem(tmp_path: Path, wrong: dict[str, str]) -> None:
    book = small_book(tmp_path)
    entries = stated(book)
    run = next(entry for entry in entries if entry.entity_kind == "run")
    said = replace(run, entity_uid="abcdefabcdef", new={**(run.new or {}), "name": "r998", **wrong})
    with book.open() as opened:
        opened.mirror.append(journal.chain_entries([said], (entries[-1].seq, entries[-1].hash)))
    found = health(book)
    assert (found.waiting, found.whole, len(found.problems)) == (1, False, 1)
    assert f"entry {len(entries) + 1} " in found.problems[0]
