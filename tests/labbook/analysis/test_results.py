"""What a result is named after, and of which results a changed fact makes others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import pytest

from data_schema.outcomes import Outcome
from data_schema.queries.facts import find_uid
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct, void
from labbook.actions.runs.jump_review import decide
from labbook.analysis.results import Algorithm, Results, equals_printed, fingerprint, numbers_of
from labbook.book.opening import Book
from labbook.book.write_session import WriteSession
from reports.numbers import Number, NumberNames, Origin, Result
from tests.helpers.books import ADA, reported_book

Made = dict[str, Origin]


@pytest.fixture
def book(tmp_path: Path) -> Iterator[Book]:
    """A book with everything ingested and reported once."""
    with reported_book(tmp_path).open() as standing:
        yield standing


def report(book: Book, where: str | None = None) -> Made:
    """Report, and return what was computed for it, by key."""
    made = state_report(book, where, ADA, lambda _step: None).computed.made
    return {key: one.origin for key, one in made.items()}


def state(book: Book, said: Callable[[WriteSession], object]) -> None:
    with book.session(ADA) as session:
        said(session)


def others(after: Made, before: Made) -> list[Origin]:
    """What is not the same result as before."""
    return [origin for key, origin in after.items() if key not in before]


def resting_on(origins: list[Origin], roots: list[Origin]) -> set[str]:
    """The roots and everything among these that rests on one of them, directly or not."""
    found = {origin.uid for origin in roots}
    while True:
        more = {
            origin.uid
            for origin in origins
            if any(row.input_uid in found for row in origin.inputs if row.input_kind == "result")
        } - found
        if not more:
            return found
        found |= more


def reject(book: Book, run: str, *jumps: int) -> Callable[[WriteSession], object]:
    return lambda session: decide(book, session, run, list(jumps), "reject", "touched_by_hand", None)


def test_rejecting_one_jump_gives_other_results_of_its_run_and_of_what_rests_on_it(book: Book) -> None:
    before = report(book)
    assert report(book) == before
    assert len(before) > 80
    state(book, reject(book, "r001", 2))
    after = report(book)
    anew = others(after, before)
    of_runs = [origin for origin in anew if origin.kind == "run_apexes"]
    assert {origin.scope["run"] for origin in of_runs} == {"r001"}
    assert len(of_runs) == 2  # by either detector; what heeds no decision stays
    assert {origin.uid for origin in anew} == resting_on(anew, of_runs)
    compared = {"condition_summary", "decision", "decision_family", "thesis_route"}
    assert {origin.kind for origin in anew} == {"run_apexes", "thesis_route_over_jumps", *compared}
    assert {origin.scope["quantity"] for origin in anew if origin.kind in compared} == {Outcome.APEX}
    small_control = "foot=small k_gain=400 b_ad_gain=0"
    assert {origin.scope["condition"] for origin in anew if origin.kind == "condition_summary"} == {small_control}
    assert len(after) == len(before) > 2 * len(anew)
    state(book, lambda session: decide(book, session, "r001", [2], "clear", "other", None))
    assert report(book) == before
    state(book, reject(book, "r001", 2))  # another person's word at another time has its own provenance
    (row,) = [
        origin
        for origin in others(report(book), after)
        if origin.kind == "run_apexes" and origin.scope["detector"] == "robust"
    ]
    assert len([item for item in row.inputs if item.input_kind == "decision"]) == 1


def test_correcting_the_foot_gives_both_conditions_other_results(book: Book) -> None:
    before = report(book)
    state(book, lambda session: correct(book, session, "r004", ["foot=large"], "typed wrong"))
    anew = others(report(book), before)
    assert {origin.scope["run"] for origin in anew if origin.kind.startswith("run_")} == {"r004"}
    old, new = "foot=small k_gain=400 b_ad_gain=100", "foot=large k_gain=400 b_ad_gain=100"
    assert {origin.scope["condition"] for origin in anew if origin.kind == "condition_summary"} == {old, new}
    assert "passive_drain" not in {origin.kind for origin in anew}


def charge_of(book: Book, run: str) -> str:
    with book.reading() as connection:
        uid = find_uid(connection, "charge", stated_run=run)
    assert uid is not None
    return f"charge:{uid}"


def test_a_corrected_charge_touches_the_joules_of_its_run_only(book: Book) -> None:
    before, target = report(book), charge_of(book, "r001")
    state(book, lambda session: correct(book, session, target, ["charge_mah=121"], "misread"))
    anew = others(report(book), before)
    assert {origin.scope["run"] for origin in anew if origin.kind.startswith("run_")} == {"r001"}
    assert {origin.kind for origin in anew} <= {
        "run_energy", "condition_summary", "decision", "decision_family", "thesis_route",
        "contrast", "overall_savings", "pack_deviation", "energy_budget",
    }  # fmt: skip
    assert {origin.scope.get("quantity", Outcome.JOULES) for origin in anew} == {Outcome.JOULES}


@pytest.mark.soak
def test_a_corrected_idle_charge_touches_the_drain_and_all_joules_but_no_apex(book: Book) -> None:
    before, target = report(book), charge_of(book, "r007")
    state(book, lambda session: correct(book, session, target, ["charge_mah=50"], "misread"))
    anew = others(report(book), before)
    assert len([origin for origin in anew if origin.kind == "run_energy"]) == 12
    assert {"run_energy", "passive_drain"} <= {origin.kind for origin in anew}
    assert "run_apexes" not in {origin.kind for origin in anew}
    assert {origin.scope.get("quantity", Outcome.JOULES) for origin in anew} == {Outcome.JOULES}


@pytest.mark.soak
def test_a_void_run_leaves_its_condition_and_no_other_run_has_another_result(book: Book) -> None:
    before = report(book)
    state(book, lambda session: void(session, "r001", "foot came loose"))
    anew = others(report(book), before)
    assert {origin.kind for origin in anew} & {"run_energy", "run_apexes", "passive_drain"} == set()
    assert anew


@pytest.mark.soak
def test_a_selection_shares_the_runs_but_not_the_comparisons(book: Book) -> None:
    whole, part = report(book), report(book, "foot=small")
    anew = others(part, whole)
    assert {origin.kind for origin in anew} & {"run_energy", "run_apexes", "passive_drain"} == set()
    assert {origin.scope["selection"] for origin in anew} == {"foot=small"}
    assert {part[key].kind for key in part.keys() & whole.keys()} == {"passive_drain", "run_energy", "run_apexes"}


# --- keys


@dataclass(frozen=True, slots=True)
class Trial(Result):
    height: Number
    of: tuple[float | None, ...]
    by_name: Annotated[Mapping[str, Number], NumberNames("of {}, too")]
    note: str | None = None


def record(computed: Results, result: Trial, **differing: Any) -> Trial:
    """Record a result."""
    parts: dict[str, Any] = {
        "version": 1,
        "scope": {"run": "r001"},
        "inputs": (fingerprint("run", "run", "u1", "content"),),
        "settings": {"detector": "robust"},
    }
    parts |= differing
    algorithm = Algorithm("trial", parts["version"])
    return computed.record(algorithm, parts["scope"], parts["inputs"], result, parts["settings"])


@pytest.fixture
def computed() -> Results:
    return Results()


def trial() -> Trial:
    none = Number(
        Undefined(Reason.AS_SAID, said="nothing was measured"),
        "m",
        ci_low=Undefined(Reason.AS_SAID, said="nothing was measured"),
    )
    return Trial(Number(0.3, "m", 0.001, n=25), (1.0, 2.5, None), {"r001": Number(1.5, "N", 0.1), "r002": none})


DIFFERENCES: Mapping[str, dict[str, Any]] = {
    "version": {"version": 2},
    "scope": {"scope": {"run": "r002"}},
    "input content": {"inputs": (fingerprint("run", "run", "u1", "other content"),)},
    "input": {"inputs": (fingerprint("run", "run", "u2", "content"),)},
    "input's role": {"inputs": (fingerprint("idle", "run", "u1", "content"),)},
    "no input": {"inputs": ()},
    "settings": {"settings": {"detector": "published"}},
}


def test_the_numbers_of_a_result_have_ids_and_are_what_they_were(computed: Results) -> None:
    first = record(computed, trial())
    assert record(computed, trial()) == first
    assert list(computed.made.values()) == [first]
    numbers = dict(numbers_of(first))
    assert numbers == {
        "height": first.height,
        "of r001, too": first.by_name["r001"],
        "of r002, too": first.by_name["r002"],
    }
    assert len({number.provenance for number in numbers.values()} - {""}) == 3
    bare = {name: replace(number, provenance="") for name, number in first.by_name.items()}
    assert replace(first, height=replace(first.height, provenance=""), by_name=bare, origin=Origin()) == trial()
    assert (first.origin.kind, first.origin.version, first.origin.scope) == ("trial", 1, {"run": "r001"})


@pytest.mark.parametrize("name", DIFFERENCES)
def test_whatever_a_result_depends_on_makes_another_key(computed: Results, name: str) -> None:
    first, other = record(computed, trial()), record(computed, trial(), **DIFFERENCES[name])
    assert len(computed.made) == 2
    assert other.origin.key != first.origin.key
    assert other.height.provenance != first.height.provenance


def test_the_order_of_inputs_makes_no_other_key(computed: Results) -> None:
    inputs = (fingerprint("run", "run", "u1", "a"), fingerprint("run", "run", "u2", "b"))
    first = record(computed, trial(), inputs=inputs)
    assert record(computed, trial(), inputs=inputs[::-1]) == first


@pytest.mark.parametrize(
    ("printed", "value", "se", "same"),
    [
        (None, None, None, True),
        (None, 0.0, None, False),
        (0.0, None, None, False),
        (0.15, 0.15 * (1 + 1e-12), None, True),
        (0.15, 0.15 * (1 + 1e-6), None, False),
        (0.0, 0.0, None, True),
        (0.0, 1e-12, None, False),
        (5.9e-16, -2.2e-16, 0.3, True),  # the mean deviation of a book's only pack is 0 but for rounding
        (5.9e-16, 0.01, 0.3, False),
        (5.9e-16, -2.2e-16, None, False),
    ],
)
def test_values_agree_when_another_machine_could_have_added_in_another_order(
    printed: float | None, value: float | None, se: float | None, same: bool
) -> None:
    assert equals_printed(printed, value, se) is same
