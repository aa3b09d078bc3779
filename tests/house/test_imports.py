"""What loads what: statistics and pages without a database, the command's help without anything heavy."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.books import small_book

PROJECT = Path(__file__).parents[2]
HEAVY = ("numpy", "scipy", "pandas", "pyarrow", "matplotlib", "sqlalchemy", "pint", "xarray", "jinja2")
DATABASE_FREE = ("stats", "simulator", "reports")
NO_DATABASE = ("sqlalchemy", "data_schema.tables", "data_schema.queries", "data_schema.engine")


def loaded_by(code: str, names: tuple[str, ...]) -> set[str]:
    """Run code in a fresh interpreter; return which of the modules it loaded."""
    asking = f"import sys\n{code}\nprint(*[name for name in {names!r} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", asking], cwd=PROJECT, capture_output=True, text=True, check=True, timeout=60
    )
    return set(done.stdout.splitlines()[-1].split())


def everything_in(package: str) -> str:
    """Code that imports every module of a package."""
    modules = sorted(
        ".".join(path.relative_to(PROJECT).with_suffix("").parts).removesuffix(".__init__")
        for path in (PROJECT / package).rglob("*.py")
    )
    return "\n".join(f"import {module}" for module in modules)


GIVEN = """
import os
from labbook.cli.main import run
os.chdir({folder!r})
for words in {commands!r}:
    try:
        run(words)
    except SystemExit as end:
        assert not end.code
"""
HELP = [["--help"], ["ingest", "--help"], ["report", "--help"], ["runs", "--help"]]
REPORT = """
import data_schema.tables, labbook.book.opening, labbook.cli.runs, labbook.cli.views
import labbook.actions.report_command, labbook.actions.simulate.comparing_predictions
"""
LIGHT = {
    "statistics, simulator and pages": (
        "\n".join(map(everything_in, DATABASE_FREE)),
        (*NO_DATABASE, "labbook", "ingest", "matplotlib.pyplot", "tkinter"),
    ),
    "their packages": (
        f"import {', '.join(DATABASE_FREE)}",
        ("pandas", "pint", "matplotlib.pyplot", "statsmodels", "scipy.stats", "sqlalchemy", "xarray"),
    ),
    "help": (GIVEN.format(folder=str(PROJECT), commands=HELP), HEAVY),
    "configuration": ("import labbook.config.parsing", HEAVY),
    "a report without a scene, in SQLite": (
        REPORT,
        ("simulator.scene", "simulator.jump", "numba", "sqlalchemy.dialects.postgresql", "psycopg"),
    ),
    "a scene and what is published": (
        "import simulator.changes, simulator.scene_file, simulator.steady.published_results",
        ("numba", "llvmlite"),
    ),
    "a campaign without a book": (
        "import labbook.demo.files",
        (*NO_DATABASE, "labbook.book", "labbook.actions", "scipy"),
    ),
    "a list of runs": (
        "import labbook.book.opening, labbook.cli.runs",
        ("matplotlib", "pandas", "jinja2", "statsmodels", "pint", "xarray"),
    ),
}


@pytest.mark.parametrize("what", LIGHT)
def test_it_does_without(what: str) -> None:
    assert loaded_by(*LIGHT[what]) == set()


@pytest.mark.soak
def test_taking_a_log_in_does_without_pandas(tmp_path: Path) -> None:
    stated = small_book(tmp_path, ingested=False)
    code = GIVEN.format(folder=str(stated.folder), commands=[["ingest", str(stated.log("r001"))]])
    assert loaded_by(code, ("pandas", "pyarrow")) == {"pyarrow"}
