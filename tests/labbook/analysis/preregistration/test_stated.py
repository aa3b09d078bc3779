"""What departs from the plan stands once on the page, with all that is exploratory for it."""

from __future__ import annotations

from labbook.actions.runs.correcting import void
from labbook.actions.runs.jump_review import decide
from labbook.analysis.preregistration.planned import AS_A_WHOLE
from tests.helpers.books import ADA, SmallBook
from tests.helpers.decided import corrects, reports
from tests.helpers.wording import says


def departures(made: SmallBook, where: str | None) -> tuple[str, ...]:
    """What a report lists, once it was looked at that each departure stands in one line."""
    report = reports(made, where)
    said = report.results.plan.departures
    for departure in report.planned.departures:
        assert [departure in line for line in said].count(True) == 1
        assert "\n".join(said).count(departure) == 1
    return said


def test_a_departure_that_comparisons_share_is_told_once(honest: SmallBook) -> None:
    """Joules rest on the run that the selection leaves out; heights rest on that and on the changed rule."""
    honest.toml.write_text(honest.toml.read_text().replace("exclude_gap_jumps = true", "exclude_gap_jumps = false"))
    rule, parted = departures(honest, "run!=r002")
    assert "exclude_gap_jumps" in rule
    says(rule, "Exploratory for it: apex heights")
    says(parted, "leaves out run", "r002", "Exploratory for it: joules and apex heights")


def test_what_was_left_out_is_told_once_with_what_it_concerns(honest: SmallBook) -> None:
    with honest.open() as book, book.session(ADA) as session:
        void(session, "r006", "foot came loose")
        decide(book, session, "r004", [1], "reject", "touched_by_hand", None)
    run, jumps, whole, *_others = departures(honest, None)
    says(run, "r006", "foot came loose")
    says(jumps, "was not allowed")
    assert whole[1:] == f"{AS_A_WHOLE}."[1:]
    assert reports(honest).results.plan.departed == 2


def test_what_makes_nothing_exploratory_is_told_alone(honest: SmallBook) -> None:
    said, *_others = departures(honest, "foot=small")
    says(said, "2 conditions")
    assert "Exploratory" not in said
    corrects(honest, "r002", "jumps_made=4")
    said, *_others = departures(honest, None)
    assert said.startswith("Departure: ")
    assert "r002" in said
    assert "Exploratory" not in said


def test_that_runs_are_older_than_the_decision_is_told_once(honest: SmallBook) -> None:
    content = reports(honest).results
    told = "nothing shows that the decision was made before the data were seen"
    assert [told in line for line in (*content.plan.decided, *content.limitations)].count(True) == 1
    assert content.plan.run_before == min(day.date for day in content.days)
