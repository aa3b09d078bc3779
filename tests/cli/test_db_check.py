"""`labbook db check`: every kind of damage, done for real, is found and told with what to do."""

from __future__ import annotations

import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.cli.shell import Answer, good, labbook, unchanged
from tests.helpers.books import SmallBook, reported_book
from tests.helpers.wording import says


def check(book: SmallBook) -> Answer:
    with unchanged(book.folder):
        return labbook("db", "check", at=book.folder)


def found(book: SmallBook, *problems: tuple[str, ...]) -> None:
    """The check finds these problems and says all the words about each; for programs too."""
    answer = check(book)
    assert (answer.code, answer.err) == (3, "")
    head, *lines = answer.out.splitlines()
    assert head.startswith(f"{len(problems)} problem")
    assert len(lines) == len(problems)
    for words in problems:
        assert any(all(word in line for word in words) for line in lines), words
    told = labbook("db", "check", "--json", at=book.folder)
    assert told.code == 3
    assert told.json["whole"] is False
    assert told.json["problems"] == [line.strip() for line in lines]


def test_a_whole_book_is_said_to_be_whole(book: SmallBook) -> None:
    answer = good(labbook("db", "check", at=book.folder))
    entries = len(book.journal.read_text().splitlines())
    says(answer.out, "book is whole", entries, "14 raw", "12 files")
    told = good(labbook("db", "check", "--json", at=book.folder)).json
    assert told["whole"] is True
    assert told["problems"] == told["orphans"] == []


def test_damaged_raw_copies_are_named(whole: SmallBook) -> None:
    missing, cut, other, whole_one = sorted(whole.folder.glob("raw/*/*.zst"))[:4]
    for path in (cut, other):
        path.chmod(0o644)
    missing.unlink()
    cut.write_bytes(cut.read_bytes()[:-30])
    shutil.copyfile(whole_one, other)
    found(whole, *((path.name, "restore it from a backup") for path in (missing, cut, other)))


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 0x10
    path.write_bytes(content)


def change_a_value(path: Path) -> None:
    """As a program would that knows the format: all checksums fit."""
    table = pq.read_table(path)
    name = table.column_names[-1]
    values = table[name].to_numpy().copy()
    values[len(values) // 2] += 1e-9
    pq.write_table(table.set_column(table.num_columns - 1, name, [values]), path, write_page_checksum=True)


def spoil_a_name(path: Path) -> None:
    """A flipped bit leaves a name that is no text: names have no checksum."""
    content = path.read_bytes()
    assert b"time [s]" in content
    path.write_bytes(content.replace(b"time [s]", b"tim\xe5 [s]"))


DAMAGES = [Path.unlink, flip, change_a_value, spoil_a_name]


def test_damaged_samples_are_named_and_come_back_with_rebuild(whole: SmallBook) -> None:
    victims = sorted(whole.folder.glob("signals/*/*.parquet"))[: len(DAMAGES)]
    for damage, victim in zip(DAMAGES, victims, strict=True):
        victim.chmod(0o644)
        damage(victim)
    found(whole, *((victim.name, "r0", "run `labbook rebuild`") for victim in victims))
    good(labbook("rebuild", at=whole.folder))
    assert check(whole).code == 0


@pytest.mark.parametrize("how", ["gone", "rubbish"])
def test_without_a_database_the_rest_is_checked_all_the_same(whole: SmallBook, how: str) -> None:
    whole.journal.write_text(whole.journal.read_text().replace("Nwosu", "Nwoso", 1))
    for piece in whole.folder.glob("labbook.db*"):
        piece.unlink()
    if how == "rubbish":
        whole.database.write_bytes(b"not a database " * 1000)
    found(whole, ("labbook restore",), ("database",), ("changed after it",))


def test_what_nothing_speaks_of_is_named_and_does_no_harm(whole: SmallBook) -> None:
    stray = whole.folder / "signals" / "ab" / "stray.parquet"
    stray.parent.mkdir(exist_ok=True)
    stray.write_bytes(b"left by a crash")
    out = good(check(whole)).out
    says(out, "book is whole")
    says(out, "1 file", "signals/ab/stray.parquet")


def test_an_entry_that_waits_in_the_file_is_no_damage(whole: SmallBook) -> None:
    copy = whole.folder.with_name("before")
    shutil.copytree(whole.folder, copy)
    good(labbook("note", "r001", "said before the power cut", at=whole.folder))
    shutil.copy(whole.journal, copy / "journal.jsonl")
    says(good(labbook("db", "check", at=copy)).out, "1 entry", "journal.jsonl")
    good(labbook("note", "r001", "said after it", at=copy))
    assert "wait" not in good(labbook("db", "check", at=copy)).out


def test_what_was_cut_off_at_the_end_of_the_journal_is_told_and_no_damage(whole: SmallBook) -> None:
    with whole.journal.open("a") as handle:
        handle.write('{"action":"note","at_utc":"2021')
    said = "1 line at the end of journal.jsonl (31 bytes) does not count"
    answer = good(check(whole))
    says(answer.out, "book is whole")
    assert said in answer.out
    assert good(labbook("db", "check", "--json", at=whole.folder)).json["left_out"] == {"lines": 1, "n_bytes": 31}
    assert said in good(labbook("rebuild", at=whole.folder)).out
    good(labbook("note", "r001", "after the crash", at=whole.folder))
    (kept,) = whole.folder.glob("journal.jsonl.cut-off.*")
    assert kept.read_text() == '{"action":"note","at_utc":"2021'
    assert "does not count" not in good(check(whole)).out


def test_files_of_a_report_that_were_altered_since_are_named(whole: SmallBook, tmp_path: Path) -> None:
    """Each report in its own folder, where it still is: in the book, or elsewhere."""
    assert good(labbook("db", "check", "--json", at=whole.folder)).json["reports"] == 0
    page = Path(good(labbook("report", at=whole.folder)).out.splitlines()[-1])
    elsewhere = tmp_path / "paper"
    good(labbook("report", "--where", "foot=small", "--out", elsewhere, at=whole.folder))
    assert good(labbook("db", "check", "--json", at=whole.folder)).json["reports"] == 2
    page.write_text(page.read_text(encoding="utf-8").replace("8", "9", 1), encoding="utf-8")
    table, figure = elsewhere / "tables" / "each_run.csv", next(elsewhere.glob("figures/*.svg"))
    with table.open("a", encoding="utf-8") as rows:
        rows.write("r099\n")
    figure.unlink()
    macros = elsewhere / "numbers.tex"
    macros.write_bytes(macros.read_bytes().replace(b"1", b"2", 1))
    mark = next(path for path in page.parent.iterdir() if path.name.startswith("."))
    mark.write_text("another report")  # in the book nobody writes one over it
    found(
        whole,
        ("report 1,", "report.html", mark.name),
        ("report 2,", "foot=small", "tables/each_run.csv", f"figures/{figure.name}", "numbers.tex"),
    )
    shutil.rmtree(page.parent)
    found(whole, ("report 2,", "tables/each_run.csv"))
    good(labbook("report", "--unsaved", "--out", elsewhere, at=whole.folder))  # what was there is there no longer
    assert good(labbook("db", "check", "--json", at=whole.folder)).json["reports"] == 0


def test_what_labbook_toml_says_otherwise_than_when_a_report_was_made_is_said_by_its_key(tmp_path: Path) -> None:
    book = reported_book(tmp_path)

    def settings() -> list[str]:
        answer = good(labbook("db", "check", "--json", at=book.folder)).json
        assert answer["whole"] is True
        lines: list[str] = answer["other_settings"]
        assert all(line in good(labbook("db", "check", at=book.folder)).out for line in lines)
        return lines

    text = book.toml.read_text(encoding="utf-8")
    named = text.replace('control_name = "CE"', 'control_name = "none"').replace('"active damping"', '"damping"')
    more = text.replace('"Ada Nwosu" = "AN"', '"Ada Nwosu" = "AN"\n"Bo Lund" = "BL"')
    pack = "\n[batteries.D]\ncells = 4\ncapacity_mah = 6600\n"
    offered = text.replace("[protocol]\n", '[protocol]\nreject_reasons = ["misfire"]\n')
    for same in (f"{text}\n[analysis]\nalpha = 0.05\n", named, offered, more + pack):
        book.toml.write_text(same, encoding="utf-8")
        assert settings() == []
    decided = f"{text}\n[analysis]\nalpha = 0.1\n"
    book.toml.write_text(decided, encoding="utf-8")
    (line,) = settings()
    says(line, "report 1 ", "analysis.alpha", "0.05", "0.1")
    good(labbook("report", "--where", "foot=small", at=book.folder))
    assert settings() == [line]
    book.toml.write_text(decided.replace("15.4", "16.8"), encoding="utf-8")
    says(settings(), "report 1 ", "analysis.alpha", "study.reference_voltage_v", "15.4", "16.8")
    says(settings(), "report 2 ", "study.reference_voltage_v", "15.4", "16.8")
