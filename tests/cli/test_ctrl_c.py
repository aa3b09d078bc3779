"""Ctrl-C ends a command with one sentence, whatever it is at: starting, importing, giving a connection back."""

from __future__ import annotations

import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import sqlalchemy as sa
from sqlalchemy import event

from data_schema.engine import sqlite_engine
from tests.cli.shell import LABBOOK, environment, good, labbook, rows
from tests.helpers.books import SmallBook

TOLD = "labbook: interrupted; what was finished before is kept, what was not is left out.\n"
MOMENTS = 60
INTERRUPTED = """
import os, signal, sys

class Interrupting:
    def __set_name__(self, owner, name):
        os.kill(os.getpid(), signal.SIGINT)

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name != interrupted:
            return
        if at_once:
            raise KeyboardInterrupt
        type("Owner", (), {"interrupting": Interrupting()})  # Python makes a RuntimeError of what comes out of it

interrupted, at_once = sys.argv.pop(), sys.argv.pop() == "import"
sys.argv.append("--help")
sys.meta_path.insert(0, Finder())
from labbook.cli.start import main
main()
"""


CUT_OFF_REPORT = """
import os, sys

def watch(event, arguments):
    if event == "os.rename" and os.fspath(arguments[1]).endswith(last):
        os.kill(os.getpid(), number)

number, last = int(sys.argv.pop(1)), sys.argv.pop(1)
sys.addaudithook(watch)
from labbook.cli.start import main
main()
"""
"""A report that gets a signal when the file of a name is put in its place."""


WAITING = """
import os, signal, sys, threading, time
from labbook.cli import main, start

class Dropped:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0)  # where the handler runs: what it raises ends here

def run():
    if sys.argv[1] == "destructor":
        Dropped()
        time.sleep(60)
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(60)
    except KeyboardInterrupt:
        if sys.argv[1] == "in order":
            threading.Thread(target=time.sleep, args=(1,)).start()  # Python waits for it as it ends
            sys.exit(0)
        time.sleep(60)  # as for a lock that nobody gives back

main.run, start.MOST_TO_END_S = run, float(sys.argv[2])
start.main()
"""
"""A command that misses a Ctrl-C, in a destructor or by itself."""


def heeds_ctrl_c() -> None:
    """Have a process interrupted by Ctrl-C, which it would ignore where the tests run in the background."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def ran(program: str, *words: str | Path, at: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a program of this file to its end."""
    return subprocess.run(
        [sys.executable, "-c", program, *words],
        cwd=at,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        preexec_fn=heeds_ctrl_c,
    )


@pytest.mark.parametrize("by", ["import", "class"])
@pytest.mark.parametrize("module", ["labbook.cli.main", "typer", "labbook.terminal"])
def test_while_it_starts(by: str, module: str) -> None:
    done = ran(INTERRUPTED, by, module)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", TOLD)


def test_while_a_connection_goes_back(stated: SmallBook, caplog: pytest.LogCaptureFixture) -> None:
    engine = sqlite_engine(stated.database)

    @event.listens_for(engine, "reset")
    def interrupt(*_given: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), engine.connect() as connection:
        connection.execute(sa.text("SELECT 1"))
    assert caplog.records == []
    event.remove(engine, "reset", interrupt)
    engine.dispose()


@pytest.mark.parametrize(
    ("number", "last", "code"),
    [
        pytest.param(signal.SIGINT, "_one_column.svg", 130, marks=pytest.mark.soak),
        (signal.SIGKILL, "report.html", -signal.SIGKILL),
    ],
)
def test_a_report_that_is_not_written_whole_is_none(
    stated: SmallBook, tmp_path: Path, number: int, last: str, code: int
) -> None:
    words = ["report", "--out", tmp_path / "paper"]
    done = ran(CUT_OFF_REPORT, str(int(number)), last, *words, at=stated.folder)
    assert done.returncode == code, done.stderr
    assert (tmp_path / "paper" / "figures").exists()
    assert not (tmp_path / "paper" / "report.html").exists()
    assert good(labbook("reports", "list", "--json", at=stated.folder)).json == []
    good(labbook(*words, at=stated.folder))
    assert (tmp_path / "paper" / "report.html").exists()
    assert len(good(labbook("reports", "list", "--json", at=stated.folder)).json) == 1


@pytest.mark.parametrize(
    ("where", "most_s", "code"), [("destructor", 50.0, 130), ("itself", 0.2, 130), ("in order", 0.2, 0)]
)
def test_it_ends_a_command_that_misses_it(where: str, most_s: float, code: int) -> None:
    done = ran(WAITING, where, str(most_s))
    assert (done.returncode, done.stdout, done.stderr) == (code, "", TOLD if code else "")


def ingesting(book: SmallBook) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [LABBOOK, "ingest", str(book.instruments / "logs"), "--json"],
        cwd=book.folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heeds_ctrl_c,
    )


@pytest.mark.soak
def test_at_any_moment(stated: SmallBook, tmp_path: Path) -> None:
    untouched = tmp_path / "untouched"
    shutil.copytree(stated.folder, untouched)
    started = time.monotonic()
    ingesting(stated).communicate(timeout=60)
    whole_s = time.monotonic() - started
    moments, interrupted = random.Random(4), 0
    for _ in range(MOMENTS):
        shutil.rmtree(stated.folder)
        shutil.copytree(untouched, stated.folder)
        running = ingesting(stated)
        time.sleep(moments.uniform(0.1, 0.9) * whole_s)  # not before Python runs, nor after the last word
        running.send_signal(signal.SIGINT)
        out, err = running.communicate(timeout=60)
        kept = len(rows(stated.folder, "SELECT uid FROM file"))
        if err:
            assert (running.returncode, out, err) == (130, "", TOLD)
            interrupted += 1
        else:
            assert kept == 12
        again = good(labbook("ingest", stated.instruments / "logs", "--json", at=stated.folder)).json
        assert [item["status"] for item in again] == ["duplicate"] * kept + ["imported"] * (12 - kept)
    assert interrupted > MOMENTS / 2
