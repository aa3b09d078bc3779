"""Real `labbook` processes that can be started together and killed at any moment."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
KILLED = -signal.SIGKILL
"""The exit code of a process that was killed."""


@dataclass(frozen=True, slots=True)
class Running:
    """A command that has been started."""

    server: Commands
    pid: int
    output: Path

    def kill(self) -> None:
        """Send SIGKILL; nothing happens if the command has finished already."""
        os.kill(self.pid, signal.SIGKILL)

    def wait(self) -> int:
        """Return the exit code, negative for a signal; to be asked once."""
        code: int = self.server.ask({"wait": self.pid})
        return code


@dataclass(frozen=True, slots=True)
class Commands:
    """Starts commands of the command line."""

    process: subprocess.Popen[str]
    folder: Path
    numbers: Iterator[int] = field(default_factory=count)

    def start(
        self,
        *words: str | Path,
        die_after_sync: int = 0,
        of: str | None = None,
        die_before_rename: int = 0,
        largest_file: int = 0,
        failing: Mapping[str, Any] | None = None,
    ) -> Running:
        """Start a command; it dies right after its nth sync to the disk, of files called `of` where that is given.

        With `die_before_rename` it dies before it renames for the nth time; with `largest_file`, writing to a file
        beyond that many bytes fails, as on a full disk. What `failing` holds, `tests.helpers.failing_calls` tells.
        """
        output = self.folder / f"output-{next(self.numbers)}"
        request = {
            "words": list(map(str, words)),
            "die_after_sync": die_after_sync,
            "of": of,
            "die_before_rename": die_before_rename,
            "largest_file": largest_file,
            "failing": failing,
            "output": str(output),
        }
        return Running(self, self.ask(request), output)

    def run(self, *words: str | Path, **how: Any) -> tuple[int, str]:
        """Run a command to its end, started as by `start`; returns its exit code and what it printed."""
        running = self.start(*words, **how)
        return running.wait(), running.output.read_text()

    def ask(self, request: dict[str, Any]) -> Any:
        """Send one request and return the answer."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())


@contextlib.contextmanager
def running_commands(under: Sequence[str] = ()) -> Iterator[Commands]:
    """Have commands started quickly until the end of the block, `under` another program where one is given."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    environment.pop("LABBOOK_AS", None)
    with (
        tempfile.TemporaryDirectory(prefix="labbook-output-") as folder,
        subprocess.Popen(
            [*under, sys.executable, "-m", "tests.helpers.command_server"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            env=environment,
        ) as process,
    ):
        yield Commands(process, Path(folder))
        assert process.stdin is not None
        process.stdin.close()
