"""What was decided about the analysis before the first measurement rules, and what departs from it is told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from data_schema.queries.history import first_measurement, recorded_configurations
from data_schema.queries.runs import list_runs
from data_schema.vocabulary import Action, ReasonCode, RunState
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.correcting import state_charge, unvoid, void
from labbook.actions.runs.jump_review import decide
from labbook.analysis.comparison.pairing import EACH, POOLED
from labbook.analysis.preregistration.planned import AS_A_WHOLE, NOTHING_DECIDED, Planned, _run_before
from labbook.config.model import AnalysisSettings, Bounds, Family
from tests.helpers.books import ADA, BEN, SmallBook, small_book
from tests.helpers.decided import decided_book, ingests, planned
from tests.helpers.statements import note, said_alike
from tests.helpers.wording import says

DECIDED = '\n[analysis]\nalpha = 0.01\nexclusions = ["misfire", "sensor_fault"]\n'
STOOD = AnalysisSettings(alpha=0.01, exclusions=(ReasonCode.MISFIRE, ReasonCode.SENSOR_FAULT))


def decides(made: SmallBook, analysis: str) -> None:
    """Let labbook.toml end with this table of what is decided."""
    text = made.toml.read_text().split("\n[analysis]")[0]
    made.toml.write_text(text + analysis)


def speaks(made: SmallBook, person: str = ADA) -> None:
    """Let a person say something, so that the book takes over what labbook.toml says."""
    with made.open() as book, book.session(person) as session:
        note(session, "heard")


def measured_by_one(made: SmallBook) -> None:
    ingests(made, made.log("r001"))


@pytest.fixture
def fresh(tmp_path: Path) -> SmallBook:
    """A book with runs and without files."""
    return small_book(tmp_path, ingested=False, two_people=True)


@pytest.fixture
def either(tmp_path: Path, database_url: str | None) -> SmallBook:
    """The same, on SQLite and on PostgreSQL."""
    return small_book(tmp_path, ingested=False, two_people=True, database_url=database_url)


def test_before_anything_is_measured_labbook_toml_speaks_for_itself(fresh: SmallBook) -> None:
    assert planned(fresh) == Planned(AnalysisSettings(), False, ())
    decides(fresh, DECIDED)
    found = planned(fresh)
    assert (found.settings, found.stated, found.departures, found.stated_utc) == (STOOD, True, (), None)
    speaks(fresh, BEN)
    assert planned(fresh).stated_by == BEN
    assert planned(fresh).first_measured_utc is None


def test_what_was_decided_stands_in_the_journal_before_the_first_file(either: SmallBook) -> None:
    """labbook.toml was edited and nothing said meanwhile: the ingest itself takes it over, and says that first."""
    decides(either, DECIDED)
    with either.open() as book:
        ingest_file(book, either.log("r001"), IngestRequest(person=BEN))
        said = [(entry.entity_kind, entry.action) for entry in said_alike(book)]
        with book.reading() as connection:
            first = first_measurement(connection)
            configurations = recorded_configurations(connection)
    assert said[-2:] == [("config", Action.SET), ("ingest", Action.INGEST)]
    assert first is not None
    assert (first.seq, configurations[-1].seq) == (len(said), len(said) - 1)
    assert "[analysis]" in configurations[-1].new["text"]
    found = planned(either)
    assert (found.settings, found.stated, found.departures) == (STOOD, True, ())
    assert (found.stated_utc, found.stated_by) == (configurations[-1].at_utc, BEN)
    assert found.first_measured_utc == first.at_utc


def test_a_charge_typed_in_is_a_measurement_and_a_run_sheet_and_a_refused_file_are_none(fresh: SmallBook) -> None:
    scan = fresh.instruments / "scan.pdf"
    scan.write_bytes(b"%PDF-1.7 not a log at all\n")
    ingests(fresh, scan)
    with fresh.open() as book, book.reading() as connection:
        assert said_alike(book)[-1].action is Action.INGEST
        assert not said_alike(book)[-1].reads
        assert first_measurement(connection) is None
    decides(fresh, DECIDED)
    with fresh.open() as book, book.session(ADA) as session:
        state_charge(session, book.configuration, "r001", 120.0, None, None)
    assert planned(fresh).stated
    with fresh.open() as book:
        assert [entry.entity_kind for entry in said_alike(book)[-2:]] == ["config", "charge"]


def test_where_nothing_was_decided_in_time_all_is_exploratory(fresh: SmallBook) -> None:
    measured_by_one(fresh)
    found = planned(fresh)
    assert (found.settings, found.stated, found.departures) == (AnalysisSettings(), False, (NOTHING_DECIDED,))
    decides(fresh, DECIDED)
    speaks(fresh, BEN)
    found = planned(fresh)
    assert (found.settings, found.stated, found.stated_by) == (STOOD, False, BEN)
    says(found.departures[0], NOTHING_DECIDED, "[analysis]", "by Ben Ode")
    assert found.exploratory(Outcome.JOULES, POOLED) == NOTHING_DECIDED
    assert found.exploratory_equivalence(POOLED) == NOTHING_DECIDED


def test_a_later_change_is_taken_over_and_told_and_rules_nothing(fresh: SmallBook) -> None:
    decides(fresh, DECIDED)
    measured_by_one(fresh)
    decides(fresh, '\n[analysis]\nprimary_outcome = "apex"\nfamily = "each"\nexclusions = ["misfire"]\n')
    speaks(fresh, BEN)
    with fresh.open() as book:
        assert "config" in [entry.entity_kind for entry in said_alike(book)[-2:]]
    found = planned(fresh)
    assert (found.settings, found.stated, found.stated_by) == (STOOD, True, ADA)
    words = [sentence.split(" before")[0] for sentence in found.departures]
    assert words == [
        "[analysis] had primary outcome joules", "[analysis] had family pooled", "[analysis] had alpha 0.01",
        "[analysis] had exclusions misfire, sensor_fault",
    ]  # fmt: skip
    says(found.departures[0], "labbook.toml", "20", "stated before stands")
    assert found.exploratory(Outcome.JOULES, POOLED) is None


def test_a_run_is_older_by_its_start_and_without_one_by_its_day(fresh: SmallBook) -> None:
    with fresh.open() as book, book.reading() as connection:
        run = replace(list_runs(connection)[0], day="2026-03-05", state=RunState.COMPLETE)
    at = "2026-03-05T12:00:00Z"
    for started, expected in ((None, None), ("2026-03-05T11:59:59Z", "2026-03-05"), ("2026-03-05T12:00:01Z", None)):
        assert _run_before([replace(run, started_utc=started)], at) == expected
    earlier = replace(run, day="2026-03-04", started_utc=None)
    assert _run_before([run, earlier], at) == "2026-03-04"
    assert _run_before([replace(earlier, state=RunState.OPEN)], at) is None


def test_what_is_taken_out_stands_and_what_is_changed_back_is_no_departure(fresh: SmallBook) -> None:
    decides(fresh, DECIDED)
    measured_by_one(fresh)
    decides(fresh, "")
    found = planned(fresh)
    assert found.settings == STOOD
    says(found.departures[0], "labbook.toml", "[analysis]")
    for analysis in ("\n[analysis]\nalpha = 0.1\n", DECIDED):
        decides(fresh, analysis)
        speaks(fresh)
    assert planned(fresh).departures == ()


def test_settings_have_stood_since_they_were_last_changed(fresh: SmallBook) -> None:
    decides(fresh, DECIDED)
    speaks(fresh, BEN)
    fresh.toml.write_text("# the same decisions\n" + fresh.toml.read_text())
    speaks(fresh, ADA)
    measured_by_one(fresh)
    assert planned(fresh).stated_by == BEN


def test_bounds_that_come_late_are_used_and_exploratory(fresh: SmallBook) -> None:
    decides(fresh, DECIDED)
    measured_by_one(fresh)
    decides(fresh, DECIDED + "apex_bounds_percent = [-3, 3]\n")
    found = planned(fresh)
    assert found.settings.apex_bounds == Bounds(-3.0, 3.0, percent=True)
    says(found.departures, "apex bounds none", "-3 to 3", "exploratory")
    assert "no bounds" in str(found.exploratory_equivalence(POOLED))
    assert found.exploratory(Outcome.JOULES, POOLED) is None


@pytest.mark.parametrize(("family", "name"), [(Family.EACH, EACH), (Family.POOLED, POOLED)])
def test_one_outcome_in_one_family_is_planned(family: Family, name: str) -> None:
    for outcome in Outcome:
        plan = Planned(AnalysisSettings(primary_outcome=outcome, family=family), True, ())
        both = [(quantity, one) for quantity in Outcome for one in (EACH, POOLED)]
        assert [one for one in both if not plan.exploratory(*one)] == [(outcome, name)]
        says(plan.exploratory(outcome, "another family"), "family decided on", name)
        assert plan.exploratory_equivalence(name) is None


def test_what_was_left_out_for_other_reasons_is_told(tmp_path: Path) -> None:
    made = decided_book(tmp_path, DECIDED)
    with made.open() as book, book.session(ADA) as session:
        decide(book, session, "r002", [1, 2], "reject", "wrong_apex", None)
        decide(book, session, "r003", [1], "reject", "misfire", None)
        for verdict, reason in (("reject", "other"), ("clear", "other"), ("reject", "sensor_fault")):
            decide(book, session, "r004", [1], verdict, reason, None)
    found = planned(made)
    says(found.departures, "2 jumps", "r002", "wrong_apex", "not allowed")
    assert found.exploratory(Outcome.JOULES, POOLED) is None
    says(found.exploratory_equivalence(POOLED), "2 jumps", "r002")
    with made.open() as book, book.session(ADA) as session:
        void(session, "r006", "Sensor fault: the string was off its drum")
        void(session, "r002", "misfired badly")
    found = planned(made)
    says(found.departures, "r002", "misfired badly", "not allowed")
    says(found.exploratory(Outcome.JOULES, POOLED), "r002", "is void", AS_A_WHOLE)
    with made.open() as book, book.session(ADA) as session:
        unvoid(session, "r002", "it was another")
        void(session, "r002", "misfire")
    assert planned(made).departures == ()


def test_whoever_allows_other_reasons_allows_all(tmp_path: Path) -> None:
    made = decided_book(tmp_path, "\n[analysis]\nalpha = 0.01\n")
    with made.open() as book, book.session(ADA) as session:
        void(session, "r006", "foot came loose")
        decide(book, session, "r002", [1], "reject", "other", None)
    assert planned(made).departures == ()
