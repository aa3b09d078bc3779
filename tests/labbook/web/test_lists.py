"""Files, journal and reports on the page: what the book has, and nothing that a request names elsewhere."""

from __future__ import annotations

import html
import re
from pathlib import Path

import pytest

from data_schema.queries.history import list_reports
from labbook.actions.upkeep.journal_view import newest_commands
from tests.cli.shell import good, labbook
from tests.helpers.books import ADA, SmallBook, reported_book, small_book
from tests.helpers.web import Server, served


def text_of(server: Server, path: str) -> str:
    status, body, _headers = server.ask(path)
    assert status == 200, body
    return html.unescape(re.sub(r"\s+", " ", re.sub("<[^>]*>", " ", body.decode())))


def test_a_refused_file_stands_with_what_is_wrong_until_it_comes_in(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    log = tmp_path / "late log.csv"
    log.write_text("no numbers\nat all\n")
    with served(book.folder, "--as", ADA) as server:
        before = text_of(server, "/files")
        assert "Refused" not in before
        assert all(f"{run}.csv" in before for run in ("r001", "r002", "r003"))
        assert labbook("ingest", log, at=book.folder).code == 2
        refused = text_of(server, "/files")
        assert "late log.csv" in refused
        assert "No line is a row of numbers" in refused
        assert [file["wrong"] != "" for file in server.json("/api/live")["files"][:2]] == [True, False]
        log.write_bytes(book.log("r001").read_bytes().replace(b"0", b"1", 1))
        labbook("ingest", log, at=book.folder)
        assert "Refused" not in text_of(server, "/files")


def test_a_file_shows_how_it_was_read(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    with served(book.folder, "--as", ADA) as server:
        _status, body, _headers = server.ask("/files")
        link = re.search(r'href="(/files/[^"]+)">r002\.csv<', body.decode())
        assert link is not None
        found = text_of(server, link[1])
        assert "delimited_log" in found
        assert "samples" in found
        assert server.ask("/files/nothing")[0] == 404


def test_the_journal_has_every_entry_once(tmp_path: Path) -> None:
    book = reported_book(tmp_path)
    with book.open() as opened, opened.reading() as connection:
        seen, before = list[int](), None
        while found := newest_commands(connection, 7, before):
            for one in found:
                seen += range(one.last, one.first - 1, -1)
            before = found[-1].first
        assert seen == list(range(seen[0], 0, -1))
        assert newest_commands(connection, 10**6)[0].last == seen[0]


def test_what_was_stated_stands_in_the_journal_escaped(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    for words in (
        ("note", "r003", "<script>alert(1)</script>"),
        ("jumps", "reject", "r003", "2", "--reason", "misfire"),
        ("jumps", "accept", "r003", "1-2"),
        ("correct", "r001", "mah=123", "--why", "the display's <8>"),
        ("void", "r002", "--why", "wrong foot"),
    ):
        good(labbook(*words, at=book.folder))
    with served(book.folder, "--as", ADA) as server:
        _status, body, _headers = server.ask("/journal")
        assert b"<script>alert" not in body
        found = text_of(server, "/journal")
        for part in ("noted: <script>alert(1)</script>", "rejected a jump (misfire)", "accepted 2 jumps",
                     "to 123 the display's <8>", "declared void wrong foot", ADA):  # fmt: skip
            assert part in found
        assert "took in" not in text_of(server, "/journal?before=3")
        for wrong in ("x", "0", "-1", "9" * 19, "9" * 5000):
            assert server.ask(f"/journal?before={wrong}")[0] == 422
            assert server.ask(f"/files?page={wrong}")[0] == 422


def test_every_file_of_a_report_is_served_as_it_is(reported: SmallBook) -> None:
    with reported.open() as opened, opened.reading() as connection:
        (made,) = list_reports(connection)
    assert "report.html" in made.files
    with served(reported.folder, "--as", ADA) as server:
        assert made.uid in text_of(server, "/reports")
        for name in made.files:
            status, body, headers = server.ask(f"/reports/{made.uid}/{name}")
            assert (status, body) == (200, (reported.folder / made.folder / name).read_bytes())
            assert "default-src 'none'" in (headers["Content-Security-Policy"] or "")
            assert "unsafe-inline" not in (headers["Content-Security-Policy"] or "").partition("script-src")[2]


@pytest.mark.parametrize(
    "name",
    ["nothing.html", "../../labbook.toml", "%2e%2e/%2e%2e/labbook.toml", "/etc/passwd", "..%2f..%2flabbook.toml"],
)
def test_no_other_file_is_served(reported: SmallBook, name: str) -> None:
    with served(reported.folder, "--as", ADA) as server:
        status, body, _headers = server.ask(f"/reports/1/{name}")
        assert status in (404, 400)
        assert b"[study]" not in body
        assert b"root:" not in body


def test_a_report_that_was_changed_is_not_shown_as_one(reported: SmallBook) -> None:
    book = reported
    with book.open() as opened, opened.reading() as connection:
        (made,) = list_reports(connection)
    page = book.folder / made.folder / "report.html"
    page.chmod(0o644)
    page.write_text(page.read_text() + "<script>fetch('/api/verdicts')</script>")
    with served(book.folder, "--as", ADA) as server:
        status, body, _headers = server.ask("/reports/1/report.html")
        assert status == 422
        assert b"not as it was written" in body


def test_a_study_is_made_when_it_is_opened(reported: SmallBook) -> None:
    with served(reported.folder, "--as", ADA) as server:
        assert server.ask("/studies/nonsense")[0] == 404
        status, body, _headers = server.ask("/studies/bed")
        assert (status, b"<svg" in body) == (200, True)


def test_what_differs_between_two_runs(reported: SmallBook) -> None:
    with served(reported.folder, "--as", ADA) as server:
        told = labbook("runs", "diff", "r001", "r002", at=reported.folder)
        shown = text_of(server, "/diff?first=r001&second=r002")
        for line in told.out.splitlines()[1:]:
            for cell in re.split(r"\s{2,}", line.strip()):
                assert re.sub(r"\s+", " ", cell) in shown
        assert server.ask("/diff?first=r001&second=r999")[0] == 404
        assert server.ask("/diff?first=r001")[0] == 422
