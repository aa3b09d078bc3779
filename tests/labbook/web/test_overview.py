"""The list of runs names what `attention` lists of each, and nothing else."""

from __future__ import annotations

from pathlib import Path

from labbook.actions.runs.attention import attention
from labbook.analysis.outcomes.detection import Detections
from tests.helpers.books import ADA, small_book
from tests.helpers.web import served


def test_runs_to_look_at_are_those_of_attention(tmp_path: Path) -> None:
    book = small_book(tmp_path, ingested=False)
    with book.open() as opened, opened.reading() as connection:
        listed = attention(Detections(connection, opened.store), opened.configuration).findings
    expected = {(one.run, one.code) for one in listed if one.run is not None}
    assert expected
    with served(book.folder, "--as", ADA) as server:
        runs = {run["name"] for run in server.json("/api/runs")["runs"]}
        shown = {(run, one["code"]) for run, several in server.json("/api/attention").items() for one in several}
        one_run = min(run for run, _code in expected)
        of_one = server.json(f"/api/attention?where=run%3D{one_run}")
    assert shown == expected
    assert {run for run, _code in shown} <= runs
    assert set(of_one) == {one_run}


def test_as_many_jumps_are_to_review_as_the_review_has(tmp_path: Path) -> None:
    with served(small_book(tmp_path).folder, "--as", ADA) as server:
        runs = server.json("/api/runs")["runs"]
        queue = server.json("/api/queue")["jumps"]
    assert sum(run["to_review"] or 0 for run in runs) == len(queue) > 0
