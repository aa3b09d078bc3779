"""Charges and logs that come to a run when it has what counts, and those that are given to it after a report."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct
from labbook.analysis.comparison.pairing import POOLED
from labbook.analysis.preregistration.departures import DepartureKind
from labbook.analysis.preregistration.planned import Planned, planned_analysis
from labbook.book.rebuilding import rebuild_database
from labbook.demo.writers import bertec_text
from tests.helpers.books import ADA, SmallBook, copy_of
from tests.helpers.decided import decided_book
from tests.helpers.stated_campaign import plate_record
from tests.helpers.wording import says


@pytest.fixture
def honest(tmp_path: Path) -> SmallBook:
    return decided_book(tmp_path)


@pytest.fixture
def reported(tmp_path: Path) -> SmallBook:
    """The same with a report."""

    def made(folder: Path) -> SmallBook:
        book = decided_book(folder)
        reports(book)
        return book

    return copy_of("decided-reported", made, tmp_path)


def planned(made: SmallBook) -> Planned:
    with made.open() as book, book.reading() as connection:
        return planned_analysis(connection, book.configuration)


def key_of(made: SmallBook, run: str) -> str:
    with made.open() as book, book.reading() as connection:
        query = "SELECT condition.key FROM condition JOIN run ON run.condition = condition.id WHERE run.name = "
        return str(connection.exec_driver_sql(f"{query}'{run}'").scalar_one())


def another_log(made: SmallBook, name: str) -> Path:
    """The log of r003 less its last sample, under another name."""
    path = made.instruments / name
    path.write_bytes(b"\n".join((made.instruments / "logs" / "r003.csv").read_bytes().splitlines()[:-1]) + b"\n")
    return path


def ingests(made: SmallBook, path: Path, person: str = ADA) -> None:
    with made.open() as book:
        ingest_file(book, path, IngestRequest(person=person))


def assigns(made: SmallBook, what: str, run: str, why: str | None = None) -> None:
    """A charge given to r003 is added to the one that this run has."""
    with made.open() as book, book.session(ADA) as session:
        assign(session, what, run, why, add="#" in what and run == "r003")


def adds(made: SmallBook, what: str, run: str) -> None:
    with made.open() as book, book.session(ADA) as session:
        assign(session, what, run, None, add=True)


def reports(made: SmallBook) -> None:
    with made.open() as book:
        state_report(book, None, ADA, lambda _step: None)


def test_a_further_log_takes_its_run_out(honest: SmallBook) -> None:
    ingests(honest, another_log(honest, "r002 again.csv"))
    found = planned(honest)
    (said,) = found.departures
    says(said, "r002", "again.csv", "without apex height")
    assert found.exploratory_equivalence(POOLED, [key_of(honest, "r002")]) == said
    assert found.exploratory_equivalence(POOLED, [key_of(honest, "r001")]) is None
    assert found.exploratory(Outcome.JOULES, POOLED) is None
    with honest.open() as book, book.session(ADA) as session:
        correct(book, session, "r002", ["starts=2"], "it was started again")
    (corrected,) = planned(honest).departures
    says(corrected, "starts of run", "r002", "1")


def test_an_assignment_taken_back_is_no_departure_unless_a_report_saw_it(reported: SmallBook) -> None:
    ingests(reported, another_log(reported, "loose.csv"))
    assigns(reported, "loose.csv", "r002")
    assigns(reported, "loose.csv", "none", "wrong")
    assert planned(reported).departures == ()
    assigns(reported, "loose.csv", "r002")
    reports(reported)
    assigns(reported, "loose.csv", "none", "wrong")
    (said,) = planned(reported).departures
    says(said, "loose.csv was taken off run r002")


@pytest.mark.parametrize("report_first", [True, False])
def test_a_charge_that_is_added_to_one_that_a_report_showed_makes_the_condition_exploratory(
    honest: SmallBook, report_first: bool
) -> None:
    sheet = honest.instruments / "again.csv"
    sheet.write_text("run,mAh,minutes,end_voltage,pack,ended\nr002,90,10,16.80,B,2021-06-14 10:17\n")
    ingests(honest, sheet)
    steps: list[Callable[[], None]] = [lambda: reports(honest), lambda: adds(honest, "again.csv#1", "r002")]
    for step in steps if report_first else steps[::-1]:
        step()
    found = planned(honest)
    if not report_first:
        assert found.departures == ()
        return
    (said,) = found.departures
    says(said, "again.csv", "r002", "after a report")
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r002")]) == said
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r001")]) is None
    assert found.exploratory_equivalence(POOLED) is None
    rebuild_database(honest.folder, lambda _step: None)
    assert planned(honest) == found


def test_a_log_taken_off_and_put_back_after_a_report_is_no_departure(reported: SmallBook) -> None:
    assigns(reported, "r002.csv", "none", "was it this one?")
    assigns(reported, "r002.csv", "r002")
    assert planned(reported).departures == ()
    ingests(reported, another_log(reported, "r002 again.csv"))
    (said,) = planned(reported).departures
    says(said, "r002", "again.csv")
    rebuild_database(reported.folder, lambda _step: None)
    assert planned(reported).departures == (said,)


@pytest.mark.parametrize(
    ("what", "lost"), [("r002.csv", ("r002", "r003", "apex height")), ("2021-06-14.csv#2", ("r002", "joules a jump"))]
)
def test_what_was_taken_off_a_run_and_given_to_another_is_told_once(
    honest: SmallBook, what: str, lost: tuple[str, ...]
) -> None:
    assigns(honest, what, "none", "was it this one?")
    assigns(honest, what, "r003")
    (said,) = planned(honest).departures
    says(said, "which leaves run", *lost)


AWAY = [("r003", "belongs there"), ("none", "does it?")]


WAYS: list[list[tuple[str, str | None]]] = [
    [*AWAY, ("r002", None)],
    [("r003", "belongs there"), ("r002", "no")],
    [("none", "does it?"), ("r003", None), ("r002", "no")],
    [("none", "does it?"), ("r003", None), ("none", "no"), ("r002", None)],
]


@pytest.mark.soak
def test_a_log_that_a_report_saw_at_another_run_is_told(honest: SmallBook) -> None:
    assigns(honest, "r002.csv", *AWAY[0])
    reports(honest)
    for run, why in (AWAY[1], ("r002", None)):
        assigns(honest, "r002.csv", run, why)
    (said,) = planned(honest).departures
    says(said, "r002.csv", "r003")


def test_a_log_that_replaced_another_after_a_report_makes_the_condition_exploratory(reported: SmallBook) -> None:
    ingests(reported, another_log(reported, "r002 again.csv"))
    assigns(reported, "r002.csv", "none", "the other is better")
    found = planned(reported)
    (said,) = found.departures
    says(said, "again.csv", "r002.csv")
    assert found.exploratory_equivalence(POOLED, [key_of(reported, "r002")]) == said
    assert found.exploratory_equivalence(POOLED, [key_of(reported, "r001")]) is None
    assert found.exploratory(Outcome.JOULES, POOLED) is None
    rebuild_database(reported.folder, lambda _step: None)
    assert planned(reported) == found
    assigns(reported, "r002 again.csv", "none", "it was not")
    assigns(reported, "r002.csv", "r002")
    assert not [item for item in planned(reported).further if item.quantities]


@pytest.mark.soak
def test_one_of_two_logs_taken_off_after_a_report_makes_the_condition_exploratory(honest: SmallBook) -> None:
    with honest.open() as book, book.session(ADA) as session:
        correct(book, session, "r002", ["starts=2"], "it was started again")
    ingests(honest, another_log(honest, "r002 again.csv"))
    reports(honest)
    (started,) = planned(honest).departures
    assigns(honest, "r002 again.csv", "none", "the first is better")
    found = planned(honest)
    assert found.departures[0] == started
    said = found.departures[1]
    says(said, "r002", "again.csv", "report had been")
    assert found.exploratory_equivalence(POOLED, [key_of(honest, "r002")]) == said
    assert found.exploratory_equivalence(POOLED, [key_of(honest, "r001")]) is None
    assigns(honest, "r002 again.csv", "r002")
    assert planned(honest).departures == (started,)


def test_a_charge_that_replaced_another_after_a_report_makes_the_condition_exploratory(honest: SmallBook) -> None:
    sheet = honest.instruments / "again.csv"
    sheet.write_text("run,mAh,minutes,end_voltage,pack,ended\nr002,90,10,16.80,B,2021-06-14 10:17\n")
    ingests(honest, sheet)
    reports(honest)
    assigns(honest, "2021-06-14.csv#2", "none", "read wrongly")
    assigns(honest, "again.csv#1", "r002")
    found = planned(honest)
    (said,) = found.departures
    says(said, "again.csv", "2021-06-14", "r002")
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r002")]) == said
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r001")]) is None
    assert found.exploratory_equivalence(POOLED) is None


def test_a_charge_corrected_after_a_report_is_listed_and_not_labelled(reported: SmallBook) -> None:
    with reported.open() as book, book.reading() as connection:
        query = "SELECT charge.uid FROM charge JOIN run ON charge.run = run.id WHERE run.name = 'r002'"
        uid = connection.exec_driver_sql(query).scalar_one()
    with reported.open() as book, book.session(ADA) as session:
        correct(book, session, f"charge:{uid}", ["charge_mah=90"], "typed wrongly")
    found = planned(reported)
    (said,) = found.departures
    says(said, "charge_mah", "r002")
    assert found.exploratory(Outcome.JOULES, POOLED) is None


def moves(made: SmallBook, foot: str) -> None:
    with made.open() as book, book.session(ADA) as session:
        correct(book, session, "r002", [f"foot={foot}"], "looked odd")


def test_a_run_moved_to_another_condition_after_a_report_makes_both_exploratory(honest: SmallBook) -> None:
    was = key_of(honest, "r002")
    reports(honest)
    with honest.open() as book, book.session(ADA) as session:
        correct(book, session, "r002", ["foot=large"], "looked odd")
    found = planned(honest)
    (said,) = found.departures
    corrected = "the condition of run r002 was corrected after a report had been made"
    assert said.startswith(f"{corrected}: it was {was} and is {key_of(honest, 'r002')} (Ada Nwosu, ")
    for key in (was, key_of(honest, "r002")):
        assert found.exploratory(Outcome.JOULES, POOLED, [key]) == said
        assert found.exploratory_equivalence(POOLED, [key]) == said
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r001")]) is None
    with honest.open() as book, book.session(ADA) as session:
        correct(book, session, "r002", ["foot=small"], "it was right")
    assert planned(honest).departures == ()


def test_a_run_put_on_another_day_or_pack_is_told_by_name(honest: SmallBook) -> None:
    with honest.open() as book, book.session(ADA) as session:
        correct(book, session, "r002", ["battery=C", "day=2021-06-16", "position_in_day=20"], "read again")
    told = planned(honest).departures
    says(told, "was B", "is C")
    says(told, "was 2021-06-14", "is 2021-06-16")
    assert planned(honest).exploratory(Outcome.JOULES, POOLED) is None


def test_a_second_record_of_a_plate_takes_a_number_that_a_report_showed(honest: SmallBook) -> None:
    for seed in (1, 2):
        record = plate_record(seed, 4)
        path = honest.instruments / f"r003_plate{seed}.txt"
        path.write_bytes(bertec_text(record))
        ingests(honest, path)
        with honest.open() as book:
            state_report(book, None, ADA, lambda _step: None)
    (departure,) = planned(honest).further
    assert departure.kind is DepartureKind.SURPLUS
    assert {Outcome.PEAK_FORCE, Outcome.CONTACT_TIME, Outcome.IMPULSE_HEIGHT} <= set(departure.quantities)
    assert departure.conditions == (key_of(honest, "r003"),)
    assert departure.parameters["name"] == "r003_plate2.txt"
