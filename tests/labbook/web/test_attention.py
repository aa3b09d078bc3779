"""What needs attention is mended from the page, through what its command calls, and nothing else is carried out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from data_schema.errors import InputRefused, UsageError
from data_schema.journal import Entry
from data_schema.vocabulary import Action
from labbook.actions.runs.attention import Finding
from labbook.web.attention import mend, mending
from tests.cli.test_attention import FAULTS, Place, exchanged_logs, place_for
from tests.helpers.attention import found_in
from tests.helpers.books import ADA, small_book
from tests.helpers.statements import in_table
from tests.helpers.web import Server, served
from tests.helpers.wording import refuses, says

WHY = "for this test"

Said = tuple[Action, str, bool]
"""What is stated, of which kind of thing, and whether of one that was there."""
CORRECTS: Said = (Action.SET, "run", True)
READS_AGAIN: Said = (Action.INGEST, "ingest", True)
EACH_COMMAND: Mapping[str, Said] = {
    "charge_date": CORRECTS,
    "charge_waits": (Action.EXCLUDE, "charge", False),
    "check_not_made": (Action.SET, "day_check", False),
    "file_outdated": READS_AGAIN,
    "file_waits": READS_AGAIN,
    "logs_too_many": (Action.SET, "file", True),
    "samples_twice": (Action.EXCLUDE, "file", True),
    "verdict_waits": (Action.SET, "decision", False),
    "zero_doubtful": READS_AGAIN,
}
"""A check for each command that has a button, and what that states; one more has a test of its own."""
ALIKE: Mapping[str, Said] = {
    "calibration_of_other_day": READS_AGAIN,
    "charges_several": (Action.SET, "charge", True),
    "level_differs": CORRECTS,
    "log_day_differs": CORRECTS,
}
"""The other checks whose findings have one."""


def planted(code: str, folder: Path) -> tuple[Place, Finding]:
    """A book with a fault, and what is found of it."""
    place = place_for(code, folder)
    FAULTS[code].plant(place)
    return place, found_now(place, code)


def found_now(place: Place, code: str) -> Finding:
    with place.book.open() as book:
        return next(one for one in found_in(book)[code] if FAULTS[code].about in (None, one.run))


def asked(found: Finding, **more: object) -> dict[str, object]:
    """What the page posts."""
    return {"code": found.code, "run": found.run, "file": found.file, "command": found.command, **more}


def said(place: Place) -> list[Entry]:
    with place.book.open() as book:
        return in_table(book)


def stated(place: Place, found: Finding, before: list[Entry]) -> Said:
    """Return what was stated since, after checking by whom and why, and that what was found is gone."""
    since = said(place)[len(before) :]
    assert {one.person for one in since} == {ADA}
    assert since[-1].reason == (WHY if found.fill_in else None)
    with place.book.open() as book:
        left = found_in(book).get(found.code, [])
    assert (found.day, found.run, found.file) not in [(one.day, one.run, one.file) for one in left]
    return since[-1].action, since[-1].entity_kind, since[-1].old is not None


def mended_from_page(place: Place, found: Finding) -> Said:
    before = said(place)
    with served(place.book.folder, "--as", ADA) as server:
        server.json("/api/mending", asked(found, why=WHY, day=found.day))
    return stated(place, found, before)


@pytest.mark.parametrize("code", EACH_COMMAND)
def test_a_fault_is_mended_from_the_page(code: str, tmp_path: Path) -> None:
    assert mended_from_page(*planted(code, tmp_path)) == EACH_COMMAND[code]


def test_a_log_that_was_taken_off_its_run_is_given_back_from_the_page(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    place.say("assign", "r001.csv", "none", "--why", "a slip")
    with place.book.open() as book:
        (found,) = found_in(book)["inbox"]
    assert mended_from_page(place, found) == (Action.SET, "file", True)


def test_exchanged_logs_are_given_back_alike(tmp_path: Path) -> None:
    place = Place(small_book(tmp_path), tmp_path)
    exchanged_logs(place, "r001", "r002")
    before = said(place)
    with place.book.open() as book:
        found, _other = found_in(book)["level_differs"]
        mend(book, ADA, found, WHY)
    assert stated(place, found, before) == (Action.SET, "run_file", True)


@pytest.mark.parametrize("code", ALIKE)
def test_a_fault_is_mended_alike(code: str, tmp_path: Path) -> None:
    place, found = planted(code, tmp_path)
    before = said(place)
    with place.book.open() as book:
        mend(book, ADA, found, WHY)
    assert stated(place, found, before) == ALIKE[code]


def test_a_reading_that_is_refused_says_why(tmp_path: Path) -> None:
    place, _found = planted("calibration_of_other_day", tmp_path)
    place.book.rewrite("from = 2024-03-05", "from = 2024-03-06")
    found = found_now(place, "calibration_of_other_day")
    with place.book.open() as book, refuses(InputRefused, "r001.txt", "2024-03-05"):
        mend(book, ADA, found, "")


@dataclass(frozen=True, slots=True)
class Refusing:
    """A book whose run r001 has two logs, and its server; nothing that is asked of it may be stated."""

    place: Place
    server: Server
    found: Finding
    before: list[Entry]

    def refused(self, given: object) -> str:
        status, body, _headers = self.server.ask("/api/mending", given)
        assert status == 422
        assert said(self.place) == self.before
        return body.decode()


@pytest.fixture(scope="module")
def refusing(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Refusing]:
    place, found = planted("logs_too_many", tmp_path_factory.mktemp("refusing"))
    with served(place.book.folder, "--as", ADA) as server:
        yield Refusing(place, server, found, said(place))


@pytest.mark.parametrize(
    "changed",
    [
        {"command": "labbook files withdraw r002.csv --why WHY"},
        {"command": "labbook assign two.csv none --why 'another reason'"},
        {"command": ["labbook"]},
        {"run": "r002"},
        {"file": None},
        {"code": "samples_twice"},
        {"day": "2021-06-16"},
    ],
)
def test_what_was_not_found_is_not_carried_out(changed: Mapping[str, object], refusing: Refusing) -> None:
    says(refusing.refused({**asked(refusing.found, why=WHY), **changed}), "reload")


def test_a_command_alone_is_not_carried_out(refusing: Refusing) -> None:
    refusing.refused({"command": refusing.found.command, "why": WHY})
    refusing.refused([refusing.found.command])


def test_a_reason_is_wanted_where_the_command_has_one(refusing: Refusing) -> None:
    says(refusing.refused(asked(refusing.found)), "reason")
    says(refusing.refused(asked(refusing.found, why=" ")), "reason")


@pytest.mark.parametrize("code", ["analysis_undecided", "charge_missing", "jumps_doubtful"])
def test_a_command_that_shows_or_is_filled_in_has_no_button(code: str, tmp_path: Path) -> None:
    place, found = planted(code, tmp_path)
    assert mending(found) is None
    with place.book.open() as book, refuses(UsageError, found.command):
        mend(book, ADA, found, WHY)


def test_what_is_no_longer_found_is_not_carried_out(tmp_path: Path) -> None:
    place, found = planted("logs_too_many", tmp_path)
    with served(place.book.folder, "--as", ADA) as server:
        place.say("assign", "two.csv", "none", "--why", "by another program")
        Refusing(place, server, found, said(place)).refused(asked(found, why=WHY))


def test_a_page_for_reading_has_no_buttons_and_states_nothing(tmp_path: Path) -> None:
    place, found = planted("logs_too_many", tmp_path)
    before = said(place)
    with served(place.book.folder, "--as", ADA, "--read-only") as server:
        shown = server.ask("/attention")[1].decode()
        status, body, _headers = server.ask("/api/mending", asked(found, why=WHY))
    assert found.command in shown
    assert 'name="why"' not in shown
    assert 'class="mend"' not in shown
    assert status == 403
    says(body.decode(), "--read-only")
    assert said(place) == before


def test_in_a_browser_a_button_mends_and_no_reason_is_lost(page: Any, tmp_path: Path) -> None:
    from playwright.sync_api import expect

    place, _found = planted("logs_too_many", tmp_path)
    with served(place.book.folder, "--as", ADA) as server:
        page.goto(server.url)
        page.goto(server.base + "/attention")
        checks = page.locator("li", has_text="lubrication")
        expect(checks).to_have_count(2)
        checks.first.get_by_role("button", name="passed").click()
        expect(checks).to_have_count(1)
        log = page.locator("li", has_text="none of them counts")
        reason = log.get_by_label("why")
        log.get_by_role("button", name="Take it off").click()  # a reason is wanted first
        reason.fill(WHY)
        place.say("assign", "two.csv", "none", "--why", "by another program")
        expect(page.locator("#lost")).to_contain_text("reload")
        expect(reason).to_have_value(WHY)
        reason.press("Enter")
        expect(log.get_by_role("alert")).to_contain_text("reload")
        place.say("assign", "two.csv", "r001")
        page.reload()
        reason.fill(WHY)
        reason.press("Enter")
        expect(log).to_have_count(0)
    assert said(place)[-1].reason == WHY
