"""What it takes to start: `labbook --help` against the smallest Typer app."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks.processes import LABBOOK, run_process
from benchmarks.section import Benchmark, Budget, Section, times_table
from benchmarks.timing import Work, in_turns

REPEATS = 21
OF_SMALLEST = 1.5
SMALLEST, OURS, BARE = "smallest Typer app --help", "labbook --help", "python -c pass"
PROGRAM = """\
import typer

app = typer.Typer()


@app.command()
def main() -> None:
    print("hello")


app()
"""


def measure(say: Callable[[str], None]) -> Section:
    """Start both whole processes in turns."""
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        script = Path(name) / "smallest.py"
        script.write_text(PROGRAM, encoding="utf-8")
        say(f"{REPEATS} pairs of processes")
        commands: dict[str, list[str | Path]] = {
            SMALLEST: [sys.executable, script, "--help"],
            OURS: [LABBOOK, "--help"],
            BARE: [sys.executable, "-c", "pass"],
        }
        times = in_turns({name: _work(words) for name, words in commands.items()}, REPEATS, warm_ups=2)
    ratio, bare = times[OURS].median / times[SMALLEST].median, times[BARE].median
    return Section(
        "Starting",
        "Whole processes in turns, from start to exit; the smallest Typer app has one command without options.",
        (Budget("`labbook --help` over the smallest Typer app's (medians)", OF_SMALLEST, "×", ratio),),
        (
            times_table(
                times,
                SMALLEST,
                f"Python alone takes {bare * 1e3:.0f} ms of both; Typer and Rich most of the rest. No command loads "
                "numpy, pandas or SQLAlchemy before it needs them.",
            ),
        ),
    )


def _work(command: list[str | Path]) -> Work:
    return Work(lambda _: run_process(command))


BENCHMARK = Benchmark("help_start", measure)
