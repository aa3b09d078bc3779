from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UsageError
from simulator.ablation.smallest import tolerance_of
from tests.helpers.scenes import is_sentence


@pytest.mark.parametrize("words", ["1%", " 1 % ", "0.01", "1e-2", "1.0%"])
def test_the_same_share_in_other_words(words: str) -> None:
    assert tolerance_of(words, 1e-6) == 0.01


@given(st.floats(1e-4, 0.999))
def test_shares_and_percentages(share: float) -> None:
    assert tolerance_of(repr(share), 1e-6) == share
    assert tolerance_of(f"{100.0 * share!r}%", 1e-6) == pytest.approx(share, rel=1e-15)


def test_all_may_pass() -> None:
    assert tolerance_of("100%", 1e-6) == 1.0


@pytest.mark.parametrize(
    ("words", "accuracy", "said"),
    [
        ("little", 1e-6, "--within little is not a share above 0: write for example --within 1%"),
        ("", 1e-6, "is not a share above 0"),
        ("%", 1e-6, "is not a share above 0"),
        ("0", 1e-6, "is not a share above 0"),
        ("-1%", 1e-6, "is not a share above 0"),
        ("nan", 1e-6, "is not a share above 0"),
        ("inf%", 1e-6, "is not a share above 0"),
        ("1", 1e-6, "--within 1 does not say of what: write --within 1%, or a number below 1."),
        ("101%", 1e-6, "lets everything pass: give at most 100%"),
        ("0.01%", 1e-4, "too fine to tell with results of accuracy 0.0001: give at least 0.1%, or --accuracy 1e-05."),
        ("1%", 0.0, "an accuracy of 0 cannot be had"),
        ("1%", float("nan"), "an accuracy of nan cannot be had"),
    ],
)
def test_refused_words(words: str, accuracy: float, said: str) -> None:
    with pytest.raises(UsageError) as refusal:
        tolerance_of(words, accuracy)
    assert said in str(refusal.value)
    assert is_sentence(str(refusal.value))
