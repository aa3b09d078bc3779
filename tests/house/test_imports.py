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


def test_statistics_simulator_and_pages_work_without_a_database_or_a_window() -> None:
    code = "\n".join(map(everything_in, DATABASE_FREE))
    unwanted = (*NO_DATABASE, "labbook", "ingest", "matplotlib.pyplot", "tkinter")
    assert loaded_by(code, unwanted) == set()


def test_importing_them_is_light() -> None:
    unwanted = ("pandas", "pint", "matplotlib.pyplot", "statsmodels", "scipy.stats", "sqlalchemy", "xarray")
    assert loaded_by(f"import {', '.join(DATABASE_FREE)}", unwanted) == set()


HELP = """
from labbook.cli.main import run
for words in (["--help"], ["ingest", "--help"], ["report", "--help"], ["runs", "--help"]):
    try:
        run(words)
    except SystemExit as end:
        assert not end.code
"""


def test_help_loads_nothing_heavy() -> None:
    assert loaded_by(HELP, HEAVY) == set()


def test_configuration_is_read_without_database_or_arrays() -> None:
    assert loaded_by("import labbook.config.parsing", HEAVY) == set()


def test_a_report_loads_the_simulator_only_where_a_scene_is_named_and_no_postgresql_for_sqlite() -> None:
    modules = "report_command", "simulate.comparing_predictions"
    code = "import data_schema.tables, labbook.book.opening, labbook.cli.runs, labbook.cli.views"
    unwanted = ("simulator.scene", "simulator.jump", "numba", "sqlalchemy.dialects.postgresql", "psycopg")
    found = loaded_by(
        "\n".join([code, *(f"import labbook.actions.{name}" for name in modules)]),
        (*unwanted, "sqlalchemy.dialects.sqlite"),
    )
    assert found == {"sqlalchemy.dialects.sqlite"}


def test_a_scene_and_what_is_published_are_read_without_a_compiler() -> None:
    code = "import simulator.changes, simulator.scene_file, simulator.steady.published_results"
    assert loaded_by(code, ("numba", "llvmlite")) == set()


def test_a_campaign_is_drawn_without_a_book() -> None:
    assert loaded_by("import labbook.demo.files", (*NO_DATABASE, "labbook.book", "labbook.actions", "scipy")) == set()


def test_listing_runs_draws_nothing() -> None:
    code = "import labbook.book.opening, labbook.cli.runs"
    assert loaded_by(code, ("matplotlib", "pandas", "jinja2", "statsmodels", "pint", "xarray")) == set()


@pytest.mark.soak
def test_taking_a_log_in_does_without_pandas(tmp_path: Path) -> None:
    stated = small_book(tmp_path, ingested=False)
    code = f"""
import os
os.chdir({str(stated.folder)!r})
from labbook.cli.main import run
try:
    run(["ingest", {str(stated.log("r001"))!r}])
except SystemExit as end:
    assert not end.code
"""
    assert loaded_by(code, ("pandas", "pyarrow")) == {"pyarrow"}
