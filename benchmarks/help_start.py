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
SMALLEST = """\
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
        script.write_text(SMALLEST, encoding="utf-8")
        say(f"{REPEATS} pairs of processes")
        works = {
            "smallest Typer app --help": Work(lambda _: run_process([sys.executable, script, "--help"])),
            "labbook --help": Work(lambda _: run_process([LABBOOK, "--help"])),
            "python -c pass": Work(lambda _: run_process([sys.executable, "-c", "pass"])),
        }
        times = in_turns(works, REPEATS, warm_ups=2)
    ours, smallest = times["labbook --help"], times["smallest Typer app --help"]
    bare = times["python -c pass"].median
    return Section(
        "Starting",
        "Whole processes in turns, from start to exit; the smallest Typer app has one command without options.",
        (
            Budget(
                "`labbook --help` over the smallest Typer app's (medians)",
                OF_SMALLEST,
                "×",
                ours.median / smallest.median,
            ),
        ),
        (
            times_table(
                times,
                "smallest Typer app --help",
                f"Python alone takes {bare * 1e3:.0f} ms of both; Typer and Rich most of the rest. No command loads "
                "numpy, pandas or SQLAlchemy before it needs them.",
            ),
        ),
    )


BENCHMARK = Benchmark("help_start", measure)
