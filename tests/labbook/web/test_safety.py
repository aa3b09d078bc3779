"""The page answers its own browser alone, and no request leaves the book's own words."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.shell import LABBOOK, environment
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.statements import note, state
from tests.helpers.web import Page, Server, served, until
from tests.helpers.wording import says

VERDICT: dict[str, object] = {"run": "r003", "jumps": [], "verdict": "reject", "reason": "misfire"}
HOSTILE = "<script>alert(1)</script>\"'&"


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    made = small_book(tmp_path_factory.mktemp("web"))
    with made.open() as opened_book:
        state(opened_book, note, HOSTILE)
    return made


@pytest.fixture(scope="module")
def server(book: SmallBook) -> Iterator[Server]:
    with served(book.folder, "--as", ADA) as made:
        yield made


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 200),
        ({"Cookie": ""}, 403),
        ({"Cookie": "labbook=0123456789abcdef0123456789abcdef"}, 403),
        ({"Cookie": "labbook=\u00e9"}, 403),
        ({"Host": "evil.example"}, 400),
        ({"Host": "evil.example:80"}, 400),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
    ],
)
def test_only_its_own_browser_is_answered(server: Server, headers: dict[str, str], status: int) -> None:
    assert server.ask("/api/runs", headers=headers)[0] == status


@pytest.mark.parametrize("headers", [{"Origin": ""}, {"Origin": "http://evil.example"}, {"Cookie": ""}])
def test_another_page_states_nothing(server: Server, book: SmallBook, headers: dict[str, str]) -> None:
    before = book.journal.read_bytes()
    verdict = VERDICT
    assert server.ask("/api/verdicts", verdict, headers=headers)[0] == 403
    assert book.journal.read_bytes() == before


def test_the_token_of_the_address_becomes_a_cookie(server: Server) -> None:
    status, _body, headers = server.ask(f"/review?token={server.token}", headers={"Cookie": ""})
    assert (status, headers["Location"]) == (303, "/review")
    says(headers["Set-Cookie"], server.token, "HttpOnly", "SameSite=strict")


def test_the_address_on_the_browsers_command_line_opens_the_page_once(book: SmallBook, tmp_path: Path) -> None:
    called, browser = tmp_path / "called", tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {called}.part && mv {called}.part {called}\n')
    browser.chmod(0o700)
    words = [LABBOOK, "web", "--json", "--book", str(book.folder), "--port", "0", "--as", ADA]
    with subprocess.Popen(words, env={**environment(), "BROWSER": str(browser)}, stdout=subprocess.PIPE) as running:
        try:
            until(called.exists, 30.0)
            url = called.read_text().strip()
            page = Page(url)
            path = url.removeprefix(page.base)
            answers = [page.ask(path, headers={"Cookie": ""}) for _time in range(2)]
            assert [status for status, _body, _headers in answers] == [303, 403]
            cookie = answers[0][2]["Set-Cookie"].partition(";")[0]
            assert page.token not in cookie
            assert page.ask("/api/runs", headers={"Cookie": cookie})[0] == 200
        finally:
            running.kill()


def test_an_address_of_six_is_served(book: SmallBook) -> None:
    with served(book.folder, "--read-only", "--host", "::1") as server:
        assert server.base == f"http://[::1]:{server.port}"
        assert server.ask("/api/runs")[0] == 200
        assert server.ask("/api/runs", headers={"Host": f"127.0.0.1:{server.port}"})[0] == 400


@pytest.mark.parametrize("path", ["/", "/runs/r001", "/review", "/api/runs", "/static/web.css", "/nowhere"])
def test_nothing_runs_that_does_not_come_from_here(server: Server, path: str) -> None:
    _status, body, headers = server.ask(path)
    policy = headers["Content-Security-Policy"]
    says(policy, "default-src 'none'", "script-src 'self'", "frame-ancestors 'none'")
    assert "unsafe" not in policy
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert b"<script>" not in body  # no script within the page, of a note neither
    assert b" onclick=" not in body


@pytest.mark.parametrize(
    "path",
    [
        "/static/../app.py",
        "/static/%2e%2e%2fapp.py",
        "/static//etc/passwd",
        "/runs/..%2f..%2fetc",
        "/static/base.html.j2",
    ],
)
def test_no_path_of_a_request_reaches_the_file_system(server: Server, path: str) -> None:
    status, body, _headers = server.ask(path)
    assert status == 404
    assert b"root:" not in body


def test_texts_of_the_book_are_escaped(server: Server) -> None:
    _status, body, _headers = server.ask("/runs/r001")
    assert b"&lt;script&gt;alert(1)&lt;/script&gt;" in body


def test_a_page_for_reading_states_nothing(book: SmallBook) -> None:
    before = book.journal.read_bytes()
    with served(book.folder, "--read-only") as server:
        status, body, _headers = server.ask("/api/verdicts", VERDICT)
    assert status == 403
    says(body.decode(), "--read-only")
    assert book.journal.read_bytes() == before


@pytest.mark.parametrize(
    ("given", "facts"),
    [
        ({}, "verdict"),
        (VERDICT | {"verdict": "maybe"}, "maybe"),
        (VERDICT | {"verdict": "move"}, "move"),
        (VERDICT | {"jumps": [{"signal": "ab", "anchor_s": 99.0}]}, "r003 | 99"),
        (VERDICT | {"run": "r999"}, "r999"),
    ],
)
def test_what_is_no_verdict_is_refused_in_a_sentence(
    server: Server, book: SmallBook, given: dict[str, object], facts: str
) -> None:
    before = book.journal.read_bytes()
    status, body, _headers = server.ask("/api/verdicts", given)
    assert status in (404, 422)
    says(body.decode(), *facts.split(" | "))
    assert book.journal.read_bytes() == before


def test_who_may_read_may_not_judge_with_the_same_secret(book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as judging, served(book.folder, "--read-only") as reading:
        assert reading.token != judging.token
        given = {"Cookie": f"{judging.cookie}={reading.token}"}
        assert judging.ask("/", headers=given)[0] == 403


def test_an_address_with_the_secret_leads_where_it_says(book: SmallBook) -> None:
    with served(book.folder, "--as", ADA) as server:
        _status, _body, headers = server.ask(f"/review?run=r003&token={server.token}")
        assert headers["Location"] == "/review?run=r003"
