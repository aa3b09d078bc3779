"""What a user is told about deciding on the analysis: before anything is measured, and after."""

from __future__ import annotations

from pathlib import Path

from labbook.analysis.preregistration.planned import AS_A_WHOLE
from tests.cli.shell import good, labbook
from tests.helpers.attention import told
from tests.helpers.books import SmallBook, small_book
from tests.helpers.wording import says

EXAMPLE = '\n[analysis]\nprimary_outcome = "joules"\nalpha = 0.05\napex_bounds_percent = [-3, 3]\n'


def test_today_says_that_nothing_is_decided_until_it_is_or_it_is_too_late(stated: SmallBook) -> None:
    undecided = "analysis_undecided"
    assert undecided in told(stated.folder, "today")
    assert "yet: write [analysis]" in good(labbook("analysis", at=stated.folder)).out
    plain = stated.toml.read_text()
    stated.toml.write_text(plain + EXAMPLE)
    assert undecided not in told(stated.folder, "today")
    says(good(labbook("analysis", at=stated.folder)).out, "book takes over")
    stated.toml.write_text(plain)
    good(labbook("ingest", stated.log("r001"), at=stated.folder))
    assert undecided not in told(stated.folder, "today")
    (line,) = good(labbook("analysis", at=stated.folder)).out.splitlines()
    says(line, "comparison is exploratory")


def decided(folder: Path, *, two_people: bool = False) -> SmallBook:
    made = small_book(folder, ingested=False, two_people=two_people)
    made.toml.write_text(made.toml.read_text() + EXAMPLE)
    return made


def test_what_was_decided_is_shown_with_its_day_and_its_departures(tmp_path: Path) -> None:
    made = decided(tmp_path, two_people=True)
    good(labbook("charge", "r001", "120", "--as", "BO", at=made.folder))
    line, made_before, *_not_watched = good(labbook("analysis", at=made.folder)).out.splitlines()
    says(line, "Decided on 20", "before the first", "outcome is joules", "-3", "3 %", "count as none")
    says(made_before, "run is dated", "2021")
    made.toml.write_text(made.toml.read_text().replace("0.05\n", "0.1\n"))
    good(labbook("note", "r001", "heard", "--as", "AN", at=made.folder))
    again, _, departure, *_not_watched = good(labbook("analysis", at=made.folder)).out.splitlines()
    assert again == line
    says(departure, "[analysis]", "0.05 before", "0.1", "labbook.toml", "stated before stands")


def test_leaving_out_for_a_reason_that_was_not_allowed_is_remarked_on(tmp_path: Path) -> None:
    made = decided(tmp_path)
    made.toml.write_text(made.toml.read_text() + 'exclusions = ["misfire", "sensor_fault"]\n')
    good(labbook("ingest", made.log("r001"), at=made.folder))

    def told(*words: str) -> str:
        return good(labbook(*words, at=made.folder)).out

    remark = "look again: [analysis] allows misfire, sensor_fault, so the report calls every comparison"
    says(told("jumps", "reject", "r001", "1", "--reason", "wrong_apex"), remark, "wrong_apex", AS_A_WHOLE)
    assert remark not in told("jumps", "reject", "r001", "1", "--reason", "misfire")
    assert remark not in told("jumps", "clear", "r001", "1")
    loose = told("void", "r001", "--reason", "foot came loose")
    says(loose, remark, "exploratory (foot came", AS_A_WHOLE, "`labbook void r001 --undo --reason ...`")
    again = told("void", "r001", "--reason", "sensor fault: no string")
    says(again, "r001 is void already", "`labbook void r001 --undo --reason ...`")
    assert "look again" not in again  # the reason was not recorded
    assert remark not in told("void", "r001", "--undo", "--reason", "it was r002")
    assert remark not in told("void", "r001", "--reason", "sensor fault: no string")
    assert "Departure" not in told("analysis")


def test_what_one_folder_brings_together_blames_neither_of_two_logs(tmp_path: Path) -> None:
    made = decided(tmp_path)
    late = made.folder / "r001_late.csv"
    for run, path in (("r002", made.log("r002").with_name("r002_again.csv")), ("r001", late)):
        path.write_bytes(b"\n".join(made.log(run).read_bytes().splitlines()[:-1]) + b"\n")
    good(labbook("ingest", made.log("r002").parent, at=made.folder))
    assert "Departure" not in good(labbook("analysis", at=made.folder)).out
    good(labbook("ingest", late, at=made.folder))
    says(good(labbook("analysis", at=made.folder)).out, "Departure", "r001_late.csv")
