"""One run: facts, files, notes, its trace with jumps and gaps, and all its jumps one over the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from starlette.responses import JSONResponse, Response

from data_schema.queries.detections import DecisionRow, WaitingVerdict
from data_schema.queries.runs import run_names
from labbook.actions.runs.jump_review import RunReview, review
from labbook.actions.runs.run_plot import drawn_log
from labbook.actions.runs.run_view import run_view, view_lines
from labbook.analysis.outcomes.run_apexes import JudgedJump, anchor_of, jumps_near
from labbook.analysis.study_data import VERTICAL_FORCE
from labbook.book.opening import Book
from labbook.terminal import plain
from labbook.web.rendering import Asked, view
from reports.display import RunLog


def _page(asked: Asked) -> Response:
    shown = run_view(asked.detections, asked.book.configuration, asked.path("name"))
    names = list(run_names(asked.connection))
    place = names.index(shown.run.name)
    before = names[place - 1] if place else None
    after = names[place + 1] if place + 1 < len(names) else None
    return asked.page(
        "run.html.j2",
        "runs",
        run=shown.run,
        lines=[line.strip() for line in view_lines(shown)[1:]],
        before=before,
        after=after,
        beside=before or after,
        has_log=isinstance(shown.jumps_found, int),
    )


def _logged(asked: Asked) -> tuple[RunReview, RunLog]:
    """Return the run that is asked for with its jumps, and what is drawn of its log."""
    found = review(asked.book, asked.connection, asked.path("name"))
    return found, drawn_log(asked.book, asked.connection, found, None)[0]


def _log(asked: Asked) -> Response:
    """Return what is drawn of a run's log beside its samples: jumps with their verdicts, and gaps."""
    found, log = _logged(asked)
    judged = {item.jump.number: item for item in found.jumps}
    jumps = [
        {
            **plain(jump),
            "decided": None if item.decision is None else plain(item.decision),
            "se_m": item.jump.apex_height_se_m,
            "flags": item.jump.flags,
            "anchor_s": anchor_of(item.before),
            "log_begins_s": jump.at_s - anchor_of(item.jump),
            "signal": item.signal_sha256,
            "why_no_apex": item.jump.undefined_reason,
            "earlier": _earlier(found, item),
        }
        for jump, item in ((jump, judged[jump.number]) for jump in log.jumps)
    ]
    return JSONResponse(
        {
            "run": log.run,
            "title": log.title,
            "jumps": jumps,
            "gaps": [plain(gap) for gap in log.gaps],
            "samples": log.time_s.size,
            "beside": list(_beside(asked.book, found, log)),
        }
    )


def _earlier(found: RunReview, item: JudgedJump) -> list[dict[str, str]]:
    """Return the verdicts that stood at a jump without one before its log, its reading or the detector changed."""
    every: list[DecisionRow | WaitingVerdict] = [*found.waiting, *found.lost]
    return [
        {"verdict": said.verdict, "person": said.person}
        for said in (every if item.decision is None else ())
        if jumps_near(said.anchor_s, [item.before])
        and (said.signal_sha256 == item.signal_sha256 or len(found.signals) == 1)
    ]


def _samples(asked: Asked) -> Response:
    """Return a log's samples, little-endian: times in s as float64, then as float32 heights in m and what is beside."""
    found, log = _logged(asked)
    data = log.time_s.astype("<f8").tobytes() + log.body_height_m.astype("<f4").tobytes()
    data += b"".join(values.astype("<f4").tobytes() for values in _beside(asked.book, found, log).values())
    return Response(data, media_type="application/octet-stream")


def _beside(book: Book, found: RunReview, log: RunLog) -> dict[str, NDArray[np.float64]]:
    """Return what a log recorded beside its height, in thousands of the unit that its title has."""
    beside = {}
    if log.leg_length_m is not None and not np.isnan(log.leg_length_m).all():
        beside["leg (mm)"] = log.leg_length_m
    if len(found.signals) == 1 and VERTICAL_FORCE in found.signals[0].channels:
        samples = book.store.samples(found.signals[0].store_path, [VERTICAL_FORCE])
        beside["force (N)"] = samples[VERTICAL_FORCE] / 1000.0
    return beside


ROUTES = [
    view("/runs/{name}", _page),
    view("/api/runs/{name}/log", _log),
    view("/api/runs/{name}/samples", _samples),
]
