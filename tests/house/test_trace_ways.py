"""The ways through the house are traced as docs/architecture.md says: real commands, without imports."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

PROJECT = Path(__file__).parents[2]


def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("trace_ways", PROJECT / "scripts" / "trace_ways.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.soak
def test_listing_runs_enters_what_it_needs_and_calls_nothing_upward() -> None:
    ways = script()
    calls = ways.calls_of(ways.WAYS["runs"])
    files = {entered for _origin, entered in calls}
    assert {"labbook/cli/runs.py", "data_schema/queries/runs.py"} <= files
    assert "labbook/cli/statements.py" not in files  # it is only put into the list of commands
    assert ways.upward(calls) == []


def test_a_call_goes_upward_where_its_target_lies_in_a_higher_layer() -> None:
    up = [("stats/energy.py", "reports/page/writing.py"), ("labbook/analysis/study.py", "labbook/cli/common.py")]
    level = [("ingest/read.py", "stats/energy.py"), ("reports/page/writing.py", "reports/display.py")]
    down = [
        ("labbook/cli/statements.py", "labbook/book/opening.py"),
        ("labbook/cli/statements.py", "data_schema/engine.py"),
    ]
    assert script().upward([*up, *level, *down]) == up
