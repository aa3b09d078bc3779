"""What is computed again after a change, and what is not: counted on a whole analysis."""

from __future__ import annotations

import contextlib
import json
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import pytest

from data_schema.errors import BookDamaged
from data_schema.journal import canonical
from data_schema.outcomes import Outcome
from data_schema.queries.facts import find_uid
from data_schema.queries.results import ResultRow, results_by_key
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct, void
from labbook.actions.runs.jump_review import decide
from labbook.analysis.results.codec import Algorithm
from labbook.analysis.results.result_cache import Request, ResultCache, fingerprint, keep
from labbook.book.opening import Book
from labbook.book.write_session import WriteSession
from reports.numbers import Number, StoredAs, StoredResult
from tests.helpers.books import ADA, SmallBook, reported_book, small_book
from tests.helpers.wording import refuses

Stale = list[tuple[str, dict[str, Any]]]


@pytest.fixture
def made(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path)


@pytest.fixture
def book(tmp_path: Path) -> Iterator[Book]:
    """A book with everything ingested and reported once."""
    with reported_book(tmp_path).open() as standing:
        yield standing


def report(book: Book, where: str | None = None) -> tuple[list[ResultRow], list[ResultRow]]:
    """Report, and return what was computed and what was reused for it."""
    made = state_report(book, where, ADA, lambda _step: None)
    return list(made.cache.computed.values()), list(made.cache.reused.values())


def state(book: Book, said: Callable[[WriteSession], object]) -> Stale:
    """State something, and return what became stale."""
    with book.session(ADA) as session:
        said(session)
    return [(kind, json.loads(scope)) for kind, scope in session.stale]


def stored(book: Book) -> dict[str, ResultRow]:
    with book.reading() as connection:
        return results_by_key(connection)


def scope(row: ResultRow) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(row.scope_json)
    return found


def rests_on_any(rows: list[ResultRow], roots: list[ResultRow]) -> list[ResultRow]:
    """The roots and everything among the rows that rests on one of them, directly or not."""
    found = {row.uid: row for row in roots}
    while True:
        more = {
            row.uid: row
            for row in rows
            if row.uid not in found
            and any(item.input_uid in found for item in row.inputs if item.input_kind == "result")
        }
        if not more:
            return list(found.values())
        found |= more


def reject(book: Book, run: str, *jumps: int) -> Callable[[WriteSession], object]:
    return lambda session: decide(book, session, run, list(jumps), "reject", "touched_by_hand", None)


def test_a_second_report_computes_nothing(book: Book) -> None:
    computed, reused = report(book)
    assert computed == []
    assert len(reused) > 80
    assert {row.key for row in reused} == set(stored(book))


def test_rejecting_one_jump_computes_its_run_again_and_what_rests_on_it(book: Book) -> None:
    before = stored(book)
    stale = state(book, reject(book, "r001", 2))
    computed, reused = report(book)
    of_runs = [row for row in computed if row.kind == "run_apexes"]
    assert {scope(row)["run"] for row in of_runs} == {"r001"}
    assert len(of_runs) == 2  # by either detector; what heeds no decision stays
    assert {row.uid for row in computed} == {row.uid for row in rests_on_any(computed, of_runs)}
    compared = {"condition_summary", "decision", "decision_family", "thesis_route"}
    assert {row.kind for row in computed} == {"run_apexes", "thesis_route_over_jumps", *compared}
    quantities = {scope(row)["quantity"] for row in computed if row.kind in compared}
    assert quantities == {Outcome.APEX}
    small_control = "foot=small k_gain=400 b_ad_gain=0"
    assert {scope(row)["condition"] for row in computed if row.kind == "condition_summary"} == {small_control}
    assert len(computed) + len(reused) == len(before)
    assert len(reused) > 2 * len(computed)
    # everything computed again was named as stale, and what now stands is not
    named = {canonical([kind, about]) for kind, about in stale}
    assert {canonical([row.kind, scope(row)]) for row in computed} <= named
    after = stored(book)
    assert {key for key, row in after.items() if not row.stale} == {row.key for row in [*computed, *reused]}


@pytest.mark.soak
def test_taking_a_verdict_back_uses_the_old_results_and_computes_nothing(book: Book) -> None:
    before = stored(book)
    state(book, reject(book, "r001", 2))
    report(book)
    state(book, lambda session: decide(book, session, "r001", [2], "clear", "other", None))
    computed, reused = report(book)
    assert computed == []
    assert {row.key for row in reused} == set(before)
    after = stored(book)
    assert {key for key, row in after.items() if not row.stale} == set(before)
    assert {key for key, row in after.items() if row.stale} == set(after) - set(before)
    assert all(after[key].numbers == row.numbers for key, row in before.items())


@pytest.mark.soak
def test_a_verdict_given_again_uses_nothing_of_the_first(book: Book) -> None:
    """It is another person's word at another time, so its results have their own provenance."""
    state(book, reject(book, "r001", 2))
    state(book, lambda session: decide(book, session, "r001", [2], "clear", "other", None))
    state(book, reject(book, "r001", 2))
    computed, _reused = report(book)
    (row,) = [row for row in computed if row.kind == "run_apexes" and scope(row)["detector"] == "robust"]
    assert len([item for item in row.inputs if item.input_kind == "decision"]) == 1


@pytest.mark.soak
def test_detections_are_made_once(book: Book) -> None:
    made = state_report(book, None, ADA, lambda _step: None)
    assert made.detections.computed == {}
    state(book, reject(book, "r001", 2))
    made = state_report(book, "foot=small", ADA, lambda _step: None)
    assert made.detections.computed == {}


def test_correcting_the_foot_names_both_conditions_and_their_comparisons(book: Book) -> None:
    stale = state(book, lambda session: correct(book, session, "r004", ["foot=large"], "typed wrong"))
    of_runs = [about["run"] for kind, about in stale if kind.startswith("run_")]
    assert set(of_runs) == {"r004"}
    old, new = "foot=small k_gain=400 b_ad_gain=100", "foot=large k_gain=400 b_ad_gain=100"
    for quantity in (Outcome.JOULES, Outcome.APEX):
        summaries = [about for kind, about in stale if kind == "condition_summary" and about["quantity"] == quantity]
        assert {about["condition"] for about in summaries} == {old, new}
        labels = [about["label"] for kind, about in stale if kind == "decision" and about["quantity"] == quantity]
        assert any("small" in label for label in labels)
        assert any("large" in label for label in labels)
    kinds = {kind for kind, _about in stale}
    assert "passive_drain" not in kinds
    computed, _reused = report(book)
    assert {scope(row)["run"] for row in computed if row.kind.startswith("run_")} == {"r004"}
    untouched = {"foot=small k_gain=400 b_ad_gain=0", "foot=large k_gain=400 b_ad_gain=0"}
    summarised = {scope(row)["condition"] for row in computed if row.kind == "condition_summary"}
    assert summarised == {old, new}
    assert not summarised & untouched


def charge_of(book: Book, run: str) -> str:
    with book.reading() as connection:
        uid = find_uid(connection, "charge", stated_run=run)
    assert uid is not None
    return uid


def test_a_corrected_charge_touches_the_joules_of_its_run_only(book: Book) -> None:
    target = f"charge:{charge_of(book, 'r001')}"
    state(book, lambda session: correct(book, session, target, ["charge_mah=121"], "misread"))
    computed, _reused = report(book)
    assert {scope(row)["run"] for row in computed if row.kind.startswith("run_")} == {"r001"}
    assert {row.kind for row in computed} <= {
        "run_energy", "condition_summary", "decision", "decision_family", "thesis_route",
        "contrast", "overall_savings", "pack_deviation", "energy_budget",
    }  # fmt: skip
    assert {scope(row).get("quantity", Outcome.JOULES) for row in computed} == {Outcome.JOULES}


@pytest.mark.soak
def test_a_corrected_idle_charge_touches_the_drain_and_all_joules_but_no_apex(book: Book) -> None:
    target = f"charge:{charge_of(book, 'r007')}"
    stale = state(book, lambda session: correct(book, session, target, ["charge_mah=50"], "misread"))
    assert "passive_drain" in {kind for kind, _about in stale}
    computed, reused = report(book)
    assert len([row for row in computed if row.kind == "run_energy"]) == 12
    assert {row.kind for row in computed} & {"run_apexes"} == set()
    assert {scope(row).get("quantity", Outcome.JOULES) for row in computed} == {Outcome.JOULES}
    assert {row.kind for row in reused} >= {"run_apexes", "condition_summary", "decision"}


@pytest.mark.soak
def test_a_void_run_leaves_its_condition_and_computes_no_other_run(book: Book) -> None:
    stale = state(book, lambda session: void(session, "r001", "foot came loose"))
    assert {about["run"] for kind, about in stale if kind.startswith("run_")} == {"r001"}
    computed, _reused = report(book)
    assert {row.kind for row in computed} & {"run_energy", "run_apexes", "passive_drain"} == set()
    assert computed


@pytest.mark.soak
def test_a_selection_shares_the_runs_but_not_the_comparisons(book: Book) -> None:
    computed, reused = report(book, "foot=small")
    assert {row.kind for row in computed} & {"run_energy", "run_apexes", "passive_drain"} == set()
    assert {scope(row)["selection"] for row in computed} == {"foot=small"}
    assert {row.kind for row in reused} == {"passive_drain", "run_energy", "run_apexes"}
    again, _reused = report(book)
    assert again == []


# --- keys


@dataclass(frozen=True, slots=True)
class Trial(StoredResult):
    height: Number
    of: tuple[float | None, ...]
    by_name: Annotated[Mapping[str, Number], StoredAs("of {}, too")]
    note: str | None = None


def ensure(book: Book, compute: Callable[[], Trial], **differing: Any) -> tuple[Trial, int]:
    """Ask for a result, keep it, and return it with how many were computed."""
    parts: dict[str, Any] = {
        "version": 1,
        "scope": {"run": "r001"},
        "inputs": (fingerprint("run", "run", "u1", "content"),),
        "settings": {"detector": "robust"},
    }
    parts |= differing
    algorithm = Algorithm("trial", parts["version"], Trial)
    with book.session(ADA) as session:
        cache = ResultCache(session.connection)
        result = cache.ensure_one(Request(algorithm, parts["scope"], parts["inputs"], parts["settings"], compute))
        keep(session.connection, cache)
    return result, len(cache.computed)


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


def test_a_result_is_computed_once_and_comes_back_as_it_was(made: SmallBook) -> None:
    with made.open() as book:
        first, computed = ensure(book, trial)
        assert computed == 1
        back, computed = ensure(book, lambda: pytest.fail("computed again"))
        assert computed == 0
        assert back == first
        assert back == replace(trial(), height=first.height, by_name=first.by_name, origin=first.origin)
        assert (first.height.value, first.height.se, first.height.n) == (0.3, 0.001, 25)
        assert {name: item.value for name, item in first.by_name.items()} == {
            "r001": 1.5,
            "r002": Undefined(Reason.AS_SAID, said="nothing was measured"),
        }
        assert (back.origin.scope, back.origin.inputs) == (first.origin.scope, first.origin.inputs)


@pytest.mark.parametrize(
    "payload",
    ["{}", "[]", '{"undefined":[]}', '{"of":[1,"2.5"]}', '{"of":[1,"2.5",null]}', '{"of":[1,2.5,null],"further":1}'],
)
def test_a_result_that_is_not_of_its_form_is_damage(made: SmallBook, payload: str) -> None:
    with made.open() as book:
        ensure(book, trial)
        with contextlib.closing(sqlite3.connect(made.database)) as connection, connection:
            connection.execute("UPDATE result SET payload_json = ?", (payload,))
        with refuses(BookDamaged, "result", "labbook rebuild"):
            ensure(book, trial)


@pytest.mark.parametrize("name", DIFFERENCES)
def test_whatever_a_result_depends_on_makes_another_key(made: SmallBook, name: str) -> None:
    with made.open() as book:
        first, _computed = ensure(book, trial)
        other, computed = ensure(book, trial, **DIFFERENCES[name])
        assert computed == 1
        assert other.origin.key != first.origin.key
        assert other.height.provenance != first.height.provenance


def test_the_order_of_inputs_makes_no_other_key(made: SmallBook) -> None:
    inputs = (fingerprint("run", "run", "u1", "a"), fingerprint("run", "run", "u2", "b"))
    with made.open() as book:
        _first, computed = ensure(book, trial, inputs=inputs)
        assert computed == 1
        _same, computed = ensure(book, trial, inputs=inputs[::-1])
        assert computed == 0
