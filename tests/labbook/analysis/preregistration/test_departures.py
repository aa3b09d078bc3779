"""The doors by which numbers could be chosen after they were seen: selections, corrections, late files, rules."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from labbook.actions.runs.correcting import void
from labbook.analysis.comparison.pairing import POOLED
from labbook.analysis.preregistration.departures import DepartureKind
from labbook.analysis.study import Analysis
from labbook.book.rebuilding import rebuild_database
from labbook.demo.writers import bertec_text
from tests.helpers.books import ADA, SmallBook, copy_of, ingest_all, small_book
from tests.helpers.decided import DECIDED, assigns, charge_of, corrects, decided_book, ingests, key_of, planned, reports
from tests.helpers.stated_campaign import plate_record
from tests.helpers.wording import says

Step = Callable[[SmallBook], object]
CHARGE, LOG, AGAIN = "2021-06-14.csv#2", "r002.csv", "r002 again.csv"
"""The charge and the log of r002, and a further log of it."""
OF_CONDITIONS = ("r001", "r002", "r003", "r005")
"""A run of each condition."""
ALL = " ".join(OF_CONDITIONS)
WAS, IS = (f"foot={foot} k_gain=400 b_ad_gain=100" for foot in ("small", "large"))
MOVED = f"the condition of run r002 was corrected after a report had been made: it was {WAS} and is {IS} (Ada Nwosu, "


def on_r002(*assignments: str) -> Step:
    return lambda made: corrects(made, "r002", *assignments)


def on_charge(run: str, assignment: str) -> Step:
    return lambda made: corrects(made, charge_of(made, run), assignment)


def given(what: str, run: str, *, add: bool = False) -> Step:
    return lambda made: assigns(made, what, run, add=add)


def another_log(name: str) -> Step:
    """Ingest the log of r003 less its last sample, under another name."""

    def step(made: SmallBook) -> None:
        path = made.instruments / name
        path.write_bytes(b"\n".join(made.log("r003").read_bytes().splitlines()[:-1]) + b"\n")
        ingests(made, path)

    return step


def another_charge(made: SmallBook) -> None:
    path = made.instruments / "again.csv"
    path.write_text("run,mAh,minutes,end_voltage,pack,ended\nr002,90,10,16.80,B,2021-06-14 10:17\n")
    ingests(made, path)


def rule(line: str) -> Step:
    """Let `[protocol]` have another rule."""

    def step(made: SmallBook) -> None:
        text = re.sub(rf"(?m)^{line.split(' ')[0]} = .*\n", "", made.toml.read_text())
        made.toml.write_text(text.replace("[protocol]\n", f"[protocol]\n{line}\n"))

    return step


def voided(*runs: str, reason: str = "misfire") -> Step:
    def step(made: SmallBook) -> None:
        with made.open() as book, book.session(ADA) as session:
            for run in runs:
                void(session, run, reason)

    return step


def reported_once(folder: Path) -> SmallBook:
    made = decided_book(folder)
    reports(made)
    return made


@pytest.mark.parametrize(
    ("steps", "facts", "joules", "heights"),
    [
        ([on_r002("jumps_made=0")], "jumps_made | r002 | 3 | without joules a", "r002", ""),
        ([on_r002("jumps_made=2")], "jumps_made of run r002 was 3 and is 2", "", ""),
        ([on_r002("duration_s=700")], "duration_s of run r002 was 720 and is 700", "", ""),
        ([on_r002("foot=large")], "condition of run r002 was ", "", ""),
        ([given(CHARGE, "none")], "of a charge | r002 | without joules a", "r002", ""),
        ([on_charge("r007", "run=none")], "r007 | without joules a", ALL, ""),  # an idle run's
        ([given(LOG, "none")], f"{LOG} | without apex height", "", "r002"),
        ([given(LOG, "r003")], f"{LOG} | r003 | without apex height", "", "r002 r003"),
        ([given(LOG, "none"), given(LOG, "r003")], "which leaves run | r002 | r003 | apex height", "", "r002 r003"),
        ([given(CHARGE, "none"), given(CHARGE, "r003", add=True)], "which leaves run | r002 | joules", "r002", ""),
        ([rule("exclude_first_jumps = 2")], "exclude_first_jumps of [protocol] was ", "", ALL),
        ([rule("exclude_gap_jumps = false")], "exclude_gap_jumps of [protocol] was true", "", ALL),
        ([rule('detector = "published"')], "detector of [protocol] was robust", "", ALL),
        ([another_log(AGAIN)], "r002 | again.csv | without apex height", "", "r002"),
        ([another_log(AGAIN), on_r002("starts=2")], "starts of run | r002 | 1", "", ""),
        ([another_charge, reports, given("again.csv#1", "r002", add=True)], "again.csv | after a report", "r002", ""),
        ([reports, given(LOG, "none"), given(LOG, "r002"), another_log(AGAIN)], "r002 | again.csv", "", "r002"),
        ([reports, another_log(AGAIN), given(LOG, "none")], f"again.csv | {LOG}", "", "r002"),
        ([another_charge, reports, given(CHARGE, "none"), given("again.csv#1", "r002")], "again.csv | 14", "r002", ""),
        ([reports, on_charge("r002", "charge_mah=90")], "charge_mah | r002", "", ""),
        ([reports, on_r002("foot=large")], MOVED, "r002 r005", "r002 r005"),
        ([given(LOG, "r003"), reports, given(LOG, "r002")], f"{LOG} | r003", "", ""),
        ([reports, voided("r002", "r004", "r010", "r012")], "made void (misfire) after | r002", "r002", "r002"),
    ],
)
def test_what_departs_is_told_once_and_makes_exploratory_what_rests_on_it(
    tmp_path: Path, steps: list[Step], facts: str, joules: str, heights: str
) -> None:
    seen = steps[0] is reports
    made = copy_of("decided-reported", reported_once, tmp_path) if seen else decided_book(tmp_path)
    keys = {run: key_of(made, run) for run in OF_CONDITIONS}
    for step in steps[seen:]:
        step(made)
    found = planned(made)
    (said,) = found.departures
    says(said, *facts.split(" | "))
    for run, key in keys.items():
        assert found.exploratory(Outcome.JOULES, POOLED, [key]) == (said if run in joules else None), run
        assert found.exploratory_equivalence(POOLED, [key]) == (said if run in heights else None), run
    if seen:
        rebuild_database(made.folder, lambda _step: None)
        assert planned(made) == found


@pytest.mark.parametrize(
    "steps",
    [
        [on_r002("jumps_made=0"), on_r002("jumps_made=3")],
        [given(LOG, "none"), given(LOG, "r002")],
        [rule("exclude_gap_jumps = false"), rule("exclude_gap_jumps = true")],
        [another_charge, given("again.csv#1", "r002", add=True), reports],
        [another_log("loose.csv"), given("loose.csv", "r002"), given("loose.csv", "none")],
        [reports, given(LOG, "none"), given(LOG, "r002")],
        [reports, on_r002("foot=large"), on_r002("foot=small")],
        [voided("r006")],
    ],
)
def test_what_was_taken_back_or_allowed_is_no_departure(honest: SmallBook, steps: list[Step]) -> None:
    for step in steps:
        step(honest)
    assert planned(honest).departures == ()


@pytest.mark.soak
def test_a_file_taken_off_after_a_report_saw_it_is_told(honest: SmallBook) -> None:
    on_r002("starts=2")(honest)
    another_log(AGAIN)(honest)
    reports(honest)
    (started,) = planned(honest).departures
    assigns(honest, AGAIN, "none")
    found = planned(honest)
    assert found.departures[0] == started
    says(found.departures[1], "r002", "again.csv", "report had been")
    assert found.exploratory_equivalence(POOLED, [key_of(honest, "r002")]) == found.departures[1]
    assert found.exploratory_equivalence(POOLED, [key_of(honest, "r001")]) is None
    assigns(honest, AGAIN, "r002")
    assert planned(honest).departures == (started,)


def test_a_correction_is_not_blamed_for_what_another_took(honest: SmallBook) -> None:
    on_r002("jumps_made=2")(honest)
    on_charge("r002", "run=none")(honest)
    told, blamed = planned(honest).departures
    assert "jumps_made" in told
    assert "which leaves" not in told
    says(blamed, "r002", "without joules a")


def test_a_run_made_idle_is_taken_out_of_its_condition(honest: SmallBook) -> None:
    key = key_of(honest, "r002")
    on_r002("kind=idle", "jumps_made=0", "levels=none")(honest)
    found = planned(honest)
    told = {said.split(": ")[1].split(" of ")[0]: "which leaves" in said for said in found.departures}
    assert told == {"kind": True, "condition": False, "jumps_made": True}
    says(str(found.exploratory(Outcome.JOULES, POOLED, [key])), "r002", "without joules a")
    assert found.exploratory_equivalence(POOLED, [key]) is not None


def test_a_run_put_on_another_day_or_pack_is_told_by_name(honest: SmallBook) -> None:
    on_r002("battery=C", "day=2021-06-16", "position_in_day=20")(honest)
    found = planned(honest)
    says(found.departures, "was B", "is C")
    says(found.departures, "was 2021-06-14", "is 2021-06-16")
    assert found.exploratory(Outcome.JOULES, POOLED) is None


def test_other_rules_of_single_jumps_make_their_heights_exploratory(honest: SmallBook) -> None:
    rule('take_off = "20_percent"')(honest)
    found = planned(honest)
    (departure,) = found.further
    says(departure.sentence, "take_off", "flight_5sd", "20_percent", Outcome.FLIGHT_HEIGHT.plural)
    assert departure.touches(Outcome.IMPULSE_HEIGHT, None)
    assert found.exploratory(Outcome.JOULES, POOLED) is None
    assert found.exploratory_equivalence(POOLED) is None


def test_a_second_record_of_a_plate_takes_a_number_that_a_report_showed(honest: SmallBook) -> None:
    for seed in (1, 2):
        path = honest.instruments / f"r003_plate{seed}.txt"
        path.write_bytes(bertec_text(plate_record(seed, 4)))
        ingests(honest, path)
        reports(honest)
    (departure,) = planned(honest).further
    assert departure.kind is DepartureKind.SURPLUS
    assert {Outcome.PEAK_FORCE, Outcome.CONTACT_TIME, Outcome.IMPULSE_HEIGHT} <= set(departure.quantities)
    assert departure.conditions == (key_of(honest, "r003"),)
    assert departure.parameters["name"] == "r003_plate2.txt"


def test_what_was_corrected_before_the_first_measurement_is_no_departure(tmp_path: Path) -> None:
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text() + DECIDED)
    on_r002("jumps_made=2")(made)
    with made.open() as book:
        ingest_all(book, made.instruments)
    assert planned(made).departures == ()


# --- selections


def of_joules(report: Analysis) -> list[str]:
    """Why each of a report's pooled comparisons of joules is exploratory."""
    shown = report.results.comparisons
    return [each.exploratory for each in shown if (each.quantity, each.family) == (Outcome.JOULES, POOLED)]


def test_conditions_left_out_whole_are_told_and_make_nothing_else_exploratory(honest: SmallBook) -> None:
    for where, left, why in (("foot=small", "2 conditions", [""]), ("foot=small and b_ad_gain=0", "3 conditions", [])):
        report = reports(honest, where)
        (said,) = report.planned.departures
        says(said, left, "whole", "whose comparisons belong")
        assert of_joules(report) == why
    assert planned(honest).departures == ()


@pytest.mark.soak
def test_levels_left_out_of_a_group_make_its_comparisons_exploratory(tmp_path: Path) -> None:
    """A third level that the selection leaves out, with one of the two others."""
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text().replace("levels = [0, 100]", "levels = [0, 100, 200]") + DECIDED)
    corrects(made, "r004", "b_ad_gain=200")
    with made.open() as book:
        ingest_all(book, made.instruments)
    report = reports(made, "foot=small and b_ad_gain<200 or foot=large")
    found = report.planned
    (said,) = found.departures
    says(said, "1 condition", key_of(made, "r004"))
    for run, why in (("r001", said), ("r002", said), ("r003", None)):
        assert found.exploratory(Outcome.JOULES, POOLED, [key_of(made, run)]) == why
        assert found.exploratory_equivalence(POOLED, [key_of(made, run)]) == why
    assert said in [each.exploratory for each in report.results.comparisons]


def test_a_selection_of_some_runs_of_a_condition_makes_what_rests_on_it_exploratory(honest: SmallBook) -> None:
    report = reports(honest, "foot=small and run!=r002")
    found = report.planned
    said, whole = found.departures
    says(whole, "whose comparisons belong")
    key = key_of(honest, "r002")
    says(said, "selection leaves out", "r002", key, "takes its other")
    assert found.exploratory(Outcome.JOULES, POOLED, [key]) == said
    assert found.exploratory(Outcome.JOULES, POOLED, [key_of(honest, "r001")]) is None
    assert found.exploratory_equivalence(POOLED, [key]) == said
    assert of_joules(report) == [said]
