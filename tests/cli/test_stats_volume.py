"""What `labbook stats` prints stays readable: a field is explained once, notes stand below the sentences."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook
from tests.helpers.wording import says

BY = ("--value", "v", "--by", "gain")


@pytest.fixture
def table(tmp_path: Path) -> Path:
    rows = [f"{value + gain / 50},{gain}" for gain in (0, 50, 100, 200) for value in (1, 2, 4, 8)]
    path = tmp_path / "data.csv"
    path.write_text("\n".join(["v,gain", *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "words", [("compare",), ("savings",), ("equivalence", "--low=-3", "--high=3")], ids=lambda words: words[0]
)
def test_a_field_is_explained_once_however_many_groups(words: tuple[str, ...], table: Path) -> None:
    shown = good(labbook("stats", words[0], table, *BY, *words[1:], "--full", at=table.parent)).out.splitlines()
    fields = Counter(line.split()[0] for line in shown if line.startswith("  "))
    explained = [line for line in shown if line.startswith("  ") and line.endswith(".")]
    assert max(fields.values()) >= 3
    assert max(Counter(explained).values()) == 1
    undefined = {line.split()[0] for line in shown if "  undefined because " in line}
    assert {line.split()[0] for line in explained} | undefined == {*fields}


@pytest.mark.parametrize("command", ["compare", "anova", "savings"])
def test_notes_stand_right_below_the_sentences(command: str, table: Path) -> None:
    shown = good(labbook("stats", command, table, *BY, "--full", at=table.parent)).out.splitlines()
    first_blank = shown.index("")
    notes = [line.startswith("note: ") for line in shown[first_blank + 1 :]]
    says(shown[first_blank + 1], "control is taken", "'0'")
    together = notes.index(False)
    assert shown[first_blank + 1 + together] == ""
    assert sum(notes) == together


def test_the_sentences_on_many_groups_stay_short(tmp_path: Path) -> None:
    rows = [f"{place % 7 + value},g{place:02d}" for place in range(12) for value in (1, 2.5, 4, 8)]
    path = tmp_path / "many.csv"
    path.write_text("\n".join(["v,gain", *rows]) + "\n", encoding="utf-8")
    shown = good(labbook("stats", "anova", path, *BY, "--full", at=tmp_path)).out
    sentences, _blank, rest = shown.partition("\n\n")
    says(sentences, "66 pairs", "0.05")
    assert len(sentences) < 2000
    assert rest.count("g00  g01") == 2


def test_pairs_of_very_many_groups_are_left_out_and_the_note_says_how_to_ask(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    rows = [f"{group * 7 % 11 + value * (group % 3 + 1)},{group}" for group in range(201) for value in (1, 2)]
    path.write_text("\n".join(["v,gain", *rows]) + "\n", encoding="utf-8")
    shown = good(labbook("stats", "anova", path, *BY, at=tmp_path)).out
    says(shown, "201 groups", "20100 pairs", "200 groups", "stats.compare_all_pairs")
    assert "Tukey" not in shown
    assert "\nDunnett against " in shown
    found = good(labbook("stats", "anova", path, *BY, "--json", at=tmp_path)).json
    assert (found["tukey"], found["games_howell"]) == (None, None)
    assert found["tukey_reason"] == found["games_howell_reason"]
    says(found["tukey_reason"], "201 groups", "20100 pairs")
