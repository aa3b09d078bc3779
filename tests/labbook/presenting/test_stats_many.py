"""Sentences on many comparisons: those with a small p and a count; few are all told, as the result tells them."""

from __future__ import annotations

from data_schema.vocabulary import Undefined
from labbook.presenting.stats_many import MOST_IN_WORDS, against_control_text, all_pairs_text, family_text
from stats.dunnett import dunnett
from stats.multiple import holm
from stats.tukey import compare_all_pairs


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
    assert text.startswith("All pairs by Tukey, simultaneous (7 groups, n = 28): 6 of 21 pairs have an adjusted p of")
    assert text.count(" minus ") == 6
    assert text.count("g3") == 6
    for pair in compare_all_pairs(values).pairs:
        assert (f"{pair.a} minus {pair.b}" in text) == (isinstance(pair.p, float) and pair.p <= 0.05)
    assert text.endswith("); the table below has all.")


def test_where_none_is_small_a_count_says_so() -> None:
    text = all_pairs_text(compare_all_pairs(groups(7)), "")
    assert text.endswith("none of 21 pairs has an adjusted p of at most 0.05; the table below has all.")
    constant = compare_all_pairs({name: [1.0, 1.0] for name in groups(7)})
    assert all_pairs_text(constant, "").endswith(
        ": none of 21 pairs is tested, because no group has any scatter; the table below has all."
    )


def test_pairs_that_have_no_test_are_named_with_the_reason() -> None:
    some = {name: [1.0, 1.0, 1.0] if name in ("g0", "g1", "g2") else own[:3] for name, own in groups(7).items()}
    text = all_pairs_text(compare_all_pairs(some, variances="unequal"), "J")
    assert "none of 18 pairs tested has an adjusted p of at most 0.05; 3 of 21 have no test: " in text
    assert "g0 minus g1, g0 minus g2, g1 minus g2, because neither group has any scatter; the table" in text


def test_a_family_says_how_many_were_tested_and_why_others_were_not() -> None:
    why, other = Undefined("neither group has any scatter"), Undefined("group 'd' is empty")
    complete = holm({"a": 0.2, "b": 0.5}, "gains")
    assert family_text(complete) == complete.sentence()
    some = family_text(holm({"a": 0.2, "b": why, "c": why, "d": other}, "gains: all"))
    assert some.endswith(
        "adjusted by Holm at 0.05: 1 tested, none rejected; not tested: b, c, because neither group has any scatter; "
        "d, because group 'd' is empty."
    )
    assert family_text(holm({"a": why, "b": why}, "gains")).endswith(
        "at 0.05: none tested, because neither group has any scatter."
    )
    mixed = family_text(holm({"a": why, "d": other}, "gains"))
    assert "none tested: a, because neither group has any scatter; d, because group 'd' is empty." in mixed
    many = family_text(holm({"a": 0.01, **{f"b{place}": why for place in range(14)}}, "gains"))
    assert "not tested: b0, b1, " in many
    assert "b9 and 4 more, because neither group has any scatter." in many


def test_of_very_many_the_smallest_p_are_named() -> None:
    values = groups(12, {place: 20.0 * place for place in range(12)})
    text = all_pairs_text(compare_all_pairs(values), "J")
    assert f"66 of 66 pairs have an adjusted p of at most 0.05 (the {MOST_IN_WORDS} smallest: " in text
    assert text.count(" minus ") == MOST_IN_WORDS
    assert "g0 minus g11" in text
    treated = {name: own for name, own in values.items() if name != "g0"}
    against = against_control_text(dunnett(values["g0"], treated, control_name="g0"), "J")
    assert against.startswith("Dunnett against g0 (n = 4), 95 % simultaneous: 11 of 11 groups have an adjusted p")
    assert "g1 (n = 4)" not in against
    assert "g11 (n = 4)" in against
