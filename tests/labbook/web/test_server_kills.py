"""A server that is killed at any moment: a verdict that it answered is in the book, once, and the next one goes on."""

from __future__ import annotations

import http.client
import json
import random
import threading
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import sqlalchemy as sa

from data_schema.tables.runs import decision
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.commands import KILLED, Commands, Running
from tests.helpers.figures import Count, record
from tests.helpers.hopping_log import apex_s, hopping_log
from tests.helpers.upkeep import health, rebuilt_alike
from tests.helpers.web import Page, served

MISSED = 4
"""The jump of each log that no detector finds, for a client to add."""
RUNS = ("r001", "r002", "r003", "r004", "r005", "r006", "r009", "r010")
"""The runs that are judged, by a client each."""
AT_ONCE = 2
"""So many clients have the page open; the next server is for others, since a run slows down with its moved apexes."""
UNTIL_KILLED = 10_000
"""Statements that no client comes to in a round."""


class Row(NamedTuple):
    """A verdict in the book; each has a note, or a time of its apex, that no other has."""

    signal: str
    anchor_s: float
    verdict: str
    note: str | None
    at_s: float | None


@dataclass
class Asked:
    """A request that states something, and the verdicts that the book has of it where it has taken effect."""

    path: str
    data: dict[str, Any]
    rows: tuple[Row, ...]
    mark: str
    """What the journal says of this request alone."""
    takes_back: bool = False
    """Whether an added jump is gone afterwards."""
    acknowledged: bool = False

    @property
    def renumbers(self) -> bool:
        """Whether jumps have other numbers afterwards."""
        return self.takes_back or any(row.verdict == "add" for row in self.rows)


@dataclass
class Client:
    """One who judges the jumps of a run without pause, each request after the answer to the last.

    `unanswered` is the request that was under way when the server was killed; most of these are made again, as the page
    does, and others given up. `cut_off` and `written`: how often that was, and how many of these the journal has.
    """

    run: str
    chance: random.Random
    asked: list[Asked] = field(default_factory=list)
    unanswered: Asked | None = None
    unsure: bool = False
    cut_off: int = 0
    written: int = 0
    took_s: float = 0.0
    """How long the last answer took."""
    found: list[dict[str, Any]] = field(default_factory=list)
    added: dict[str, Any] | None = None
    standing: list[dict[str, Any]] = field(default_factory=list)
    """Jumps on which a verdict stands."""

    @property
    def signal(self) -> str:
        """The samples of the run's log; "" before they were read."""
        return self.found[0]["signal"] if self.found else ""

    def judge(self, page: Page, gate: threading.Barrier | None = None, calm: int = 0, most: int = UNTIL_KILLED) -> int:
        """State one thing after the other until the server is gone, or so many; returns how many were acknowledged.

        After so many `calm` ones, wait at the gate for the others: the server may be killed from then on.
        """
        before = sum(each.acknowledged for each in self.asked)
        try:
            self._look(page)
            for number in range(most):
                if gate is not None and number == calm:
                    gate.wait(30)
                self._state(page, self._next() if number else self._first(page))
        except ConnectionRefusedError:
            pass  # between two requests: the one that was refused never arrived
        except (ConnectionError, http.client.HTTPException):
            self.cut_off += self.unanswered is not None
        return sum(each.acknowledged for each in self.asked) - before

    def _first(self, page: Page) -> Asked:
        """What is new, once it is known what stands: before, what was not answered is said again, or given up."""
        last, self.unanswered = self.unanswered, None
        if last is None:
            return self._next()
        # a jump that is gone cannot be taken back again: that is refused, and not made again
        again = not last.takes_back and self.chance.random() < 0.7
        self._state(page, last if again else self._next(sure=False))
        self._look(page)  # what only the journal had has taken effect by now
        return self._next()

    def _state(self, page: Page, asked: Asked) -> None:
        if asked not in self.asked[-1:]:
            self.asked.append(asked)
        self.unanswered, since = asked, time.monotonic()
        status, body, _headers = page.ask(asked.path, asked.data)
        if status == 422 and self.unsure:  # jumps have other numbers by what only the journal had until now
            status, body, _headers = page.ask(asked.path, asked.data)
        assert status == 200, body
        self.took_s = time.monotonic() - since
        asked.acknowledged, self.unanswered, self.unsure = True, None, False
        told = json.loads(body)
        for jump in told.get("jumps", [told]):
            self._stands({"signal": jump["signal"], "anchor_s": jump["anchor_s"]}, asked.rows[0].verdict)

    def _stands(self, jump: dict[str, Any], verdict: str) -> None:
        """Take note of what a verdict changes."""
        self.standing = [other for other in self.standing if other != jump]
        if verdict != "clear":
            self.standing.append(jump)
        elif jump == self.added:
            self.added = None
        if verdict == "add":
            self.added = jump

    def _look(self, page: Page) -> None:
        """Read the jumps of the run, and what stands on them."""
        jumps = page.json(f"/api/runs/{self.run}/log")["jumps"]
        self.found, self.standing, self.added = [], [], None
        for jump in jumps:
            named = {"signal": jump["signal"], "anchor_s": jump["anchor_s"]}
            if "added" in jump["flags"]:
                self.added = named
            elif jump["why_no_apex"] is None:
                self.found.append(named)
            if jump["decided"] is not None:
                self.standing.append(named)

    def _next(self, *, sure: bool = True) -> Asked:
        """Something new; unless one is sure of what stands, nothing that depends on it."""
        known = [*self.found, self.added] if self.added and sure else self.found
        match self.chance.choice(["accept", "reject", "several", "move", *(["clear", "add"] if sure else [])]):
            case "reject":
                return self._verdict("reject", "misfire", [self.chance.choice(known)])
            case "clear" if self.standing:
                return self._verdict("clear", "other", [self.chance.choice(self.standing)])
            case "several":
                some = self.chance.sample(known, self.chance.randint(2, len(known)))
                return self._verdict("accept", "looks_right", some)
            case "move":
                jump = self.chance.choice(self.found)
                return self._apex(jump, "move", jump["anchor_s"] + self.chance.uniform(-0.02, 0.02))
            case "add" if self.added:
                return self._verdict("clear", "other", [self.added])
            case "add":
                at_s = apex_s(MISSED) + self.chance.uniform(-0.02, 0.02)
                return self._apex({"signal": self.signal, "anchor_s": at_s}, "add", at_s)
        return self._verdict("accept", "looks_right", [self.chance.choice(known)])

    def _verdict(self, verdict: str, reason: str, jumps: Sequence[dict[str, Any]]) -> Asked:
        note = f"request {len(self.asked)} on {self.run}"
        rows = tuple(Row(jump["signal"], jump["anchor_s"], verdict, note, None) for jump in jumps)
        data = {"run": self.run, "jumps": [*jumps], "verdict": verdict, "reason": reason, "note": note}
        return Asked("/api/verdicts", data, rows, json.dumps(note), verdict == "clear" and self.added in jumps)

    def _apex(self, jump: dict[str, Any], verdict: str, at_s: float) -> Asked:
        row = Row(jump["signal"], jump["anchor_s"], verdict, None, at_s)
        data = {
            "run": self.run,
            "signal": jump["signal"],
            "at_s": at_s,
            **({"jump": jump} if verdict == "move" else {}),
        }
        return Asked("/api/apexes", data, (row,), f'"at_s":{at_s!r}')

    def count(self, journal: str) -> None:
        """Take note of what the journal has of a request that was not answered."""
        if self.unanswered is not None:
            self.unsure |= self.unanswered.renumbers
            self.written += self.unanswered.mark in journal

    def check(self, kept: Sequence[Row]) -> None:
        """All that was acknowledged is there in its order, of the rest each request whole or not, and nothing else."""
        of_run = [row for row in kept if row.signal == self.signal]
        there = {*of_run}
        assert of_run == [row for each in self.asked if each.acknowledged or there & {*each.rows} for row in each.rows]


@dataclass
class Rig:
    """A book, the servers of its page, and those who judge there."""

    book: SmallBook
    commands: Commands
    clients: tuple[Client, ...]

    def serve(self) -> tuple[Running, Page]:
        told = "--json", "--no-browser", "--as", ADA, "--port", "0"
        running = self.commands.start("web", *told, "--book", self.book.folder)
        end = time.monotonic() + 30
        while not (running.output.exists() and running.output.read_text().endswith("\n")):
            assert time.monotonic() < end
            time.sleep(0.005)
        page = Page(json.loads(running.output.read_text())["url"])
        page.enter()
        return running, page

    def check(self) -> None:
        """The book is whole, and has of each client what it should."""
        assert health(self.book).problems == ()
        columns = (decision.c.signal_sha256, decision.c.anchor_s, decision.c.verdict, decision.c.note, decision.c.at_s)
        with self.book.open() as book:
            with book.session(ADA):
                pass  # what only the journal has takes effect
            with book.reading() as connection:
                kept = [Row(*row) for row in connection.execute(sa.select(*columns).order_by(decision.c.id))]
        assert {row.signal for row in kept} <= {client.signal for client in self.clients}
        for client in self.clients:
            client.check(kept)


@pytest.fixture
def book(tmp_path: Path) -> SmallBook:
    made = small_book(tmp_path / "lab", ingested=False)
    with made.open() as opened_book:
        for jumps, run in enumerate(RUNS, start=MISSED + 2):
            made.log(run).write_bytes(hopping_log(jumps, shallow=[MISSED]))
            ingest_file(opened_book, made.log(run), IngestRequest(run=run, person=ADA))
    return made


@pytest.mark.parametrize(("kills", "seed"), [(6, 1), pytest.param(200, 2, marks=pytest.mark.soak)])
def test_a_server_killed_at_any_moment_loses_no_verdict_and_takes_none_twice(
    book: SmallBook, commands: Commands, kills: int, seed: int
) -> None:
    chance = random.Random(seed)
    rig = Rig(book, commands, tuple(Client(run, random.Random(f"{seed} {run}")) for run in RUNS))
    done = died = 0
    with ThreadPoolExecutor(AT_ONCE) as threads:
        for number in range(kills):
            running, page = rig.serve()
            gate = threading.Barrier(AT_ONCE + 1)
            first = AT_ONCE * number % len(rig.clients)
            here = rig.clients[first : first + AT_ONCE]
            judging = [threads.submit(client.judge, page, gate, chance.choice([0, 1])) for client in here]
            try:
                gate.wait(30)
                slowest_s = max(client.took_s for client in here)  # on a loaded machine
                time.sleep(chance.uniform(0.0, min(max(0.3, 2 * slowest_s), 1.0)))
            finally:
                running.kill()
            died += running.wait() == KILLED
            done += sum(each.result() for each in judging)
            journal = book.journal.read_text(encoding="utf-8")
            for client in here:
                client.count(journal)
            if number % 10 == 0:
                rig.check()
        assert died == kills
        with served(book.folder, "--as", ADA) as last:
            judging = [threads.submit(client.judge, last, most=2) for client in rig.clients]
            assert all(each.result() >= 2 for each in judging)
    rig.check()
    rebuilt_alike(book)
    cut_off, written = (sum(getattr(client, name) for client in rig.clients) for name in ("cut_off", "written"))
    record(Count("verdict on the page", "kill", "SQLite", tried=kills, cut_off=cut_off, written=written))
    assert done
    assert cut_off >= max(1, kills // 4)
    assert written or kills < 100
