"""The report of the demonstration is read in minutes: what stands open on the page is short."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.helpers.demos import made_demo

MOST_WORDS = 1200
MOST_WITHIN_DAYS = 1600
"""Where days are few, each sentence says besides for which it holds."""
NOT_RUNNING = {"head", "details", "table", "script", "style", "svg"}


class RunningText(HTMLParser):
    """Gathers the words outside folds, tables and drawings."""

    def __init__(self) -> None:
        super().__init__()
        self.within: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in NOT_RUNNING:
            self.within.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if self.within and self.within[-1] == tag:
            self.within.pop()

    def handle_data(self, data: str) -> None:
        if not self.within:
            self.words += data.split()


@pytest.mark.parametrize(
    ("name", "most"),
    [
        ("two_runs_a_condition", MOST_WITHIN_DAYS),
        pytest.param("simulated", MOST_WORDS, marks=pytest.mark.soak),
    ],
)
def test_the_page_of_the_demonstration_has_few_words_outside_folds_and_tables(name: str, most: int) -> None:
    text = RunningText()
    text.feed(Path(made_demo(name).page).read_text(encoding="utf-8"))
    assert 500 < len(text.words) <= most
