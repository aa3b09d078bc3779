"""What a user is told about deciding on the analysis: before anything is measured, and after."""

from __future__ import annotations

from pathlib import Path

from labbook.analysis.preregistration.planned import AS_A_WHOLE
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, small_book
from tests.helpers.wording import says

EXAMPLE = '\n[analysis]\nprimary_outcome = "joules"\nalpha = 0.05\napex_bounds_percent = [-3, 3]\n'


def test_a_new_book_is_asked_to_decide_in_time(tmp_path: Path) -> None:
    said = good(labbook("init", "new", "--as", "Ada Nwosu", at=tmp_path)).out
    says(said, "[analysis]")


def test_today_says_that_nothing_is_decided_until_it_is_or_it_is_too_late(stated: SmallBook) -> None:
    undecided = "nothing is decided about the analysis: write [analysis] in labbook.toml"
    assert undecided in good(labbook("today", at=stated.folder)).out
    assert "yet: write [analysis]" in good(labbook("analysis", at=stated.folder)).out
    plain = stated.toml.read_text()
    stated.toml.write_text(plain + EXAMPLE)
    assert undecided not in good(labbook("today", at=stated.folder)).out
    says(good(labbook("analysis", at=stated.folder)).out, "book takes over")
    stated.toml.write_text(plain)
    good(labbook("ingest", stated.log("r001"), at=stated.folder))
    assert undecided not in good(labbook("today", at=stated.folder)).out
    (line,) = good(labbook("analysis", at=stated.folder)).out.splitlines()
    says(line, "comparison is exploratory")


def test_what_was_decided_is_shown_with_its_day_and_its_departures(tmp_path: Path) -> None:
    made = small_book(tmp_path, ingested=False, two_people=True)
    made.toml.write_text(made.toml.read_text() + EXAMPLE)
    good(labbook("charge", "r001", "120", "--as", "BO", at=made.folder))
    line, made_before, not_watched = good(labbook("analysis", at=made.folder)).out.splitlines()
    for words in (
        "Not watched: runs never made or never entered, whether a value was corrected to please ",
        ", the study, the rest of labbook.toml ",
        ", and what was looked at without a report; ",
    ):
        assert words in not_watched
    assert line.startswith("Decided on 20")
    says(made_before, "run is dated", "2021")
    says(line, "before the first", "outcome is joules", "-3", "3 %", "count as none")
    made.toml.write_text(made.toml.read_text().replace("0.05\n", "0.1\n"))
    good(labbook("note", "r001", "heard", "--as", "AN", at=made.folder))
    decided, _, departure, _not_watched = good(labbook("analysis", at=made.folder)).out.splitlines()
    assert decided == line
    says(departure, "[analysis]", "0.05 before", "0.1", "labbook.toml", "stated before stands")


def test_leaving_out_for_a_reason_that_was_not_allowed_is_remarked_on(tmp_path: Path) -> None:
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text() + EXAMPLE + 'exclusions = ["misfire", "sensor_fault"]\n')
    good(labbook("ingest", made.log("r001"), at=made.folder))
    remark = "look again: [analysis] allows misfire, sensor_fault, so the report calls every comparison"
    said = good(labbook("jumps", "reject", "r001", "1", "--reason", "wrong_apex", at=made.folder)).out
    says(said, remark, "wrong_apex", AS_A_WHOLE)
    assert remark not in good(labbook("jumps", "reject", "r001", "1", "--reason", "misfire", at=made.folder)).out
    assert remark not in good(labbook("jumps", "clear", "r001", "1", at=made.folder)).out
    said = good(labbook("void", "r001", "--reason", "foot came loose", at=made.folder)).out
    says(said, remark, "exploratory (foot came", AS_A_WHOLE, "`labbook void r001 --undo --reason ...`")
    again = good(labbook("void", "r001", "--reason", "sensor fault: no string", at=made.folder)).out
    says(again, "r001 is void already", "`labbook void r001 --undo --reason ...`")
    assert "look again" not in again  # the reason was not recorded
    assert remark not in good(labbook("void", "r001", "--undo", "--reason", "it was r002", at=made.folder)).out
    assert remark not in good(labbook("void", "r001", "--reason", "sensor fault: no string", at=made.folder)).out
    assert "Departure" not in good(labbook("analysis", at=made.folder)).out


def test_what_one_folder_brings_together_blames_neither_of_two_logs(tmp_path: Path) -> None:
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text() + EXAMPLE)
    log = made.log("r002")
    again = log.with_name("r002_again.csv")
    again.write_bytes(b"\n".join(log.read_bytes().splitlines()[:-1]) + b"\n")
    late = made.folder / "r001_late.csv"
    late.write_bytes(b"\n".join(made.log("r001").read_bytes().splitlines()[:-1]) + b"\n")
    good(labbook("ingest", log.parent, at=made.folder))
    assert "Departure" not in good(labbook("analysis", at=made.folder)).out
    good(labbook("ingest", late, at=made.folder))
    (said,) = [line for line in good(labbook("analysis", at=made.folder)).out.splitlines() if "Departure" in line]
    says(said, "r001_late.csv")


def test_a_correction_that_takes_a_run_out_is_told_and_named(tmp_path: Path) -> None:
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text() + EXAMPLE)
    good(labbook("charge", "r002", "120", at=made.folder))
    assert "Departure" not in good(labbook("analysis", at=made.folder)).out
    good(labbook("correct", "r002", "jumps_made=0", "--why", "looks odd", at=made.folder))
    _decided, _made_before, departure, _not_watched = good(labbook("analysis", at=made.folder)).out.splitlines()
    says(departure, "jumps_made", "r002", "3", "without joules a")
