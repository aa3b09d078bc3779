"""One run with its trace; jumps one at a time, judged by keyboard: verdicts are stated, read back, and then shown."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from starlette.responses import JSONResponse, Response

from data_schema import journal
from data_schema.errors import UsageError
from data_schema.queries.detections import DecisionRow, WaitingVerdict
from data_schema.queries.runs import run_names
from data_schema.vocabulary import ReasonCode, ReviewOrder, Verdict
from labbook.actions.runs.jump_review import (
    QueuedJump,
    RunReview,
    add,
    agreement,
    decide,
    judged_now,
    judging,
    move,
    review,
    review_queue,
)
from labbook.actions.runs.run_plot import drawn_log
from labbook.actions.runs.run_view import run_view, view_lines
from labbook.analysis.outcomes.run_apexes import JudgedJump, anchor_of, jumps_near
from labbook.analysis.study_data import VERTICAL_FORCE
from labbook.book.opening import Book
from labbook.terminal import plain
from labbook.web.book import OpenBook
from labbook.web.rendering import Asked, stating, view
from reports.display import RunLog

_DIFFERENCES = "differences"
"""In place of an order: the jumps on which two people differ."""
_SEED = 1
"""Of a shuffled order for which none is given."""


def reason_keys(reasons: Iterable[str]) -> dict[str, str]:
    """Return the reasons to reject a jump by their keys: a reason's first letter that none before it has.

    The last is the other one, at `o`, wherever it is listed.
    """
    found: dict[str, str] = {}
    for reason in reasons:
        if reason != ReasonCode.OTHER:
            found[next(sign for sign in reason if sign.isalpha() and sign != "o" and sign not in found)] = reason
    return {**found, "o": str(ReasonCode.OTHER)}


def _page(asked: Asked) -> Response:
    offered = reason_keys(asked.book.configuration.protocol.reject_reasons)
    reasons = [{"key": key, "reason": reason, "text": reason.replace("_", " ")} for key, reason in offered.items()]
    shown = {"reasons": reasons, "orders": [*ReviewOrder, _DIFFERENCES], "run": asked.given("run") or ""}
    order = asked.given("order") or ReviewOrder.DOUBT
    agreed = agreement(asked.detections, asked.book.configuration) if order == _DIFFERENCES else ()
    sentences = [" ".join(one.sentences) for one in agreed]
    return asked.page("review.html.j2", "review", order=order, agreement=sentences, **shown)


def _queue(asked: Asked) -> Response:
    """Return the jumps in the order asked for: run, number, why it is doubtful, and whether a verdict stands."""
    run, detections, configuration = asked.given("run"), asked.detections, asked.book.configuration
    jumps: Collection[QueuedJump]
    if asked.given("order") == _DIFFERENCES:  # the jumps on which two people differ
        differing = (one for pair in agreement(detections, configuration) for one in pair.differ)
        jumps = {(one.signal_sha256, one.anchor_s): one for one in differing}.values()
    else:
        try:
            order = ReviewOrder.RUN if run else ReviewOrder(asked.given("order") or ReviewOrder.DOUBT)
            seed = int(asked.given("seed") or _SEED) if order is ReviewOrder.SHUFFLED else None
        except ValueError:
            orders = ", ".join([*ReviewOrder, _DIFFERENCES])
            raise UsageError(f"the order is one of {orders}, and a seed a whole number: correct the address.") from None
        jumps = review_queue(detections, configuration, order, seed, asked.given("where")).jumps
    rows = []
    for one in (one for one in jumps if run in (None, one.run)):
        own = [said.verdict for said in one.verdicts if said.person == asked.served.person]
        rows.append(
            {
                "run": one.run,
                "number": one.number,
                "signal": one.signal_sha256,
                "anchor_s": one.anchor_s,
                "doubts": [reason.words for reason in one.reasons],
                "left_out": one.excluded is not None,
                "decided": bool(own),
                "rejected": Verdict.REJECT in own,
            }
        )
    return JSONResponse({"jumps": rows, "entries": asked.last_entry})


_VERDICTS = (Verdict.ACCEPT, Verdict.REJECT, Verdict.CLEAR)
_Anchor = tuple[str, float]
"""What a verdict is tied to, and a jump is named by: its samples, and the time at which it was found."""


def _anchor(jump: Mapping[str, Any]) -> _Anchor:
    return str(jump["signal"]), float(jump["anchor_s"])


def _number(found: RunReview, anchor: _Anchor) -> int:
    """Return the number that a jump has now: others may have been added since the page was read."""
    for item in found.jumps:
        if (item.signal_sha256, anchor_of(item.before)) == anchor:
            return item.jump.number
    raise UsageError(
        f"run {found.run.name} has no jump at {anchor[1]:g} s any more: reload the page, which has those of now."
    )


def _decide(book: OpenBook, given: Mapping[str, Any]) -> dict[str, Any]:
    """State a verdict on jumps of a run, and return how they stand when read again."""
    current = book.current()
    try:
        name, jumps = str(given["run"]), [dict(jump) for jump in given["jumps"]]
        verdict, reason, note = Verdict(given["verdict"]), str(given["reason"]), given.get("note")
        anchors = [_anchor(jump) for jump in jumps]
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError(f"this is no verdict ({error}): give run, jumps, verdict and reason.") from error
    if verdict not in _VERDICTS:
        raise UsageError(f"{verdict} is no verdict on a jump that is there: give {', '.join(_VERDICTS)}.")
    with judging(current, book.person, name) as (session, found):
        numbers = [_number(found, anchor) for anchor in anchors]
        if "undo" in given:
            found = judged_now(current, session, name, found)
            _refuse_undo_of_other(found, numbers, book.person, given["undo"])
        text = str(note) if note else None
        decide(current, session, name, numbers, verdict, reason, text, found, blind=given.get("blind") is True)
    with current.reading() as connection:
        found, entries = review(current, connection, name), journal.head(connection)[0]
    now = {item.jump.number: item for item in found.jumps}
    return {
        "run": name,
        "entries": entries,
        "jumps": [
            {
                **jump,
                "excluded": now[number].excluded or "",
                "decided": None if (said := now[number].decision) is None else plain(said),
            }
            for jump, number in zip(jumps, numbers, strict=True)
        ],
    }


def _refuse_undo_of_other(found: RunReview, numbers: Collection[int], person: str, undone: Mapping[str, Any]) -> None:
    """Refuse to take back another verdict than the one that was given on this page, be it one's own of another page."""
    for item in found.jumps:
        stands = item.decision
        if item.jump.number not in numbers or stands is None:
            continue
        if stands.person != person:
            raise UsageError(
                f"what stands of jump {item.jump.number} is {stands.person}'s verdict, which is not undone here."
            )
        if (stands.verdict, stands.reason_code) != (undone.get("verdict"), undone.get("reason")):
            raise UsageError(f"jump {item.jump.number} was judged anew on another page: that is not undone here.")


def _put(book: OpenBook, given: Mapping[str, Any]) -> dict[str, Any]:
    """State where the apex of a jump is, or that there is one that the detector missed, in s of one log of the run."""
    current, blind = book.current(), given.get("blind") is True
    try:
        name, at_s, jump, sha256 = str(given["run"]), float(given["at_s"]), given.get("jump"), str(given["signal"])
        anchor = None if jump is None else _anchor(jump)
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError(f"this is no place of an apex ({error}): give run, signal, at_s, jump to move one.") from error
    with judging(current, book.person, name) as (session, found):
        logs = [signal.sha256 for signal in found.signals]
        if sha256 not in logs:
            raise UsageError(f"run {name} has no log with these samples now: load the page again.")
        if anchor is None:
            log = logs.index(sha256) + 1
            item, _stated = add(current, session, name, at_s, ReasonCode.OTHER, None, found, log=log, blind=blind)
        else:
            moved = _number(found, anchor)
            item, _stated = move(current, session, name, moved, at_s, ReasonCode.WRONG_APEX, None, found, blind=blind)
    return {"run": name, "signal": item.signal_sha256, "anchor_s": anchor_of(item.before)}


def _run(asked: Asked) -> Response:
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
    view("/review", _page),
    view("/api/queue", _queue),
    stating("/api/verdicts", _decide),
    stating("/api/apexes", _put),
    view("/runs/{name}", _run),
    view("/api/runs/{name}/log", _log),
    view("/api/runs/{name}/samples", _samples),
]
