import pytest

from reports.wording import count_text, in_sentence, list_text, sentence_start


def test_counts_and_lists():
    assert count_text(1, "run") == "1\u00a0run"
    assert count_text(2, "run") == "2\u00a0runs"
    assert count_text(2, "analysis", "analyses") == "2\u00a0analyses"
    assert [list_text(words) for words in ([], ["a"], ["a", "b"], ["a", "b", "c"])] == [
        "",
        "a",
        "a and b",
        "a, b and c",
    ]


def test_the_start_of_a_sentence_keeps_capitals_within():
    assert [sentence_start(text) for text in ("the apex", "AD gain", "")] == ["The apex", "AD gain", ""]


@pytest.mark.parametrize(
    ("title", "within"), [("Foot size", "foot size"), ("PWM duty", "PWM duty"), ("K", "K"), ("pH", "pH"), ("", "")]
)
def test_a_title_within_a_sentence_keeps_its_abbreviations(title: str, within: str) -> None:
    assert in_sentence(title) == within
