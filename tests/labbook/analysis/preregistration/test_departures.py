"""The doors by which numbers could be chosen after they were seen: a selection, a correction, the protocol."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from labbook.actions.files.assigning import assign
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct, void
from labbook.analysis.comparison.pairing import POOLED
from labbook.analysis.preregistration.planned import Planned, planned_analysis
from tests.helpers.books import ADA, SmallBook, ingest_all, small_book
from tests.helpers.decided import DECIDED, decided_book
from tests.helpers.wording import says


@pytest.fixture
def honest(tmp_path: Path) -> SmallBook:
    """A book whose analysis was decided before everything was ingested."""
    return decided_book(tmp_path)


def planned(made: SmallBook) -> Planned:
    with made.open() as book, book.reading() as connection:
        return planned_analysis(connection, book.configuration)


def corrects(made: SmallBook, target: str, *assignments: str) -> None:
    with made.open() as book, book.session(ADA) as session:
        correct(book, session, target, assignments, "looked odd")


def charge_of(made: SmallBook, run: str) -> str:
    with made.open() as book, book.reading() as connection:
        query = f"SELECT charge.uid FROM charge JOIN run ON charge.run = run.id WHERE run.name = '{run}'"
        return f"charge:{connection.exec_driver_sql(query).scalar_one()}"


def reported(made: SmallBook, where: str | None) -> tuple[Planned, dict[tuple[str, Outcome, str], str]]:
    """What a report on a selection takes for planned, and why each of its comparisons is exploratory."""
    with made.open() as book:
        report = state_report(book, where, ADA, lambda _step: None)
    shown = report.content.comparisons
    return report.analysis.planned, {(item.label, item.quantity, item.family): item.exploratory for item in shown}


def key_of(made: SmallBook, run: str) -> str:
    with made.open() as book, book.reading() as connection:
        query = "SELECT condition.key FROM condition JOIN run ON run.condition = condition.id WHERE run.name = "
        return str(connection.exec_driver_sql(f"{query}'{run}'").scalar_one())


def test_planned_exclusions_depart_from_nothing(honest: SmallBook) -> None:
    with honest.open() as book, book.session(ADA) as session:
        void(session, "r006", "misfire")
    found, _why = reported(honest, None)
    assert found.stated
    assert (found.departures, found.further) == ((), ())
    assert planned(honest).departures == ()


@pytest.mark.parametrize(
    ("where", "left"),
    [("foot=small", ["large"]), pytest.param("foot=small and b_ad_gain=0", None, marks=pytest.mark.soak)],
)
def test_conditions_left_out_whole_are_told_and_make_nothing_else_exploratory(
    honest: SmallBook, where: str, left: list[str] | None
) -> None:
    found, why = reported(honest, where)
    (said,) = found.departures
    assert re.match(r"the selection leaves out [1-9] conditions? whole, whose comparisons belong to the pl", said)
    if left is None:
        assert key_of(honest, "r002") in said
        assert why == {}
    else:
        assert "foot=small" not in said
        of_joules = [
            reason
            for (_label, quantity, family), reason in why.items()
            if (quantity, family) == (Outcome.JOULES, POOLED)
        ]
        assert of_joules == [""]
    assert planned(honest).departures == ()


@pytest.mark.soak
def test_levels_left_out_of_a_group_make_its_comparisons_exploratory(tmp_path: Path) -> None:
    """A third level that the selection leaves out, with one of the two others."""
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text().replace("levels = [0, 100]", "levels = [0, 100, 200]") + DECIDED)
    corrects(made, "r004", "b_ad_gain=200")
    with made.open() as book:
        ingest_all(book, made.instruments)
    found, why = reported(made, "foot=small and b_ad_gain<200 or foot=large")
    (said,) = found.departures
    keys = [key_of(made, run) for run in ("r001", "r002", "r004")]
    says(said, "1 condition", keys[2])
    for key in keys[:2]:
        assert found.exploratory(Outcome.JOULES, POOLED, [key]) == said
        assert found.exploratory_equivalence(POOLED, [key]) == said
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(made, "r003")]) is None
    assert said in why.values()


def test_a_selection_of_some_runs_of_a_condition_makes_what_rests_on_it_exploratory(honest: SmallBook) -> None:
    found, why = reported(honest, "foot=small and run!=r002")
    said, whole = found.departures
    says(whole, "whose comparisons belong")
    key = key_of(honest, "r002")
    says(said, "selection leaves out", "r002", key, "takes its other")
    assert found.exploratory(Outcome.JOULES, POOLED, [key]) == said
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r001")]) is None
    assert found.exploratory_equivalence(POOLED, [key]) == said
    of_joules = [
        reason for (_label, quantity, family), reason in why.items() if quantity is Outcome.JOULES and family == POOLED
    ]
    assert of_joules == [said]


def test_runs_made_void_after_a_report_make_their_comparison_exploratory(honest: SmallBook) -> None:
    """Whatever the reason, and though it is allowed: their numbers had been seen."""
    key = key_of(honest, "r002")
    with honest.open() as book, book.reading() as connection:
        query = f"SELECT run.name FROM run JOIN condition ON run.condition = condition.id WHERE condition.key = '{key}'"
        names = list(connection.exec_driver_sql(query).scalars())
    reported(honest, None)
    with honest.open() as book, book.session(ADA) as session:
        for name in names:
            void(session, name, "misfire")
    found, _why = reported(honest, None)
    (said,) = found.departures
    says(said, "made void (misfire) after a report had been made", ADA, *names)
    says(str(found.exploratory(Outcome.JOULES, POOLED, [key])), "made void")
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r003")]) is None
    with honest.open() as book:
        content = state_report(book, None, ADA, lambda _step: None).content
    assert content.departed == 1
    assert content.void == f"Void: {', '.join(names)} (misfire)."


def test_a_correction_that_takes_a_run_out_makes_what_rests_on_it_exploratory(honest: SmallBook) -> None:
    key = key_of(honest, "r002")
    corrects(honest, "r002", "jumps_made=0")
    found = planned(honest)
    (said,) = found.departures
    says(said, "jumps_made", "r002", "3", "without joules a")
    assert found.exploratory(Outcome.JOULES, POOLED, [key]) == said
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r001")]) is None
    assert found.exploratory_equivalence(POOLED, [key]) is None
    corrects(honest, "r002", "jumps_made=3")
    assert planned(honest).departures == ()


@pytest.mark.parametrize(
    ("assignments", "words"),
    [
        (("jumps_made=2",), "jumps_made of run r002 was 3 and is 2"),
        (("duration_s=700",), "duration_s of run r002 was 720 and is 700"),
        (("foot=large",), "condition of run r002 was "),
    ],
)
def test_a_correction_that_keeps_a_run_in_is_told_only(
    honest: SmallBook, assignments: tuple[str, ...], words: str
) -> None:
    corrects(honest, "r002", *assignments)
    found = planned(honest)
    (said,) = found.departures
    assert words in said
    assert "which leaves" not in said
    assert found.exploratory(Outcome.JOULES, POOLED) is None
    assert found.exploratory_equivalence(POOLED) is None


def test_a_charge_taken_off_its_run_takes_the_run_out(honest: SmallBook) -> None:
    with honest.open() as book, book.session(ADA) as session:
        assign(session, "2021-06-14.csv#2", "none", "looked odd")
    (said,) = planned(honest).departures
    says(said, "of a charge", "r002", "without joules a")
    assert planned(honest).exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r002")]) == said


def test_a_correction_is_not_blamed_for_what_another_took(honest: SmallBook) -> None:
    corrects(honest, "r002", "jumps_made=2")
    corrects(honest, charge_of(honest, "r002"), "run=none")
    told, blamed = planned(honest).departures
    assert "jumps_made" in told
    assert "which leaves" not in told
    says(blamed, "r002", "without joules a")


def test_the_charge_of_an_idle_run_bears_on_all_joules(honest: SmallBook) -> None:
    corrects(honest, charge_of(honest, "r007"), "run=none")
    found = planned(honest)
    says(str(found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r002")])), "r007", "without joules a")


def test_a_run_made_idle_is_taken_out_of_its_condition(honest: SmallBook) -> None:
    key = key_of(honest, "r002")
    corrects(honest, "r002", "kind=idle", "jumps_made=0", "levels=none")
    found = planned(honest)
    told = {said.split(": ")[1].split(" of ")[0]: "which leaves" in said for said in found.departures}
    assert told == {"kind": True, "condition": False, "jumps_made": True}
    says(str(found.exploratory(Outcome.JOULES, POOLED, [key])), "r002", "without joules a")
    assert found.exploratory_equivalence(POOLED, [key]) is not None


def test_a_log_taken_off_its_run_takes_its_heights(honest: SmallBook) -> None:
    with honest.open() as book, book.session(ADA) as session:
        assign(session, "r002.csv", "none", "looked odd")
    found = planned(honest)
    (said,) = found.departures
    says(said, "r002.csv", "without apex height")
    assert found.exploratory(Outcome.JOULES, POOLED) is None
    assert found.exploratory_equivalence(POOLED, [key_of(honest, "r002")]) == said
    with honest.open() as book, book.session(ADA) as session:
        assign(session, "r002.csv", "r002", None)
    assert planned(honest).departures == ()


def test_a_log_moved_to_another_run_is_told_too(honest: SmallBook) -> None:
    with honest.open() as book, book.session(ADA) as session:
        assign(session, "r002.csv", "r003", "belongs there")
    found = planned(honest)
    (said,) = found.departures
    says(said, "r002.csv", "r003", "without apex height")
    for run in ("r002", "r003"):
        assert found.exploratory_equivalence(POOLED, [key_of(honest, run)]) == said


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        ("exclude_first_jumps = 2", "exclude_first_jumps of [protocol] was "),
        ("exclude_gap_jumps = false", "exclude_gap_jumps of [protocol] was true"),
        ('detector = "published"', "detector of [protocol] was robust"),
    ],
)
def test_other_rules_which_jumps_count_make_heights_exploratory(honest: SmallBook, rule: str, words: str) -> None:
    name = rule.split(" ")[0]
    lines = [line for line in honest.toml.read_text().splitlines() if not line.startswith(f"{name} ")]
    lines.insert(lines.index("[protocol]") + 1, rule)
    plain = honest.toml.read_text()
    honest.toml.write_text("\n".join(lines) + "\n")
    found = planned(honest)
    (said,) = found.departures
    assert said.startswith(words)
    assert found.exploratory_equivalence(POOLED) == said
    assert found.exploratory(Outcome.JOULES, POOLED) is None
    honest.toml.write_text(plain)
    assert planned(honest).departures == ()


def test_other_rules_of_single_jumps_make_their_heights_exploratory(honest: SmallBook) -> None:
    honest.toml.write_text(honest.toml.read_text().replace("[protocol]\n", '[protocol]\ntake_off = "20_percent"\n'))
    found = planned(honest)
    (departure,) = found.further
    says(departure.sentence, "take_off", "flight_5sd", "20_percent", Outcome.FLIGHT_HEIGHT.plural)
    assert departure.touches(Outcome.IMPULSE_HEIGHT, None)
    assert found.exploratory(Outcome.JOULES, POOLED) is None
    assert found.exploratory_equivalence(POOLED) is None


def test_what_was_corrected_before_the_first_measurement_is_no_departure(tmp_path: Path) -> None:
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text() + DECIDED)
    corrects(made, "r002", "jumps_made=2")
    with made.open() as book:
        ingest_all(book, made.instruments)
    assert planned(made).departures == ()
