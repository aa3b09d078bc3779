"""What a new user gets wrong: one sentence with what to do, the right exit code, and nothing lost or changed."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import pytest

from tests.cli.shell import Contents, contents, good, labbook, refused
from tests.helpers.books import SmallBook, small_book
from tests.helpers.wording import refuses, says

WRONG_WORDS = {
    "no such command": ("inget x.csv", "no such command 'inget'", "'ingest'", "`labbook --help`"),
    "no such option": ("runs list --were x", "no such option: --were", "--where", "`labbook runs list --help`"),
    "argument missing": ("show", "missing argument 'run'", "`labbook show --help`"),
    "option missing": ("void r001", "missing option '--reason'", "`labbook void --help`"),
    "option without value": ("note r001 x --as", "'--as' requires an argument", "--help"),
    "several numbers": ("power --test welch --difference 2 --sd 4,1 --n 8", "--sd 4 --sd 1", "one by one"),
    "decimal comma": ("study compaction --grain 3,4", "'--grain'", "write 3.4."),
    "jump number expected": ("jumps reject r001 first --reason misfire", "'first' names no jump", "3-5"),
}

UNKNOWN_NAMES = {
    "person": ("note r001 x --as Ida", "'Ida' is not a known person", "'Ada Nwosu'", "[people]"),
    "run": ("show r0001", "'r0001' is not a known run", "'r001'", "`labbook runs list`"),
    "run without its zeros": ("show r7", "'r7' is not a known run", "did you mean 'r007'"),
    "level of an option": ("report --foot tiny", "'tiny' is not a known level of foot (--foot)", "'large', 'small'"),
    "number of an option": ("report --b-ad-gain=50", "'50' is not a known level of b_ad_gain (--b-ad-gain)", "0, 100"),
    "run for a file": ("ingest ../instruments/logs --run r99", "'r99' is not a known run", "`labbook runs import`"),
    "factor as option": ("report --fot small", "'--fot' is not a known option", "'--foot'"),
    "option of the command": ("report --sumary", "'--sumary' is not a known option", "'--summary'"),
    "factor to correct": ("correct r001 fot=large --why x", "'fot' is not a known field of a run", "'foot'"),
    "level to correct": ("correct r001 foot=huge --why x", "'huge'", "'large', 'small'", "[factors.foot]"),
    "pack to correct": ("correct r001 battery=Z --why x", "'Z' is not a known battery", "'A', 'B', 'C'"),
    "zone to correct": ("correct study time_zone=America/NewYork --why x", "did you mean 'America/New_York'"),
    "robot": ("correct robot:hoper body_mass_kg=2 --why x", "there is no robot 'hoper'"),
    "check": ("check rail", "'rail' is not a known check", "'rail_angle'"),
    "reason": ("jumps reject r001 1 --reason misfired", "'misfired' is not a known reason", "'misfire'"),
    "reason to reject": (
        "jumps reject r001 1 --reason looks_right",
        "looks_right is no reason to reject a jump",
        "touched_by_hand",
        "misfire",
    ),
    "reason to accept": (
        "jumps accept r001 1 --reason misfire",
        "misfire is no reason to accept a jump",
        "looks_right",
    ),
    "imported file": ("assign r01.csv r001", "'r01.csv' is not a known imported file", "did you mean 'r0"),
    "provenance id": ("why 0123456789ab", "'0123456789ab'", "copy the whole id"),
    "plan method": ("plan --seed 1 --method random", "'random' is not one of", "'randomised'"),
}

BAD_VALUES = {
    "day": ("today --day tomorrow", "--day 'tomorrow' is not a date", "2021-06-01"),
    "day that never was": ("check rail_angle --day 2021-02-30", "'2021-02-30' is not a date"),
    "option without level": ("report --foot", "'--foot' is not understood", "--foot small"),
    "correction without value": ("correct r001 foot --why x", "'foot' is not a correction", "FIELD=VALUE"),
    "number": ("correct r001 duration_s=long --why x", "duration_s=long is not a number"),
    "finite number": ("correct r001 duration_s=inf --why x", "finite number"),
    "impossible jumps": ("correct r001 jumps_made=-3 --why x", "jumps_made=-3", "jumps_made must be 0 or more"),
    "charge below 0": ("correct r001 mah=-5 --why x", "a charge of -5 mAh is not possible", "0 or more", "mode="),
    "name of another": ("correct r001 name=r002 --why x", "there is a run r002 already"),
    "place of another": ("correct r001 position_in_day=2 --why x", "run r002 has position_in_day=2 of 2021-06-14"),
    "empty name": ("correct r001 name= --why x", "name= is empty"),
    "instant": ("correct r001 started_utc=noon --why x", "started_utc=noon", "2021-06-01T14:30:00Z"),
    "no reason": ('correct r001 foot=large --why " "', "--why is empty"),
    "empty note": ('note r001 " "', "the note is empty"),
    "jump that is not there": ("jumps reject r001 40 --reason misfire", "no jump 40", "`labbook jumps list r001`"),
    "form of a plot": ("plot r001 --out r001.jpeg", ".png, .svg, .pdf"),
    "folder as a plot": ("plot r001 --out ../instruments", "is a folder: name a file in it", "figure.png"),
    "report without a folder": ('report --out ""', "--out names no folder", "--out paper"),
    "charge in no time": ("charge r001 120 --minutes 0", "--minutes 0", "above 0"),
    "charge no pack takes": ("charge r001 90000", "90000 mAh is more than pack"),
    "file taken off without why": ("assign r001.csv none", "belongs to run r001", "add --why to take it off"),
    "idle with jumps": ("correct r001 kind=idle --why x", "3 jumps made and levels", "jumps_made=0 levels=none"),
    "jumps of an idle run": ("correct r007 jumps_made=3 --why x", "would be idle with 3 jumps made", "kind=jumps"),
    "jumps without levels": ("correct r007 kind=jumps --why x", "without levels", "foot=", "kind=idle"),
    "levels that are none": ("correct r001 levels=small --why x", "levels=small", "levels=none", "foot=large"),
    "range of jumps that runs backwards": ("jumps reject r001 3-1 --reason misfire", "'3-1' runs backwards", "1-3"),
    "plan without seed": ("plan", "a plan needs a seed", "--seed 7"),
    "withdrawing without why": ("plan --withdraw", "needs a reason", "--why"),
    "withdrawing and drawing": ("plan --withdraw --n 5 --no-idle --why x", "no use for --n and --idle/--no-idle"),
    "why without withdrawing": ("plan --seed 1 --why x", "--why belongs to --withdraw"),
    "rate": ("ingest new.csv --rate -300", "--rate", "-300", "> 0"),
    "unit without column": ("ingest new.csv --unit ms", "--unit 'ms'", "COLUMN=UNIT"),
    "decimal sign": ("ingest new.csv --decimal ;", "--decimal", "';'"),
}

FILES = {
    "no file": ("ingest nope.csv", "nope.csv does not exist"),
    "folder without files": ("ingest ../empty", "there is no file in ../empty"),
    "no run sheet": ("runs import nope.csv", "nope.csv"),
    "folder as run sheet": ("runs import ../instruments", "is a folder", "name the file in it"),
    "no order of dates": ("runs import ../latin.csv --dates y/m/d", "--dates", "d/m/y"),
    "log as run sheet": ("runs import ../instruments/logs/r001.csv", "is no run sheet", "run, date", "labbook plan"),
    "spreadsheet as run sheet": ("runs import ../sheet.xlsx", "sheet.xlsx", "save it as CSV in UTF-8"),
    "pipe as file": ("ingest ../pipe", "is not a regular file"),
}

CASES = {**WRONG_WORDS, **UNKNOWN_NAMES, **BAD_VALUES, **FILES}


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    above = tmp_path_factory.mktemp("wrong")
    made = small_book(above)
    (above / "empty").mkdir()
    (above / "latin.csv").write_bytes(b"run\x81\n")
    (above / "sheet.xlsx").write_bytes(b"PK\x03\x04" + bytes(60))
    (made.folder / "new.csv").write_text("t,h\n1,2\n2,3\n")
    os.mkfifo(above / "pipe")
    return made


@pytest.fixture(scope="module")
def before(book: SmallBook) -> Contents:
    return contents(book.folder)


@pytest.mark.parametrize("case", CASES)
def test_wrong_use_is_told_in_one_sentence_and_changes_nothing(case: str, book: SmallBook, before: Contents) -> None:
    words, *said = CASES[case]
    refused(labbook(*shlex.split(words), at=book.folder), 2, *said)
    assert contents(book.folder) == before


@pytest.mark.parametrize("words", ["show r0001", "runs lst", "note r001", "today --day never"])
def test_programs_get_the_sentence_as_json_too(words: str, book: SmallBook) -> None:
    answer = labbook(*words.split(), "--json", at=book.folder)
    assert answer.code == 2
    assert answer.json["exit_code"] == 2
    assert answer.err == f"labbook: {answer.json['error']}\n"


def test_debug_shows_where_an_error_arose(book: SmallBook) -> None:
    with refuses(Exception, "not a known"):
        labbook("show", "r0001", "--debug", at=book.folder)
    good(labbook("show", "r001", "--debug", at=book.folder))


@pytest.mark.parametrize("words", ["note r001 x", "ingest new.csv", "plan --seed 1", "report", "void r1 --reason x"])
def test_statement_without_a_person_is_refused_where_several_may_speak(words: str, tmp_path: Path) -> None:
    made = small_book(tmp_path, ingested=False, two_people=True)
    (made.folder / "new.csv").write_text("t,h\n1,2\n")
    before = contents(made.folder)
    refused(labbook(*words.split(), at=made.folder), 2, "a statement needs a person", "--as", "'Ben Ode'")
    assert contents(made.folder) == before


def test_who_speaks_can_come_from_the_environment_by_initials(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = small_book(tmp_path, ingested=False, two_people=True)
    monkeypatch.setenv("LABBOOK_AS", "BO")
    good(labbook("note", "r001", "left rail squeaked", at=made.folder))
    says(labbook("show", "r001", at=made.folder).out, "note by Ben")
    good(labbook("note", "r001", "oiled", "--as", "Ada Nwosu", at=made.folder))
    says(labbook("show", "r001", at=made.folder).out, "note by Ada")
