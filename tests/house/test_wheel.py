"""What is installed: exactly the six packages with their templates, and nothing of the tests."""

from __future__ import annotations

import importlib.util
import itertools
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]
PACKAGES = ("data_schema", "ingest", "labbook", "reports", "simulator", "stats")


@pytest.mark.skipif(importlib.util.find_spec("hatchling") is None, reason="building the wheel needs hatchling")
def test_wheel_holds_the_six_packages_whole_and_nothing_else(tmp_path: Path) -> None:
    code = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"
    built = subprocess.run(
        [sys.executable, "-c", code, tmp_path], cwd=PROJECT, capture_output=True, text=True, check=True, timeout=60
    )
    with zipfile.ZipFile(tmp_path / built.stdout.split()[-1]) as wheel:
        names = set(wheel.namelist())
        entry = next(name for name in names if name.endswith("entry_points.txt"))
        assert "labbook = labbook.cli.start:main" in wheel.read(entry).decode()
    inside = {name for name in names if ".dist-info/" not in name}
    there = {
        str(path.relative_to(PROJECT))
        for package in PACKAGES
        for path in (PROJECT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert inside == there
    assert {"reports/templates/report.html.j2", "reports/templates/report.css"} <= inside


def test_everything_that_is_needed_is_pinned() -> None:
    declared = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
    needed = [*declared["dependencies"], *itertools.chain(*declared["optional-dependencies"].values())]
    lines = (PROJECT / "constraints.txt").read_text().split()
    wanted, pinned = ({re.split(r"[>=[]", line)[0].lower().replace("_", "-") for line in of} for of in (needed, lines))
    assert wanted - pinned == set()
