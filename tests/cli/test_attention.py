"""What needs attention: every fault that is planted is found, and the command given with it mends it."""

from __future__ import annotations

import random
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from data_schema.journal import Entry
from data_schema.outcomes import Outcome
from data_schema.vocabulary import Action, Rule
from labbook.actions.runs.attention import CHECKS, Gravity
from labbook.book.write_session import Statement, new_uid
from reports.results import POOLED, Decision
from tests.cli.shell import good, labbook, refused
from tests.cli.test_calibrated_logs import AT_0_2_M, DAYS, PROFILE, counted
from tests.cli.test_calibrated_logs import book as calibrated_book
from tests.cli.test_log_dates import dated_log
from tests.cli.test_plan_and_runs import PLAN, table, write
from tests.helpers.attention import told
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.charged_book import Made, charged_book
from tests.helpers.decided import reports
from tests.helpers.hopping_log import RATE_HZ, apex_s, hopping_log
from tests.helpers.standing_log import as_csv, standing_log
from tests.helpers.upkeep import rebuilt_as_said
from tests.helpers.wording import says

WHY = ("--why", "for this test")


@dataclass(frozen=True, slots=True)
class Place:
    """A book that a fault is planted in, and a folder for files."""

    book: SmallBook
    folder: Path

    def say(self, *words: str | Path) -> str:
        return good(labbook(*words, at=self.book.folder)).out

    def correct(self, run: str, *changes: str) -> None:
        self.say("correct", run, *changes, *WHY)

    def file(self, name: str, content: str | bytes) -> Path:
        path = self.folder / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    def log_instead(self, name: str, content: str | bytes, *declared: str) -> None:
        """Take the log of r001 out of use, and another in."""
        self.say("files", "withdraw", "r001.csv", *WHY)
        self.say("ingest", self.file(name, content), "--run", "r001", *declared)

    def sheet(self, **cells: str) -> Path:
        """A run sheet with one more run, r017, some of whose cells are others."""
        (first, *_others) = table(self.book.instruments / "runs.csv")
        line = {**first, "run": "r017", "date": "2021-06-16", "position": "9", "started": "14:00", "note": "", **cells}
        return write(self.folder / "more.csv", [line])


def shorter(log: Path) -> bytes:
    """A log without its last row: other bytes and samples, the same jumps."""
    return b"".join(log.read_bytes().splitlines(keepends=True)[:-1])


def heights(log: Path, name: str, scale: float = 1.0) -> str:
    """The times and heights of a log alone, the column of these called `name`."""
    rows = [line.split(",")[:2] for line in log.read_text().splitlines()[1:]]
    return f"time [ms],{name}\n" + "".join(f"{time},{scale * float(height):.4f}\n" for time, height in rows)


def samples_twice(place: Place) -> None:
    again = place.book.log("r002").read_bytes().replace(b"\n", b"\r\n")
    place.say("ingest", place.file("r002 (2).csv", again), "--run", "r002")


def high_zero(place: Place) -> None:
    time_s, height_m, _apexes_m = standing_log(1, 3, zero_m=0.08)
    place.log_instead("high.csv", as_csv("t [ms],h", time_s, 100 * height_m, 3), "--column", "h=body_height:cm")


def two_idle_runs_left(place: Place) -> None:
    place.say("assign", "2021-06-14.csv#8", "none", *WHY)
    place.say("assign", "2021-06-14.csv#7", "none", *WHY)


def second_charge(place: Place) -> None:
    """No statement gives a run a second charge that counts; the report would have no joules of it all the same."""
    with place.book.open() as book, book.engine.begin() as connection:
        of = "(SELECT id FROM run WHERE name = '{}')"
        connection.execute(sa.text(f"UPDATE charge SET run = {of.format('r001')} WHERE run = {of.format('r002')}"))


def jumps_beside_gaps(place: Place) -> None:
    lost = [(apex_s(number) - 0.03, apex_s(number) + 0.03) for number in (1, 2, 3)]
    place.log_instead("gaps.csv", hopping_log(3, lost_s=lost))


def caught_jump(place: Place) -> None:
    """After the apex of its second jump the robot is held for a moment."""
    head, *rows = hopping_log(3).decode().splitlines()
    first = round((apex_s(2) + 0.035) * RATE_HZ)
    held = rows[first].split(",")[1]
    for place_of in range(first, first + round(0.05 * RATE_HZ)):
        time, _height, volts = rows[place_of].split(",")
        rows[place_of] = f"{time},{float(held):.6f},{volts}"
    place.log_instead("caught.csv", "\n".join([head, *rows, ""]))


def file_waits(place: Place) -> None:
    def said(entry: Entry) -> Entry:
        new = dict(entry.new or {})
        if entry.action is not Action.INGEST or new["original_name"] != "r001.csv":
            return entry
        declared = {**new["settings"]["declared"], "format": "of_a_plugin"}
        return replace(entry, new={**new, "settings": {**new["settings"], "declared": declared}})

    rebuilt_as_said(place.book, said)


def log_lost(place: Place) -> None:
    place.say("files", "withdraw", "r001.csv", *WHY)
    place.file("again.csv", shorter(place.book.log("r001")))


def second_log(place: Place) -> None:
    place.say("ingest", place.file("two.csv", shorter(place.book.log("r003"))), "--run", "r001")


def run_left_open(place: Place) -> None:
    place.say("runs", "import", place.sheet(duration_s=""))
    place.sheet()


def second_sheet(place: Place) -> None:
    place.say("ingest", place.file("again.csv", "run,mAh,pack\nr001,119,A\n"))


def odd_limits(place: Place) -> None:
    for run in ("r003", "r004", "r005"):
        place.correct(run, "foot=small", "b_ad_gain=0")
    place.correct("r014", "mah=600")


def verdict_on_no_jump(place: Place) -> None:
    with place.book.open() as book, book.session(ADA) as session:
        run, sha256 = session.connection.execute(
            sa.text(
                "SELECT run.uid, signal.sha256 FROM run JOIN run_file ON run_file.run = run.id "
                "JOIN signal ON signal.file = run_file.file WHERE run.name = 'r001'"
            )
        ).one()
        new = {
            "target_kind": "jump", "target_uid": run, "signal_sha256": sha256, "anchor_s": 1e6, "verdict": "reject",
            "reason_code": "other", "note": None, "old_value": None, "algorithm": None, "version": None, "blind": 0,
        }  # fmt: skip
        session.state(Statement(Action.EXCLUDE, "decision", new_uid(), new=new))


def refused_file(place: Place) -> None:
    place.say("files", "withdraw", "r001.csv", *WHY)
    log = place.file("r001b.csv", "time [ms],height\n")
    assert labbook("ingest", log, "--run", "r001", at=place.book.folder).code == 2
    place.file("r001b.csv", shorter(place.book.log("r001")))


def log_of_no_run(place: Place) -> None:
    place.say("files", "withdraw", "r001.csv", *WHY)
    place.say("ingest", place.file("LOG0007.csv", shorter(place.book.log("r001"))))


def planned(place: Place) -> None:
    place.say(*PLAN, "--no-idle")
    lines = table(place.book.folder / "runs.csv")
    for position, line in enumerate(lines):
        minutes = 30 + 25 * position
        line.update(started=f"{9 + minutes // 60}:{minutes % 60:02d}", battery="A", jumps_made="25", duration_s="720")
    write(place.book.folder / "filled.csv", lines)


def undecided(place: Place) -> None:
    """A person follows the sentence before the command."""


def of_calibrated(place: Place) -> None:
    log, _mean_m = counted(place.folder, 1, AT_0_2_M[DAYS[0]])
    place.say("ingest", log)


def calibration_of_other_day(place: Place) -> None:
    of_calibrated(place)
    place.correct("r001", f"date={DAYS[1]}")


def outdated(place: Place) -> None:
    of_calibrated(place)
    place.book.rewrite('"ruler, page 12"', '"ruler, page 13"')


@dataclass(frozen=True, slots=True)
class Fault:
    """How a fault comes into a book, and what a person fills into the command given."""

    plant: Callable[[Place], object]
    fill: Mapping[str, str] = field(default_factory=dict)
    about: str | None = "r001"
    """The run that is named."""
    then: str = ""
    """What a person says after a command that shows something."""


def corrected(run: str, *changes: str) -> Callable[[Place], object]:
    return lambda place: place.correct(run, *changes)


def log_of_day(date: str) -> Callable[[Place], object]:
    return lambda place: place.say("ingest", dated_log(place.folder, "dated.csv", date), "--run", "r001")


FAULTS: Mapping[str, Fault] = {
    "charge_below_drain": Fault(corrected("r001", "mah=10"), {"MAH": "112"}),
    "charge_above_pack": Fault(corrected("r001", "mah=9000"), {"MAH": "112"}),
    "charge_zero": Fault(corrected("r007", "mah=0"), {"MAH": "142"}, "r007"),
    "samples_twice": Fault(samples_twice, {}, "r002"),
    "level_differs": Fault(corrected("r001", "b_ad_gain=100")),
    "zero_doubtful": Fault(high_zero),
    "no_drain_line": Fault(two_idle_runs_left, {"MAH": "142"}, None),
    "charge_missing": Fault(lambda place: place.say("assign", "2021-06-14.csv#1", "none", *WHY), {"MAH": "112"}),
    "charges_several": Fault(second_charge),
    "log_missing": Fault(
        lambda place: (
            (
                place.say("files", "withdraw", "r001.csv", *WHY),
                place.file("again.csv", shorter(place.book.log("r001"))),
            )
        ),
        {"FILE": "again.csv"},
    ),
    "logs_too_many": Fault(second_log),
    "log_without_height": Fault(
        lambda place: place.log_instead("pot.csv", heights(place.book.log("r001"), "pot")),
        {"COLUMN": "pot", "UNIT": "m"},
    ),
    "no_jump_found": Fault(
        lambda place: place.log_instead(
            "cm.csv", heights(place.book.log("r001"), "z", 100.0), "--column", "z=body_height:mm"
        ),
        {"UNIT": "cm"},
    ),
    "no_jump_counts": Fault(jumps_beside_gaps),
    "calibration_of_other_day": Fault(calibration_of_other_day),
    "file_waits": Fault(file_waits),
    "run_open": Fault(run_left_open, {"FILE": "more.csv"}, "r017"),
    "log_day_differs": Fault(log_of_day("2021-07-14")),
    "charge_date": Fault(corrected("r001", "date=2021-05-14")),
    "date_in_future": Fault(corrected("r001", "date=2098-06-14"), {"DATE": "2021-06-14"}),
    "date_long_ago": Fault(corrected("r001", "date=2019-06-14"), {"DATE": "2021-06-14"}),
    "outside_limits": Fault(odd_limits, {"MAH": "110"}, "r014"),
    "charge_waits": Fault(second_sheet),
    "pack_differs": Fault(corrected("r001", "battery=B"), {"PACK": "A"}),
    "jumps_differ": Fault(corrected("r001", "jumps_made=10"), {"JUMPS": "3"}),
    "jumps_unusual": Fault(corrected("r001", "jumps_made=0"), {"JUMPS": "3"}),
    "duration_unusual": Fault(corrected("r001", "minutes=120"), {"MINUTES": "12"}),
    "verdict_waits": Fault(verdict_on_no_jump),
    "jumps_doubtful": Fault(caught_jump, then="jumps reject r001 2 --reason touched_by_hand"),
    "file_outdated": Fault(outdated, {}, None),
    "file_refused": Fault(refused_file, {"FILE": "r001b.csv"}, None),
    "inbox": Fault(log_of_no_run, {"RUN": "r001"}, None),
    "check_not_made": Fault(lambda place: None, {}, None),
    "planned_not_made": Fault(planned, {"FILE": "filled.csv"}, "r001"),
    "analysis_undecided": Fault(undecided, {}, None),
}


def test_every_check_has_a_fault_that_it_finds() -> None:
    assert FAULTS.keys() == CHECKS.keys()


def place_for(code: str, folder: Path) -> Place:
    """A book that the fault of a check can be planted in."""
    if FAULTS[code].plant in (calibration_of_other_day, outdated):
        book = SmallBook(calibrated_book(folder, PROFILE), folder)
    else:
        new = code in ("analysis_undecided", "planned_not_made")
        book = small_book(folder, runs=not new, ingested=not new)
    return Place(book, book.folder)


@pytest.mark.parametrize("code", FAULTS)
def test_a_fault_is_found_and_mended_by_the_command_that_is_given(code: str, tmp_path: Path) -> None:
    fault, place = FAULTS[code], place_for(code, tmp_path)
    book = place.book
    before = told(book.folder)
    fault.plant(place)
    after = told(book.folder)
    found = next(one for one in after[code] if fault.about in (None, one["run"]))
    assert code in ("check_not_made", "analysis_undecided") or code not in before
    assert set(found["fill_in"]) == set(fault.fill) | ({"WHY"} if "WHY" in found["command"] else set())
    words = shlex.split(found["command"])
    for blank, value in {**fault.fill, "WHY": "for this test"}.items():
        words = [word.replace(blank, value) for word in words]
    if code == "analysis_undecided":
        book.toml.write_text(book.toml.read_text() + '\n[analysis]\nprimary_outcome = "joules"\n')
    good(labbook(*words[1:], at=book.folder))
    if fault.then:
        place.say(*fault.then.split())
    identity = ("day", "run", "file")
    left = [[one[name] for name in identity] for one in told(book.folder).get(code, [])]
    assert [found[name] for name in identity] not in left


def carried_out(place: Place, finding: Mapping[str, Any]) -> str:
    return place.say(*shlex.split(finding["command"])[1:])


@pytest.mark.parametrize("said", ["accept r001 2", "reject r001 2 --reason touched_by_hand"])
def test_a_doubtful_jump_is_shown_and_nothing_said_of_it(said: str, tmp_path: Path) -> None:
    """Pasted, the command given accepted it unseen."""
    place = Place(small_book(tmp_path), tmp_path)
    caught_jump(place)
    (found,) = told(place.book.folder)["jumps_doubtful"]
    says(carried_out(place, found), "r001  2", "parabola")
    assert told(place.book.folder)["jumps_doubtful"] == [found]
    place.say("jumps", *said.split())
    assert "jumps_doubtful" not in told(place.book.folder)


def differing(place: Place, *said: str) -> dict[str, Any] | None:
    """What is found of the jumps of r001 against those made, after something more is said of them."""
    if said:
        place.say("jumps", *said)
    found = told(place.book.folder).get("jumps_differ", [])
    return next((one for one in found if one["run"] == "r001"), None)


def test_a_jump_that_is_rejected_is_not_one_too_many(tmp_path: Path) -> None:
    """Only a false count of the jumps made had cleared it."""
    place = Place(small_book(tmp_path), tmp_path)
    place.correct("r001", "jumps=2")
    found = differing(place)
    assert found is not None
    assert found["fill_in"] == ["JUMPS", "WHY"]
    says(found["what"], "3 jumps are found", "1 too many")
    assert differing(place, "reject", "r001", "2", "--reason", "other") is None
    assert differing(place, "reject", "r001", "1", "--reason", "sensor_fault") is None  # it was made all the same
    found = differing(place, "clear", "r001", "1-2")
    assert found is not None


def test_a_jump_that_is_added_is_one_more(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path, ingested=False), tmp_path)
    place.say("ingest", place.file("r001.csv", hopping_log(3, shallow=[2])))
    assert differing(place) is None
    place.correct("r001", "jumps=2")
    assert differing(place) is None
    found = differing(place, "add", "r001", "--at", f"{apex_s(2):.3f}")
    assert found is not None
    says(found["what"], "3 jumps are found", "1 too many")
    assert differing(place, "reject", "r001", "2", "--reason", "other") is None


def test_of_too_many_jumps_the_doubtful_are_looked_at_first(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    caught_jump(place)
    place.correct("r001", "jumps=2")
    found = differing(place)
    assert found is not None
    assert found["fill_in"] == []
    says(found["what"], "1 too many", "jump 2")
    says(carried_out(place, found), "r001  2")
    assert differing(place) == found
    found = differing(place, "accept", "r001", "2")
    assert found is not None
    assert found["fill_in"] == ["JUMPS", "WHY"]
    assert differing(place, "reject", "r001", "2", "--reason", "touched_by_hand") is None


def test_a_run_dated_in_another_month_is_found_without_its_day(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    place.correct("r001", "date=2021-05-14")
    assert "charge_date" not in told(place.book.folder, "today", "--day", "2021-06-14")
    (found,) = told(place.book.folder)["charge_date"]
    assert (found["run"], found["day"]) == ("r001", "2021-05-14")
    assert "charge_date" in told(place.book.folder, "attention", "--day", "2021-05-14")


def test_a_run_that_gets_another_date_gets_a_position_there_that_is_free(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    place.correct("r001", "date=2021-05-14")
    place.correct("r002", "position=1")
    (found,) = told(place.book.folder)["charge_date"]
    place.say(*(word.replace("WHY", "misread") for word in shlex.split(found["command"])[1:]))
    assert "charge_date" not in told(place.book.folder)


def test_a_spike_in_a_gain_is_no_level(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path, ingested=False), tmp_path)
    for run in ("r001", "r002", "r004", "r005", "r006"):
        spikes = iter([1e6]) if run in ("r001", "r004") else iter(())
        text = with_gains(place.book.log(run), lambda gain, spikes=spikes: next(spikes, gain))  # type: ignore[misc]
        place.say("ingest", place.file(f"{run}.csv", text))
    assert "level_differs" not in told(place.book.folder)


def exchanged_logs(place: Place, one: str, other: str) -> None:
    place.say("assign", f"{one}.csv", other, *WHY)
    place.say("assign", f"{other}.csv", one, *WHY)


def test_exchanged_logs_are_found_by_the_gain_that_they_recorded_and_given_back(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    before = told(place.book.folder)
    assert "level_differs" not in before
    exchanged_logs(place, "r001", "r002")
    found = told(place.book.folder)["level_differs"]
    assert [(one["run"], one["file"], one["gravity"]) for one in found] == [
        ("r001", "r002.csv", "wrong"),
        ("r002", "r001.csv", "wrong"),
    ]
    for _half in found:
        first = told(place.book.folder)["level_differs"][0]
        place.say(*(word.replace("WHY", "exchanged") for word in shlex.split(first["command"])[1:]))
    assert told(place.book.folder) == before


def test_two_exchanges_and_one_in_a_small_book_are_found(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path / "two"), tmp_path)
    exchanged_logs(place, "r001", "r002")
    exchanged_logs(place, "r003", "r005")
    found = told(place.book.folder)["level_differs"]
    assert {(one["run"], one["command"].split()[3]) for one in found} == {
        ("r001", "r002"), ("r002", "r001"), ("r003", "r005"), ("r005", "r003"),
    }  # fmt: skip
    small = Place(small_book(tmp_path / "small", ingested=False), tmp_path)
    for run in ("r001", "r002", "r003", "r004"):
        small.say("ingest", small.book.log(run))
    exchanged_logs(small, "r001", "r002")
    assert len(told(small.book.folder)["level_differs"]) == 2


def test_no_level_is_corrected_where_the_other_log_says_nothing(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path, ingested=False), tmp_path)
    for number in (*range(1, 7), *range(9, 15)):
        run = f"r{number:03d}"
        spikes = iter([1e6]) if run == "r002" else iter(())
        text = with_gains(place.book.log(run), lambda gain, spikes=spikes: next(spikes, gain))  # type: ignore[misc]
        place.say("ingest", place.file(f"{run}.csv", text))
    exchanged_logs(place, "r001", "r002")
    (found,) = told(place.book.folder)["level_differs"]
    assert found["command"].split()[:4] == ["labbook", "assign", "r001.csv", "r001"]


def test_a_refused_file_is_forgotten_when_its_run_has_another(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    place.say("files", "withdraw", "r001.csv", *WHY)
    place.say("assign", "2021-06-14.csv#1", "none", *WHY)
    broken = place.file("r001.csv", "time [ms],height\n")
    assert labbook("ingest", broken, at=place.book.folder).code == 2
    assert [one["run"] for one in told(place.book.folder)["file_refused"]] == ["r001"]
    place.say("ingest", place.file("good.csv", shorter(place.book.log("r001"))), "--run", "r001")
    assert "file_refused" not in told(place.book.folder)


def test_the_log_that_is_too_many_is_the_one_of_another_level(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    place.say("ingest", place.file("copy.csv", shorter(place.book.log("r002"))), "--run", "r001")
    found = told(place.book.folder)
    (wrong,), (several,) = found["level_differs"], found["logs_too_many"]
    assert (wrong["file"], wrong["fill_in"], several["file"]) == ("copy.csv", ["RUN", "WHY"], "copy.csv")


def with_gains(log: Path, say: Callable[[float], float]) -> str:
    """A log whose active-damping gain was logged otherwise."""
    head, *rows = log.read_text().splitlines()
    place = head.split(",").index("b_ad_gain")
    cells = [row.split(",") for row in rows]
    return "\n".join(
        [head, *(",".join([*row[:place], f"{say(float(row[place])):.4f}", *row[place + 1 :]]) for row in cells), ""]
    )


@pytest.mark.parametrize(
    ("say", "found"),
    [(lambda gain: gain + random.gauss(0, 0.5), True), (lambda gain: gain / 1000, False), (lambda _gain: 0.0, False)],
    ids=["noisy", "in another unit", "not logged"],
)
def test_of_a_gain_logged_otherwise_only_what_is_sure_is_said(
    say: Callable[[float], float], found: bool, tmp_path: Path
) -> None:
    place = Place(small_book(tmp_path, ingested=False), tmp_path)
    for number in (*range(1, 7), *range(9, 15)):
        run = f"r{number:03d}"
        place.say("ingest", place.file(f"{run}.csv", with_gains(place.book.log(run), say)))
    assert "level_differs" not in told(place.book.folder)
    exchanged_logs(place, "r001", "r002")
    assert ("level_differs" in told(place.book.folder)) is found


def test_a_log_of_another_run_is_told_when_it_is_taken_in(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    place.say("files", "withdraw", "r001.csv", *WHY)
    said = place.say("ingest", place.file("new.csv", shorter(place.book.log("r002"))), "--run", "r001")
    says(said, "new.csv", "b_ad_gain 100", "r001")


def test_a_channel_in_another_unit_contradicts_no_level(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path, ingested=False), tmp_path)
    for run in ("r001", "r002", "r004"):
        head, *rows = place.book.log(run).read_text().splitlines()
        column = head.split(",").index("k_gain")
        cells = [row.split(",") for row in rows]
        of_percent = [",".join([*row[:column], "7.5", *row[column + 1 :]]) for row in cells]
        place.say("ingest", place.file(f"{run}.csv", "\n".join([head, *of_percent, ""])))
    assert "level_differs" not in told(place.book.folder)


def test_what_is_asked_for_is_what_is_listed(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path, ingested=False), tmp_path)
    at = place.book.folder
    place.say("ingest", place.file("LOG0007.csv", shorter(place.book.log("r001"))))
    of_small = {one["run"] for several in told(at, "attention", "--where", "foot=small").values() for one in several}
    assert of_small == {"r001", "r002", "r004", "r006", "r009", "r010", "r012", "r014", None}
    assert "inbox" in told(at)
    assert "inbox" not in told(at, "attention", "--where", "foot=small")
    of_day = told(at, "attention", "--day", "2021-06-16")
    assert {one["day"] for one in of_day["charge_missing"]} == {"2021-06-16"}
    assert "inbox" in of_day
    both = told(at, "attention", "--day", "2021-06-16", "--where", "foot=small")
    assert {one["run"] for one in both["log_missing"]} == {"r009", "r010", "r012", "r014"}
    refused(labbook("attention", "--where", "foot=tiny", at=at), 2, "tiny")
    refused(labbook("attention", "--day", "tomorrow", at=at), 2, "--day 'tomorrow'")


def test_today_is_attention_of_one_day_and_the_last_backup(tmp_path: Path) -> None:
    at = small_book(tmp_path, ingested=False).folder
    of_day = good(labbook("attention", "--day", "2021-06-14", "--json", at=at)).json
    today = good(labbook("today", "--day", "2021-06-14", "--json", at=at)).json
    assert today.pop("last_backup") is None
    assert {**today, "where": None} == of_day
    whole = told(at)
    for code, several in told(at, "today", "--day", "2021-06-14").items():
        assert [one for one in whole[code] if one["day"] in (None, "2021-06-14")] == several


def test_the_gravest_comes_first_and_of_days_too(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    place.correct("r009", "mah=10")
    place.say("files", "withdraw", "r001.csv", *WHY)
    found = good(labbook("attention", "--json", at=place.book.folder)).json
    order = [list(Gravity).index(one["gravity"]) for one in found["findings"]]
    assert order == sorted(order)
    assert found["findings"][0]["code"] == "charge_below_drain"
    assert list(found["by_day"]) == ["2021-06-16", "2021-06-14"]
    assert found["by_day"]["2021-06-16"]["wrong"] == 1


def test_files_of_one_name_are_told_apart_in_the_commands(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path, ingested=False), tmp_path)
    for run in ("r001", "r002"):
        place.say("ingest", place.file("LOG0001.csv", place.book.log(run).read_bytes()))
        place.say("ingest", place.file("charges.csv", f"mAh,pack\n{111 + int(run[1:])},A\n"))
    waiting = told(place.book.folder)["inbox"]
    assert [one["file"] for one in waiting] == ["LOG0001.csv"] * 2 + ["charges.csv#1"] * 2
    for one, run in zip(waiting, ("r001", "r002") * 2, strict=True):
        place.say(*(word.replace("RUN", run) for word in shlex.split(one["command"])[1:]))
    assert "inbox" not in told(place.book.folder)


def test_a_log_that_was_taken_off_its_run_is_given_back_by_the_command(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    place.say("assign", "r001.csv", "none", *WHY)
    place.say("ingest", place.file("LOG0007.csv", shorter(place.book.log("r002"))))
    (found,) = told(place.book.folder, "attention", "--where", "foot=small")["inbox"]
    assert (found["run"], found["day"], found["fill_in"]) == ("r001", "2021-06-14", [])
    assert "inbox" not in told(place.book.folder, "attention", "--where", "foot=large")
    assert [one["file"] for one in told(place.book.folder, "today", "--day", "2021-06-16")["inbox"]] == ["LOG0007.csv"]
    place.say(*shlex.split(found["command"])[1:])
    assert "log_missing" not in told(place.book.folder)


def test_on_postgresql_the_same_is_found(tmp_path: Path, postgres_url: str) -> None:
    found = []
    for name, url in (("here", None), ("there", postgres_url)):
        place = Place(small_book(tmp_path / name, database_url=url), tmp_path)
        high_zero(place)
        place.correct("r002", "mah=10")
        place.correct("r003", "date=2021-05-14")
        place.say("files", "withdraw", "r004.csv", *WHY)
        place.say("assign", "2021-06-14.csv#5", "none", *WHY)
        found.append(good(labbook("attention", "--json", at=place.book.folder)).json)
    assert found[0] == found[1]
    assert {"zero_doubtful", "charge_below_drain", "charge_date"} <= {one["code"] for one in found[0]["findings"]}


def test_a_long_list_is_folded_and_the_json_has_all(tmp_path: Path) -> None:
    at = small_book(tmp_path, ingested=False).folder
    out = good(labbook("attention", at=at)).out
    says(out, "7 more", "charge_missing")
    assert len(told(at)["charge_missing"]) == 16


def decided(folder: Path, runs: list[Made]) -> dict[str, Decision]:
    """What a report decides of the savings with each foot."""
    compared = reports(charged_book(folder, runs)).results.comparisons
    return {
        one.group["foot"]: one.decision for one in compared if one.family == POOLED and one.quantity is Outcome.JOULES
    }


@pytest.mark.parametrize("seed", range(4))
def test_a_charge_that_costs_a_claim_is_the_one_that_the_report_names(seed: int, tmp_path: Path) -> None:
    draws = random.Random(seed)
    runs = [
        Made(draws.randrange(3), foot, gain, None if draws.random() < 0.35 else 40.0 + draws.random())
        for foot in ("small", "large")
        for gain in (0, 0, 0, 100, 100)
    ]
    as_it_is = decided(tmp_path / "as it is", runs)
    with_all = decided(tmp_path / "with all", [replace(run, joules=run.joules or 40.5) for run in runs])
    found = told(tmp_path / "as it is" / "book").get("charge_missing", [])
    costs = {one["run"] for one in found if one["costs_claim"]}
    for foot, decision in as_it_is.items():
        lacking = {f"r{n:03d}" for n, run in enumerate(runs, start=1) if run.foot == foot and run.joules is None}
        together = lacking if decision.rule is Rule.NONE and with_all[foot].rule is not Rule.NONE else set()
        assert costs & lacking == (set(decision.charge_missing) or together)


def test_charges_that_give_a_claim_together_alone_are_named_together(tmp_path: Path) -> None:
    runs = [
        Made(0, "small", 0, 42.0), Made(0, "small", 0, None), Made(0, "small", 100, 40.0), Made(0, "small", 100, None),
        Made(0, "large", 0, 42.0), Made(0, "large", 0, 43.0), Made(0, "large", 100, 40.0), Made(0, "large", 100, None),
        Made(1, "large", 0, None),
    ]  # fmt: skip
    found = {one["run"]: one for one in told(charged_book(tmp_path, runs).folder)["charge_missing"]}
    assert {run for run, one in found.items() if one["costs_claim"]} == {"r002", "r004", "r008"}
    assert all(one["gravity"] == ("claim lost" if one["costs_claim"] else "missing") for one in found.values())
    says(found["r002"]["costs"], "r002, r004", "foot small", "1 shared day")
    assert "r004" not in found["r008"]["costs"]
