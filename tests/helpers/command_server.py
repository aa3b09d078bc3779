"""Runs `labbook` commands as processes of their own, without the second that loading it takes each time.

Started by `tests.helpers.commands`: everything is imported once, each command is a fork. Requests and answers are
lines of JSON. A command can be told to die by SIGKILL right after it has synced its nth file to the disk, or its nth of
a certain name, or before it renames for the nth time: the moments that crash safety is about; or that no file may grow
beyond a size, as on a full disk; or that one of its system calls fails. What labbook does until then is its own doing.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import json
import os
import resource
import signal
import sys
from pathlib import Path
from typing import Any, NoReturn

import matplotlib.backends.backend_svg
import mpmath
import pandas as pd
import pyarrow.compute
import pyarrow.csv
import pyarrow.pandas_compat
import pyarrow.parquet

import labbook.actions.report_command
import labbook.actions.upkeep.health
import labbook.analysis.study
import labbook.book.copies.backing_up
import labbook.book.rebuilding
import labbook.cli.book
import labbook.cli.db
import labbook.cli.ingest_lines
import labbook.web.serving
import reports.figures.log
from labbook.cli.main import run

LOADED = (
    matplotlib.backends.backend_svg,
    mpmath,
    pd,
    pyarrow.compute,
    pyarrow.csv,
    pyarrow.pandas_compat,
    pyarrow.parquet,
    labbook.analysis.study,
    labbook.cli.ingest_lines,
    labbook.book.rebuilding,
    labbook.actions.report_command,
    labbook.actions.upkeep.health,
    labbook.book.copies.backing_up,
    labbook.cli.book,
    labbook.cli.db,
    reports.figures.log,
    labbook.web.serving,
)


def main() -> None:
    """Answer requests until the input ends."""
    with contextlib.suppress(SystemExit), Path(os.devnull).open("w") as nowhere, contextlib.redirect_stderr(nowhere):
        run(["ingest", "nothing", "--book", os.devnull])  # what loads a command's options is loaded by the first one
    gc.freeze()  # what is loaded is shared with the forks, not copied by their collector
    for line in sys.stdin:
        request = json.loads(line)
        if "wait" in request:
            _pid, status = os.waitpid(request["wait"], 0)
            answer = os.waitstatus_to_exitcode(status)
        else:
            answer = os.fork()
            if answer == 0:
                _command(request)
        print(json.dumps(answer), flush=True)


def _command(request: dict[str, Any]) -> NoReturn:
    silence = os.open(os.devnull, os.O_RDWR)
    output = os.open(request["output"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(silence, 0)
    os.dup2(output, 1)
    os.dup2(output, 2)
    if request["largest_file"]:
        resource.setrlimit(resource.RLIMIT_FSIZE, (request["largest_file"], resource.RLIM_INFINITY))
    if request["die_after_sync"]:
        _die_after_sync(request["die_after_sync"], request["of"])
    if request["die_before_rename"]:
        _die_before_rename(request["die_before_rename"])
    if request["failing"]:
        _fail_call(request["failing"])
    code: object = 1
    try:
        run(request["words"])
    except SystemExit as end:
        code = end.code
    sys.stdout.flush()
    os._exit(code if isinstance(code, int) else 0)  # taking the interpreter down would take longer than the command


def _die_after_sync(number: int, of: str | None) -> None:
    sync, left = os.fsync, number

    def sync_and_die(descriptor: int) -> None:
        nonlocal left
        sync(descriptor)
        if of is None or Path(f"/proc/self/fd/{descriptor}").readlink().name == of:
            left -= 1
            if left == 0:
                os.kill(os.getpid(), signal.SIGKILL)

    setattr(os, "fsync", sync_and_die)  # noqa: B010 - what is put there takes descriptors only


def _fail_call(failing: dict[str, Any]) -> None:
    fail_call = ctypes.CDLL(None).fail_call  # of failing_calls.c, which this process must have been started with
    below, log = os.fsencode(failing["below"]), os.fsencode(failing["log"])
    assert fail_call(ctypes.c_long(failing["number"]), failing["error"], failing["stays"], below, log) >= 0


def _die_before_rename(number: int) -> None:
    left = number

    def watch(event: str, _arguments: object) -> None:
        nonlocal left
        if event == "os.rename":
            left -= 1
            if left == 0:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(watch)


if __name__ == "__main__":
    main()
