"""The digits in docs/statistics.md are those that the libraries and labbook have today."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from itertools import takewhile
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]
DOCUMENT = PROJECT / "docs" / "statistics.md"
OTHER_PROCESSOR = 2.5
"""Digits that linear algebra for another processor may move of another program's number: 1.9 of five kernels tried."""


def digits_section() -> list[str]:
    code = "from benchmarks.stats_evidence.document import measured; print(measured('digits'))"
    done = subprocess.run([sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def cells(line: str) -> list[str]:
    return [cell.strip(" -") for cell in line.split("|")]


def close(written: str, now: str) -> bool:
    if written == now:
        return True
    found = [0.0 if cell == "none" else float(cell) for cell in (written, now)]
    return abs(found[0] - found[1]) <= OTHER_PROCESSOR


@pytest.mark.skipif(importlib.util.find_spec("pingouin") is None, reason="comparing with pingouin needs it")
def test_the_digits_come_out_as_they_are_written() -> None:
    text = DOCUMENT.read_text(encoding="utf-8").splitlines()
    first = text.index("<!-- section: digits -->")
    written = list(takewhile(lambda line: line != "<!-- end of digits -->", text[first + 1 :]))
    now = digits_section()
    assert len(written) == len(now)
    of_labbook = 0
    for line, again in zip(written, now, strict=True):
        if not line.startswith("|"):
            assert line == again
        elif line.startswith("| labbook"):
            assert line == again
            assert all(float(cell) == 15.0 for cell in cells(line)[2:-1])
            of_labbook += 1
        else:
            assert all(map(close, cells(line), cells(again))), (line, again)
    assert of_labbook == 9
