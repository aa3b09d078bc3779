"""Sentences on many comparisons: those with a small p and a count; few are all told, as the result tells them."""

from __future__ import annotations

from labbook.actions.stats.anova import MOST_IN_WORDS, against_control_text, all_pairs_text
from stats.groups.dunnett import dunnett
from stats.groups.tukey import compare_all_pairs
from tests.helpers.wording import says


def groups(count: int, raised: dict[int, float] | None = None) -> dict[str, list[float]]:
    """Groups of four values each, some with a higher mean."""
    return {
        f"g{place}": [value + (raised or {}).get(place, 0.0) for value in (1.0, 2.0, 2.5, 4.0)]
        for place in range(count)
    }


def test_few_pairs_are_told_as_the_result_tells_them() -> None:
    pairs = compare_all_pairs(groups(5))
    assert len(pairs.pairs) == MOST_IN_WORDS
    assert all_pairs_text(pairs, "J") == pairs.sentence("J")
    against = dunnett(groups(1)["g0"], {f"t{place}": values for place, values in enumerate(groups(5).values())})
    assert against_control_text(against, "J") == against.sentence("J")


def test_of_many_those_with_a_small_p_are_told_and_counted() -> None:
    values = groups(7, {3: 12.0})
    pairs = compare_all_pairs(values)
    text = all_pairs_text(pairs, "J")
    says(text, "7 groups", "n = 28", "6", "21 pairs")
    assert text.count(" minus ") == 6
    assert text.count("g3") == 6
    for pair in compare_all_pairs(values).pairs:
        assert (f"{pair.a} minus {pair.b}" in text) == (isinstance(pair.p, float) and pair.p <= 0.05)
    says(text, "--full")


def test_where_none_is_small_a_count_says_so() -> None:
    text = all_pairs_text(compare_all_pairs(groups(7)), "")
    says(text, "21 pairs", "0.05", "--full")
    constant = compare_all_pairs({name: [1.0, 1.0] for name in groups(7)})
    says(all_pairs_text(constant, ""), "21 pairs", "--full")


def test_pairs_that_have_no_test_are_named_with_the_reason() -> None:
    some = {name: [1.0, 1.0, 1.0] if name in ("g0", "g1", "g2") else own[:3] for name, own in groups(7).items()}
    text = all_pairs_text(compare_all_pairs(some, variances="unequal"), "J")
    says(text, "18 pairs", "0.05", "3", "21", "g0", "g1")


def test_of_very_many_the_smallest_p_are_named() -> None:
    values = groups(12, {place: 20.0 * place for place in range(12)})
    text = all_pairs_text(compare_all_pairs(values), "J")
    says(text, "66 pairs", "0.05", MOST_IN_WORDS, "smallest")
    assert text.count(" minus ") == MOST_IN_WORDS
    assert "g0 minus g11" in text
    treated = {name: own for name, own in values.items() if name != "g0"}
    against = against_control_text(dunnett(values["g0"], treated, control_name="g0"), "J")
    says(against, "g0", "n = 4", "95 %", "11 groups")
    assert "g1 (n =" not in against
    says(against, "g11", "n = 4")


def test_names_that_hold_signs_of_the_sentence_are_told_whole() -> None:
    own = groups(13, {12: 20.0})
    values = {f"foot: {place}; no. {place}. ": group for place, group in enumerate(own.values())}
    pairs = compare_all_pairs(values)
    text = all_pairs_text(pairs, "J")
    small = [pair for pair in pairs.pairs if isinstance(pair.p, float) and pair.p <= 0.05]
    assert len(small) == 12
    head = "All pairs by Tukey, simultaneous (13 groups, n = 52): 12 of 78 pairs have an adjusted p of at most 0.05"
    says(text, head, "10 smallest", "12", "-20.0 J", "95 %")
    assert sum(pairs.pair_text(pair, "J") in text for pair in small) == MOST_IN_WORDS
    control, *treated = values
    against = dunnett(values[control], {name: values[name] for name in treated}, control_name=control)
    (raised,) = [item for item in against.comparisons if isinstance(item.p, float) and item.p <= 0.05]
    says(
        against_control_text(against, "J"),
        "n = 4",
        "95 %",
        "12 groups",
        "0.05",
        against.comparison_text(raised, "J"),
        "--full",
    )
    assert raised.treatment in against.comparison_text(raised, "J")
