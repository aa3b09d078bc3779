"""`labbook watch` as a process of its own, beside an instrument that writes."""

from __future__ import annotations

import contextlib
import http.client
import io
import json
import os
import queue
import shutil
import signal
import subprocess
import threading
import time
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from tests.cli.shell import LABBOOK, environment, good, labbook, process, refused, rows, unchanged
from tests.cli.test_ctrl_c import heeds_ctrl_c
from tests.helpers.books import SmallBook, instrument_files
from tests.helpers.upkeep import rebuilt_alike
from tests.helpers.wording import says

SOON_S = 10.0
"""Nothing takes so long, also on a busy machine."""
LOG = instrument_files()["logs/r001.csv"]
HALF = LOG[: LOG.index(b"\n", len(LOG) // 2) + 1]
WITHOUT_UNIT = b"t,body_height [m]\n" + b"".join(b"%d,0.3\n" % row for row in range(50))


@dataclass
class Watch:
    """A watch that runs, and the lines that it has printed so far."""

    process: subprocess.Popen[str]
    lines: queue.Queue[str]
    page: str = ""

    def until(self, wanted: Callable[[Any], bool]) -> Any:
        """Read documents until one is wanted."""
        ends_s = time.monotonic() + SOON_S
        while True:
            told = json.loads(self.lines.get(timeout=max(0.0, ends_s - time.monotonic())))
            if told["event"] == "page":
                self.page = told["url"]
            if wanted(told):
                return told

    def file(self, name: str) -> Any:
        return self.until(lambda told: told["event"] == "file" and told["file"] == name)

    def quiet(self, seconds: float) -> None:
        """Nothing is printed for so long."""
        with pytest.raises(queue.Empty):
            self.lines.get(timeout=seconds)

    def end(self) -> Any:
        self.process.send_signal(signal.SIGINT)
        assert self.process.wait(timeout=SOON_S) == 0
        return self.until(lambda told: told["event"] == "ended")


@contextlib.contextmanager
def watching(book: SmallBook, *words: str | Path) -> Iterator[Watch]:
    with subprocess.Popen(
        [LABBOOK, "watch", *words, "--json"],
        cwd=book.folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heeds_ctrl_c,
    ) as process:
        lines: queue.Queue[str] = queue.Queue()
        out = process.stdout
        assert out is not None
        reader = threading.Thread(target=lambda: [lines.put(line) for line in out])
        reader.start()
        try:
            watch = Watch(process, lines)
            watch.until(lambda told: told["event"] == "watching")
            yield watch
        finally:
            process.kill()
            reader.join()


@pytest.fixture
def inbox(tmp_path: Path) -> Path:
    folder = tmp_path / "inbox"
    folder.mkdir()
    return folder


def test_files_are_taken_in_as_they_come_and_ctrl_c_sums_up(stated: SmallBook, inbox: Path) -> None:
    good(labbook("ingest", stated.log("r002"), stated.log("r003"), at=stated.folder))
    for run in ("r001", "r002", "r003"):
        shutil.copy(stated.log(run), inbox)
    with watching(stated, inbox, stated.instruments / "charger") as watch:
        first = watch.file("r001.csv")
        assert (first["status"], first["runs"]) == ("imported", ["r001"])
        says(first["rig"], "run r001", "3 of 3 jumps")
        known = watch.until(lambda told: told["event"] == "known")
        assert sorted(known["files"]) == ["r002.csv", "r003.csv"]
        (inbox / "late").mkdir()
        (inbox / "late" / "r004.csv.part").write_bytes(stated.log("r004").read_bytes())
        (inbox / ".r005.csv").write_bytes(stated.log("r005").read_bytes())
        (inbox / "empty.csv").touch()
        watch.quiet(1.0)
        (inbox / "late" / "r004.csv.part").rename(inbox / "late" / "r004.csv")
        (now,) = [run for run in watch.file("late/r004.csv")["runs_now"] if run["run"] == "r004"]
        assert (now["jumps_found"], now["jumps_made"], now["misfires"]) == (3, 3, 0)
        assert now["joules_per_jump"] > 0
        os.utime(inbox / "late" / "r004.csv")
        watch.quiet(0.7)
        ended = watch.end()
    assert (ended["imported"], ended["known"], ended["refused"]) == (4, 2, 0)
    assert ended["left"] == ["empty.csv"]
    assert rows(stated.folder, "SELECT count(*) FROM ingest") == [(6,)]


def test_a_log_that_is_being_written_becomes_one_log(stated: SmallBook, inbox: Path) -> None:
    with watching(stated, inbox) as watch, (inbox / "r001.csv").open("wb") as log:
        log.write(HALF)
        log.flush()
        half = watch.file("r001.csv")
        assert half["status"] == "imported"
        log.write(LOG[len(HALF) :])
        log.flush()
        whole = watch.file("r001.csv")
        assert whole["replaced"]
        says(whole["rig"], "3 of 3 jumps")
        assert watch.end()["replaced"] == 1
    assert rows(stated.folder, "SELECT count(*) FROM ingest WHERE status = 'imported'") == [(1,)]
    rebuilt_alike(stated)


def test_a_refused_file_is_tried_again_when_it_or_labbook_toml_changes(stated: SmallBook, inbox: Path) -> None:
    with watching(stated, inbox) as watch:
        (inbox / "r001.csv").write_bytes(WITHOUT_UNIT)
        first = watch.file("r001.csv")
        assert first["status"] == "refused"
        (finding,) = (one for one in first["findings"] if one["rule"] == "time_unit_missing")
        says(finding["message"], "--unit t=UNIT")
        (inbox / "r001.csv").write_bytes(WITHOUT_UNIT.replace(b"\nt,", b"\nt [ms],").replace(b"t,", b"t [ms],", 1))
        assert watch.file("r001.csv")["status"] == "imported"
        (inbox / "r002.csv").write_bytes(WITHOUT_UNIT.replace(b"0.3", b"0.31"))
        assert watch.file("r002.csv")["status"] == "refused"
        toml = stated.toml.read_text()
        stated.toml.write_text(f"{toml}\n[profiles.odd\n")
        assert "labbook.toml" in watch.until(lambda told: told["event"] == "trouble")["about"]
        stated.toml.write_text(
            f'{toml}\n[profiles.odd]\nfiles = "*.csv"\n[profiles.odd.columns]\nt = {{ unit = "ms" }}\n'
        )
        assert watch.file("r002.csv")["status"] == "imported"


def test_an_archive_is_taken_in_when_its_end_is_there(stated: SmallBook, inbox: Path) -> None:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("r001.csv", LOG)
    with watching(stated, inbox) as watch, (inbox / "r001.zip").open("wb") as file:
        file.write(made.getvalue()[:-40])
        file.flush()
        watch.quiet(1.0)  # longer than a file without such an end is waited for
        file.write(made.getvalue()[-40:])
        file.flush()
        assert watch.file("r001.zip")["status"] == "imported"


def test_a_stick_that_is_taken_out_and_comes_back(stated: SmallBook, inbox: Path) -> None:
    shutil.copy(stated.log("r001"), inbox)
    with watching(stated, inbox) as watch:
        watch.file("r001.csv")
        inbox.rename(inbox.with_name("elsewhere"))
        assert watch.until(lambda told: told["event"] == "trouble")["about"] == str(inbox)
        inbox.with_name("elsewhere").rename(inbox)
        watch.until(lambda told: told["event"] == "over")
        watch.quiet(0.7)
        shutil.copy(stated.log("r002"), inbox)
        watch.file("r002.csv")


def test_once_takes_in_what_is_there_and_ends(stated: SmallBook, inbox: Path) -> None:
    nothing = good(labbook("watch", inbox, "--once", at=stated.folder))
    says(nothing.out, "0 imported")
    shutil.copy(stated.log("r001"), inbox)
    told = good(process("watch", inbox, "--once", at=stated.folder)).out
    says(told, "ok", "run r001", "3 of 3 jumps")
    says(told, "1 imported")
    with unchanged(stated.folder):
        says(good(labbook("watch", inbox, "--once", at=stated.folder)).out, "r001.csv", "imported before", "r001")
    (inbox / "r002.csv").write_bytes(WITHOUT_UNIT)
    answer = labbook("watch", inbox, "--once", at=stated.folder)
    assert answer.code == 2
    says(answer.out, "time_unit_missing", "--unit t=UNIT")


def test_the_books_own_files_are_none(stated: SmallBook) -> None:
    shutil.copy(stated.log("r001"), stated.folder)
    told = good(labbook("watch", stated.folder, "--once", "--json", at=stated.folder)).out.splitlines()
    assert [json.loads(line).get("file") for line in told] == [None, "r001.csv", None]
    again = good(labbook("watch", stated.folder, "--once", "--json", at=stated.folder)).out.splitlines()
    assert [json.loads(line).get("status") for line in again] == [None, "duplicate", None]


def test_a_reader_that_has_seen_enough_ends_it(stated: SmallBook, inbox: Path) -> None:
    with subprocess.Popen(
        [LABBOOK, "watch", inbox], cwd=stated.folder, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.readline()
        running.stdout.close()
        shutil.copy(stated.log("r001"), inbox)
        assert running.wait(timeout=SOON_S) == 0
        assert running.stderr.read() == b""


def test_wrong_use_is_a_sentence(stated: SmallBook, inbox: Path) -> None:
    refused(labbook("watch", stated.log("r001"), at=stated.folder), 2, "r001.csv", "folder")
    refused(labbook("watch", inbox / "nowhere", at=stated.folder), 2, "nowhere", "folder")
    refused(labbook("watch", inbox, "--still", "0", at=stated.folder), 2, "--still", "seconds")
    refused(labbook("watch", inbox, "--page", "--no-page", at=stated.folder), 2, "--page", "--no-page")
    refused(labbook("watch", inbox, "--as", "Nobody", at=stated.folder), 2, "Nobody", "person")


def test_a_page_beside_it_shows_what_comes_in_and_ends_with_it(stated: SmallBook, inbox: Path) -> None:
    pytest.importorskip("uvicorn")
    with watching(stated, inbox, "--page") as watch, contextlib.ExitStack() as ends:
        address = urlsplit(watch.page)
        server = http.client.HTTPConnection("127.0.0.1", address.port or 0, timeout=SOON_S)
        ends.enter_context(contextlib.closing(server))
        server.request("GET", f"{address.path}?{address.query}")
        answer = server.getresponse()
        answer.read()
        cookie = (answer.headers["Set-Cookie"] or "").partition(";")[0]
        shutil.copy(stated.log("r001"), inbox)
        watch.file("r001.csv")
        server.request("GET", "/api/live", headers={"Cookie": cookie})
        (line, *_rest) = json.loads(server.getresponse().read())["lines"]
        says(line["text"], "run r001", "3 of 3 jumps")
        server.request("GET", "/api/events", headers={"Cookie": cookie})  # a page that listens
        ends.enter_context(contextlib.closing(server.getresponse())).readline()
        watch.end()
        assert watch.process.stderr is not None
        assert watch.process.stderr.read() == ""
