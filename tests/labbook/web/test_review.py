"""Jumps judged by keyboard in a real browser: each verdict is a row of the book, whatever happens to the server."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from data_schema.tables.runs import decision
from data_schema.vocabulary import Action, ReasonCode, Verdict
from labbook.actions.runs.jump_review import decide, review
from labbook.book.naming import run_named
from labbook.book.write_session import Statement, new_uid
from labbook.config.model import ProtocolSettings
from labbook.web.review import reason_keys
from tests.cli.shell import good, labbook
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.statements import state
from tests.helpers.web import Server, served, until


@pytest.fixture
def book(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path, two_people=True)


def opened(page: Any, server: Server, path: str = "/review?run=r003") -> None:
    """Open the page; a test that holds requests back asks for it before: a page that is open may send one past it."""
    page.goto(server.url)
    page.goto(server.base + path)
    until(lambda: bool(page.text_content("#number")))


def verdicts(book: SmallBook) -> list[tuple[str, str, str | None]]:
    """The verdicts in the book in their order: which, the reason, and by whom."""
    with book.open() as opened_book, opened_book.reading() as connection:
        rows = connection.execute(sa.select(decision.c.verdict, decision.c.reason_code).order_by(decision.c.id))
        return [(row.verdict, row.reason_code) for row in rows]


def notes(book: SmallBook) -> list[str | None]:
    """The notes of the verdicts in the book in their order."""
    with book.open() as opened_book, opened_book.reading() as connection:
        return list(connection.execute(sa.select(decision.c.note).order_by(decision.c.id)).scalars())


def accepted(jump: dict[str, Any]) -> dict[str, Any]:
    named = {"signal": jump["signal"], "anchor_s": jump["anchor_s"]}
    return {"run": jump["run"], "jumps": [named], "verdict": "accept", "reason": "looks_right"}


def all_saved(page: Any) -> None:
    until(lambda: "waiting" not in page.text_content("#saved"))


def test_keys_become_rows_of_the_book(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        page.keyboard.press("a")
        page.keyboard.press("r")
        page.keyboard.press("t")
        all_saved(page)
        assert verdicts(book) == [("accept", "looks_right"), ("reject", "touched_by_hand")]
        page.keyboard.press("u")
        all_saved(page)
        assert verdicts(book)[2:] == [("clear", "other")]
        assert "2 of" in page.text_content("#number")  # undone where it was given
        page.keyboard.press("b")
        until(lambda: "accepted" in page.text_content("#verdict"))
        page.reload()
        until(lambda: "accepted" in page.text_content("#verdict"))


def test_the_rest_of_a_run_is_accepted_at_one_key(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        jumps = server.json("/api/runs/r003/log")["jumps"]
        opened(page, server)
        page.keyboard.press("Shift+A")
        all_saved(page)
        doubted = page.text_content("#doubts")
        assert {verdict for verdict, _reason in verdicts(book)} <= {"accept"}
        assert len(verdicts(book)) <= len(jumps)
        assert bool(verdicts(book)) or doubted


def test_a_burst_of_keys_loses_none(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        count = len(server.json("/api/queue")["jumps"])
        opened(page, server, "/review")
        for _ in range(count):
            page.keyboard.press("a")
        all_saved(page)
        assert all(jump["decided"] for jump in server.json("/api/queue")["jumps"])
    assert verdicts(book) == [("accept", "looks_right")] * count


def test_another_reason_is_said_in_a_note(page: Any, book: SmallBook) -> None:
    said = "a cable, caught"  # its letters are keys, too
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        page.keyboard.press("r")
        page.keyboard.press("o")
        page.keyboard.type("not so")
        page.keyboard.press("Escape")
        assert "1 of" in page.text_content("#number")
        assert verdicts(book) == []
        page.keyboard.press("r")
        page.keyboard.press("o")
        page.keyboard.type(said)
        page.keyboard.press("Enter")
        page.keyboard.press("r")
        page.keyboard.press("o")
        page.keyboard.press("Enter")
        all_saved(page)
        assert verdicts(book) == [("reject", "other")] * 2
        assert notes(book) == [said, None]
        opened(page, server)
        page.keyboard.press("b")
        page.keyboard.press("b")
        until(lambda: f"rejected: other, {said}, by {ADA}" in page.text_content("#verdict"))
        page.keyboard.press("a")
        page.keyboard.press("u")
        until(lambda: f"rejected: other, {said}, by" in page.text_content("#verdict"))
        all_saved(page)
    assert verdicts(book)[2:] == [("accept", "looks_right"), ("reject", "other")]
    assert notes(book)[2:] == [None, said]


def test_a_burst_of_keys_with_a_note_stays_in_order(page: Any, book: SmallBook) -> None:
    held: list[Any] = []
    with served(book.folder, "--as", ADA) as server:
        page.route("**/api/runs/*/log", lambda route: held.append(route))
        page.goto(server.url)
        page.goto(server.base + "/review?run=r003")
        until(lambda: "Jump 1" in page.text_content("#title") and held)
        for key in ("a", "r", "Escape", "r", "o", *"a rod", "Backspace", "Enter", "r", "t"):
            page.keyboard.press(key)
        assert verdicts(book) == []
        for route in held:
            route.continue_()
        until(lambda: len(verdicts(book)) == 3)
        all_saved(page)
    assert verdicts(book) == [("accept", "looks_right"), ("reject", "other"), ("reject", "touched_by_hand")]
    assert notes(book) == [None, "a ro", None]


def test_a_run_is_gone_to_by_keyboard(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server, "/review?order=run&open")
        shown = page.text_content("#title")
        for key in ("g", *"r003", "Escape"):
            page.keyboard.press(key)
        assert page.text_content("#title") == shown
        for key in ("g", *"r003", "Enter"):
            page.keyboard.press(key)
        until(lambda: page.text_content("#title").startswith("r003"))


def test_reasons_are_those_of_the_lab(page: Any, book: SmallBook) -> None:
    book.rewrite("[protocol]\n", '[protocol]\nreject_reasons = ["other", "sensor_fault", "misfire"]\n')
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        page.keyboard.press("r")
        assert [text.split() for text in page.locator("#reasons button").all_inner_texts()] == [
            ["s", "sensor", "fault"], ["m", "misfire"], ["o", "other"],
        ]  # fmt: skip
        page.keyboard.press("t")
        page.keyboard.press("m")
        all_saved(page)
    assert verdicts(book) == [("reject", "misfire")]


def test_the_key_of_a_reason_is_its_first_letter_that_is_free() -> None:
    assert "".join(reason_keys(ProtocolSettings().reject_reasons)) == "dwtmso"
    assert reason_keys(["other", "of_it", "fast", "f_s"]) == {"f": "of_it", "a": "fast", "s": "f_s", "o": "other"}


def test_an_apex_is_moved_and_a_missed_jump_added_by_keyboard(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        before = server.json("/api/runs/r003/log")["jumps"]
        opened(page, server)
        page.keyboard.press("m")
        page.keyboard.press("ArrowRight")
        with page.expect_navigation():  # the page is loaded anew, for numbers of jumps may be others now
            page.keyboard.press("Enter")
        until(lambda: [verdict for verdict, _reason in verdicts(book)] == ["move"])
        after = server.json("/api/runs/r003/log")["jumps"]
        assert 0.0 < after[0]["at_s"] - before[0]["at_s"] < 0.02
        opened(page, server, "/review?run=r003&open")
        page.keyboard.press("b")  # back from the first that is to be judged
        until(lambda: "moved" in (page.text_content("#facts") or ""))
        page.keyboard.press("n")
        page.keyboard.press("Escape")
        page.keyboard.press("a")
        all_saved(page)
        assert [verdict for verdict, _reason in verdicts(book)] == ["move", "accept"]


def test_of_a_run_of_two_logs_an_apex_is_moved_in_its_own(page: Any, book: SmallBook) -> None:
    good(labbook("correct", "r003", "starts=2", "--why", "started again", "--as", ADA, at=book.folder))
    good(labbook("assign", "r005.csv", "r003", "--why", "its second log", "--as", ADA, at=book.folder))
    with served(book.folder, "--as", ADA) as server:
        before = server.json("/api/runs/r003/log")["jumps"]
        opened(page, server)
        page.keyboard.press("ArrowLeft")
        for _jump in before[1:]:
            page.keyboard.press("ArrowRight")
        until(lambda: page.text_content("#number").startswith("Jump 6 "))
        page.keyboard.press("m")
        page.keyboard.press("ArrowRight")
        with page.expect_navigation():
            page.keyboard.press("Enter")
        until(lambda: len(verdicts(book)) == 1)
        after = server.json("/api/runs/r003/log")["jumps"]
    assert [one["at_s"] for one in after[:5]] == [one["at_s"] for one in before[:5]]
    assert 0.0 < after[5]["at_s"] - before[5]["at_s"] < 0.02
    assert {one["log_begins_s"] for one in after[:3]} == {0.0} != {one["log_begins_s"] for one in after[3:]}


def test_a_verdict_says_whether_the_condition_was_hidden(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server, "/review?order=run")
        page.keyboard.press("a")
        page.keyboard.press("o")
        page.keyboard.press("a")
        page.keyboard.press("o")  # hidden again, and seen all the same
        page.keyboard.press("a")
        all_saved(page)
        opened(page, server)  # the address names the run
        page.keyboard.press("a")
        all_saved(page)
    with book.open() as opened_book, opened_book.reading() as connection:
        assert list(connection.execute(sa.select(decision.c.blind).order_by(decision.c.id)).scalars()) == [1, 0, 0, 0]


def test_a_verdict_is_on_the_jump_that_was_seen_whatever_was_added_meanwhile(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        page.keyboard.press(" ")
        seen = server.json("/api/queue?run=r003")["jumps"][1]
        with book.open() as opened_book:
            state(opened_book, decide, "r003", [1], "reject", "misfire", None, person="Ben Ode")
        page.keyboard.press("a")
        all_saved(page)
    with book.open() as opened_book, opened_book.reading() as connection:
        found = connection.execute(sa.select(decision.c.anchor_s, decision.c.verdict).order_by(decision.c.id)).all()
    assert found[-1] == (seen["anchor_s"], "accept")


def test_undo_gives_nobody_elses_verdict(page: Any, book: SmallBook) -> None:
    with book.open() as opened_book:
        state(opened_book, decide, "r003", [1], "reject", "misfire", None, person="Ben Ode")
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        assert "Ben" not in (page.text_content("#verdict") or "")  # hidden while the condition is
        page.keyboard.press("a")
        page.keyboard.press("u")
        all_saved(page)
    assert verdicts(book) == [("reject", "misfire"), ("accept", "looks_right"), ("clear", "other")]


def test_verdicts_wait_for_a_server_that_was_killed(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        page.keyboard.press("a")
        all_saved(page)
        server.kill()
        page.keyboard.press("r")
        page.keyboard.press("m")
        until(lambda: "waiting" in page.text_content("#saved"))
        assert verdicts(book) == [("accept", "looks_right")]
        with served(book.folder, "--as", ADA, port=server.port):
            until(lambda: len(verdicts(book)) == 2)
            all_saved(page)
    assert verdicts(book) == [("accept", "looks_right"), ("reject", "misfire")]


def test_two_pages_see_each_other(browser: Any, page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        page.goto(server.url)
        page.wait_for_selector("#runs tbody tr")
        first = server.json("/api/queue?run=r003")["jumps"][0]
        server.json("/api/verdicts", accepted(first))
        until(lambda: "1 of" in page.text_content("#progress"))


def test_what_somebody_else_says_of_the_jump_shown_stands_there_soon(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server, "/review?run=r003&open")
        first = server.json("/api/queue?run=r003")["jumps"][0]
        with book.open() as opened_book:
            state(
                opened_book,
                decide,
                "r003",
                [first["number"]],
                Verdict.REJECT,
                ReasonCode.MISFIRE,
                None,
                person="Ben Ode",
            )
        until(lambda: page.text_content("#verdict") == "rejected: misfire by Ben Ode")


def test_keys_that_come_before_the_jumps_wait_for_them(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        held: list[Any] = []
        page.route("**/api/queue*", lambda route: held.append(route))
        page.goto(server.url)
        page.goto(server.base + "/review?run=r003", wait_until="commit")
        until(lambda: page.wait_for_timeout(20) is None and bool(held))
        for key in (" ", "a"):
            page.keyboard.press(key)
        held[0].continue_()
        until(lambda: len(verdicts(book)) == 1)
        jumps = server.json("/api/runs/r003/log")["jumps"]
        assert [jump["decided"] is not None for jump in jumps] == [False, True, False]


def test_where_two_people_differ_is_a_queue(page: Any, book: SmallBook) -> None:
    with book.open() as opened_book:
        for person, verdict in ((ADA, Verdict.ACCEPT), ("Ben Ode", Verdict.REJECT)):
            reason = ReasonCode.LOOKS_RIGHT if verdict is Verdict.ACCEPT else ReasonCode.MISFIRE
            state(opened_book, decide, "r003", [2], verdict, reason, None, person=person)
            state(opened_book, decide, "r003", [1], Verdict.ACCEPT, ReasonCode.LOOKS_RIGHT, None, person=person)
    with served(book.folder, "--as", ADA) as server:
        opened(page, server, "/review?order=differences&open")
        assert "kappa" in page.text_content("main")
        assert [(one["run"], one["number"]) for one in server.json("/api/queue?order=differences")["jumps"]] == [
            ("r003", 2)
        ]
        assert page.text_content("#verdict") == "rejected: misfire by Ben Ode"


def test_accepting_the_rest_leaves_what_was_rejected_meanwhile(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        with book.open() as opened_book:
            for person, number in ((ADA, 2), ("Ben Ode", 3)):
                state(opened_book, decide, "r003", [number], Verdict.REJECT, ReasonCode.MISFIRE, None, person=person)
        until(lambda: page.text_content("#saved").startswith("1 of"))
        page.keyboard.press("A")
        until(lambda: len(verdicts(book)) == 3)
        assert verdicts(book)[2:] == [("accept", "with_the_rest")]


def test_after_a_rereading_the_page_shows_the_jumps_that_there_are(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        facts = page.text_content("#facts")
        declared = ("--column", "body_height=body_height:cm", "--override-units")
        good(
            labbook(
                "files", "reread", "r003.csv", *declared, "--why", "the unit was wrong", "--as", "AN", at=book.folder
            )
        )
        until(lambda: page.text_content("#facts") != facts or page.text_content("#title") == "Nothing to review")


def test_a_verdict_of_an_earlier_detector_stands_beside_its_jump_which_comes_back(page: Any, book: SmallBook) -> None:
    with book.open() as opened_book, opened_book.session(ADA) as session:
        first = review(opened_book, session.connection, "r003").jumps[0]
        assert first.jump.apex_s is not None
        new = {
            "target_kind": "jump", "target_uid": run_named(session.connection, "r003").uid,
            "signal_sha256": first.signal_sha256, "anchor_s": first.jump.apex_s, "verdict": "accept",
            "reason_code": "looks_right", "note": None, "old_value": (first.jump.apex_height_m or 0.0) + 0.1,
            "algorithm": "robust", "version": 1, "blind": 1,
        }  # fmt: skip
        session.state(Statement(Action.INCLUDE, "decision", new_uid(), new=new))
    with served(book.folder, "--as", ADA) as server:
        assert [jump["earlier"] for jump in server.json("/api/runs/r003/log")["jumps"]] == [
            [{"verdict": "accept", "person": ADA}], [], []
        ]  # fmt: skip
        opened(page, server)
        until(lambda: f"accepted by {ADA}" in page.text_content("#verdict"))
        assert page.text_content("#saved").startswith("0 of 3 reviewed")
        page.keyboard.press("r")
        page.keyboard.press("m")
        all_saved(page)
        page.keyboard.press("b")
        until(lambda: page.text_content("#verdict").startswith("rejected"))
        assert "1 of 3 reviewed, 1 rejected" in page.text_content("#saved")
        page.keyboard.press("u")
        until(lambda: page.text_content("#verdict").endswith(f"accepted by {ADA}"))
        assert "rejected" not in page.text_content("#saved")


def test_a_note_being_written_outlives_what_others_say(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        page.keyboard.press("r")
        page.keyboard.press("o")
        page.keyboard.type("the cable")
        with book.open() as opened_book:
            state(opened_book, decide, "r003", [2], Verdict.REJECT, ReasonCode.MISFIRE, None, person="Ben Ode")
        page.wait_for_timeout(2500)
        page.keyboard.type(" caught")
        page.keyboard.press("Enter")
        until(lambda: len(verdicts(book)) == 2)
        decided = server.json("/api/runs/r003/log")["jumps"][0]["decided"]
        assert (decided["verdict"], decided["note"]) == ("reject", "the cable caught")


@pytest.mark.parametrize("before", [0, 1])
def test_undo_leaves_what_somebody_else_said_since(page: Any, book: SmallBook, before: int) -> None:
    """Also where a verdict of one's own stood before the one that is undone."""
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        for _verdict in range(before):
            page.keyboard.type("rsb")
        page.keyboard.press("a")
        until(lambda: len(verdicts(book)) == 1 + before)
        with book.open() as opened_book:
            state(opened_book, decide, "r003", [1], Verdict.REJECT, ReasonCode.MISFIRE, None, person="Ben Ode")
        page.keyboard.press("u")
        until(lambda: "Ben Ode's verdict" in page.text_content("#saved"))
        assert verdicts(book)[1 + before :] == [("reject", "misfire")]


def test_what_was_seen_is_not_blind_after_a_reload(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server, "/review")
        page.keyboard.press("o")
        page.reload()
        until(lambda: bool(page.text_content("#number")))
        page.keyboard.press("a")
        until(lambda: len(verdicts(book)) == 1)
        with book.open() as opened_book, opened_book.reading() as connection:
            assert connection.execute(sa.select(decision.c.blind)).scalars().all() == [0]


def test_the_page_opens_at_the_first_jump_without_a_verdict_and_j_leads_to_the_next(page: Any, book: SmallBook) -> None:
    with book.open() as opened_book:
        for number in (1, 3):
            state(opened_book, decide, "r003", [number], Verdict.ACCEPT, ReasonCode.LOOKS_RIGHT, None)
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        until(lambda: page.text_content("#number").startswith("Jump 2 "))
        page.keyboard.press("a")
        page.keyboard.press("ArrowLeft")
        page.keyboard.press("ArrowLeft")
        page.keyboard.press("u")
        page.keyboard.press("j")
        until(lambda: page.text_content("#number").startswith("Jump 2 "))


def test_undo_leaves_what_one_said_since_on_another_page(browser: Any, page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        page.keyboard.press("a")
        all_saved(page)
        other = browser.new_page()
        opened(other, server)
        other.keyboard.press("b")
        other.keyboard.press("r")
        other.keyboard.press("t")
        all_saved(other)
        other.close()
        page.keyboard.press("u")
        until(lambda: "another page" in page.text_content("#saved"))
    assert verdicts(book) == [("accept", "looks_right"), ("reject", "touched_by_hand")]


def test_what_waits_is_shown_after_a_reload(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        page.route("**/api/verdicts", lambda _route: None)
        opened(page, server)
        page.keyboard.press("a")
        page.keyboard.press("b")
        until(lambda: "not saved yet" in page.text_content("#verdict"))
        page.reload()
        until(lambda: "not saved yet" in page.text_content("#verdict"))


def test_a_late_answer_does_not_show_again_what_was_undone(page: Any, book: SmallBook) -> None:
    held: list[Any] = []
    with served(book.folder, "--as", ADA) as server:
        page.route("**/api/verdicts", lambda route: held.append(route))
        opened(page, server)
        page.keyboard.press("a")
        page.keyboard.press("u")
        until(lambda: page.wait_for_timeout(20) is None and len(held) == 1)
        held.pop().continue_()
        until(lambda: page.wait_for_timeout(20) is None and len(held) == 1)  # the verdict is answered, not its undoing
        assert page.text_content("#verdict") == ""
        held.pop().continue_()
        all_saved(page)
        assert page.text_content("#verdict") == ""


def test_a_key_that_is_held_says_it_once(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        for _repeat in range(3):
            page.keyboard.down("a")
        page.keyboard.up("a")
        page.keyboard.press("ArrowRight")
        until(lambda: page.text_content("#number").startswith("Jump 3 "))
        until(lambda: "waiting" not in page.text_content("#saved"))
        assert len(verdicts(book)) == 1


def test_a_missed_jump_is_looked_for_between_its_neighbours(page: Any, book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        opened(page, server)
        page.keyboard.press("n")
        shown = page.text_content("#doubts")
        for _step in range(40):
            page.keyboard.press("Shift+ArrowRight")
        later = page.text_content("#doubts")
        assert float(later.split()[3]) > float(shown.split()[3])
        page.keyboard.press("Escape")
        assert verdicts(book) == []
