"""What a result is named after, and of which results a changed fact makes others."""

from __future__ import annotations

import functools
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
Said = Callable[[Book, WriteSession], object]


@pytest.fixture
def book(tmp_path: Path) -> Iterator[Book]:
    """A book with everything ingested and reported once."""
    with reported_book(tmp_path).open() as standing:
        yield standing


def report(book: Book, where: str | None = None) -> Made:
    """Report, and return what was computed for it, by key."""
    made = state_report(book, where, ADA, lambda _step: None).computed.made
    return {key: one.origin for key, one in made.items()}


def state(book: Book, said: Said) -> None:
    with book.session(ADA) as session:
        said(book, session)


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


def judged(book: Book, session: WriteSession, verdict: str = "reject", reason: str = "touched_by_hand") -> None:
    decide(book, session, "r001", [2], verdict, reason, None)


def test_rejecting_one_jump_gives_other_results_of_its_run_and_of_what_rests_on_it(book: Book) -> None:
    before = report(book)
    assert report(book) == before
    assert len(before) > 80
    state(book, judged)
    after = report(book)
    anew = others(after, before)
    of_runs = [origin for origin in anew if origin.kind == "run_apexes"]
    assert {origin.scope["run"] for origin in of_runs} == {"r001"}
    assert len(of_runs) == 2  # by either detector; what heeds no decision stays
    assert {origin.uid for origin in anew} == resting_on(anew, of_runs)
    compared = {"condition_summary", "decision", "decision_family", "thesis_route"}
    assert {origin.kind for origin in anew} == {"run_apexes", "thesis_route_over_jumps", *compared}
    assert {origin.scope["quantity"] for origin in anew if origin.kind in compared} == {Outcome.APEX}
    assert {origin.scope["condition"] for origin in anew if origin.kind == "condition_summary"} == {CONTROL}
    assert len(after) == len(before) > 2 * len(anew)
    state(book, functools.partial(judged, verdict="clear", reason="other"))
    assert report(book) == before
    state(book, judged)  # another person's word at another time has its own provenance
    rows = [origin for origin in others(report(book), after) if origin.scope.get("detector") == "robust"]
    (row,) = (origin for origin in rows if origin.kind == "run_apexes")
    assert [item.input_kind for item in row.inputs].count("decision") == 1


def of_charge(run: str, charge_mah: float) -> Said:
    def said(book: Book, session: WriteSession) -> None:
        uid = find_uid(session.connection, "charge", stated_run=run)
        correct(book, session, f"charge:{uid}", [f"charge_mah={charge_mah}"], "misread")

    return said


def shorter_leg(book: Book, session: WriteSession) -> None:
    correct(book, session, "robot:hopper", ["rest_length_m=0.26"], "measured again")


JUMP_RUNS = {f"r{number:03d}" for number in range(1, 17)} - {"r007", "r008", "r015", "r016"}
BOTH, JOULES = {Outcome.JOULES, Outcome.APEX}, {Outcome.JOULES}
ALL = [f"foot={foot} k_gain=400 b_ad_gain={gain}" for foot in ("small", "large") for gain in (0, 100)]
CONTROL, SMALL, _, LARGE = ALL


@pytest.mark.parametrize(
    ("said", "runs", "quantities", "conditions"),
    [
        (lambda book, session: correct(book, session, "r004", ["foot=large"], "w"), {"r004"}, BOTH, {SMALL, LARGE}),
        (of_charge("r001", 121), {"r001"}, JOULES, {CONTROL}),
        pytest.param(of_charge("r007", 50), JUMP_RUNS, JOULES, None, marks=pytest.mark.soak),  # an idle run's
        pytest.param(shorter_leg, JUMP_RUNS, BOTH, {*ALL}, marks=pytest.mark.soak),
        # With what was left out back in, all conditions are summed up once more.
        pytest.param(lambda _book, session: void(session, "r001", "w"), set(), BOTH, {*ALL}, marks=pytest.mark.soak),
    ],
)
def test_a_changed_fact_gives_other_results_of_what_rests_on_it_alone(
    book: Book, said: Said, runs: set[str], quantities: set[Outcome], conditions: set[str] | None
) -> None:
    before = report(book)
    state(book, said)
    anew = others(report(book), before)
    assert {origin.scope["run"] for origin in anew if origin.kind.startswith("run_")} == runs
    assert {origin.scope.get("quantity", Outcome.JOULES) for origin in anew} == quantities
    assert ("passive_drain" in {origin.kind for origin in anew}) is (conditions is None)
    if conditions is not None:
        assert {origin.scope["condition"] for origin in anew if origin.kind == "condition_summary"} == conditions


@pytest.mark.soak
def test_a_selection_shares_the_runs_but_not_the_comparisons(book: Book) -> None:
    whole, part = report(book), report(book, "foot=small")
    anew = others(part, whole)
    assert {origin.kind for origin in anew} & {"run_energy", "run_apexes", "passive_drain"} == set()
    assert {origin.scope["selection"] for origin in anew} == {"foot=small"}
    assert {part[key].kind for key in part.keys() & whole.keys()} == {"passive_drain", "run_energy", "run_apexes"}


# --- keys

RUN = (fingerprint("run", "run", "u1", "content"),)


@dataclass(frozen=True, slots=True)
class Trial(Result):
    height: Number
    of: tuple[float | None, ...]
    by_name: Annotated[Mapping[str, Number], NumberNames("of {}, too")]
    note: str | None = None


def record(computed: Results, result: Trial, **differing: Any) -> Trial:
    """Record a result."""
    parts: dict[str, Any] = {"scope": {"run": "r001"}, "inputs": RUN, "settings": {"detector": "robust"}, **differing}
    algorithm = Algorithm("trial", parts.pop("version", 1))
    return computed.record(algorithm, result=result, **parts)


@pytest.fixture
def computed() -> Results:
    return Results()


def trial() -> Trial:
    nothing = Undefined(Reason.AS_SAID, said="nothing was measured")
    none = Number(nothing, "m", ci_low=nothing)
    return Trial(Number(0.3, "m", 0.001, n=25), (1.0, 2.5, None), {"r001": Number(1.5, "N", 0.1), "r002": none})


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


@pytest.mark.parametrize(
    "differing",
    [
        {"version": 2},
        {"scope": {"run": "r002"}},
        {"inputs": (fingerprint("run", "run", "u1", "other content"),)},
        {"inputs": (fingerprint("run", "run", "u2", "content"),)},
        {"inputs": (fingerprint("idle", "run", "u1", "content"),)},
        {"inputs": ()},
        {"settings": {"detector": "published"}},
    ],
)
def test_whatever_a_result_depends_on_makes_another_key(computed: Results, differing: dict[str, Any]) -> None:
    first, other = record(computed, trial()), record(computed, trial(), **differing)
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
