"""The rows of `docs/statistics/weaknesses.csv`: truth, labbook, and what other programs return today."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from importlib.metadata import PackageNotFoundError, version

from benchmarks.stats_evidence.weaknesses.answers import Verdict, ours, recorded_text, theirs, verdict
from benchmarks.stats_evidence.weaknesses.case import NoNumber, Peer, Question, Weakness
from benchmarks.stats_evidence.weaknesses.registry import WEAKNESSES

LABBOOK = "labbook"


def rows(cases: Iterable[Weakness] = tuple(WEAKNESSES.values())) -> list[dict[str, str]]:
    """Ask every program anew; a row for each answer, labbook's first."""
    return [
        {"case": case.name, "title": case.title, "question": question.what, "truth": truth, "known_from": how, **answer}
        | {"values": case.data}
        for case in cases
        for question in case.questions
        for truth, how in [_truth(question)]
        for answer in _answers(question)
    ]


def _truth(question: Question) -> tuple[str, str]:
    """Return the truth and how it is known."""
    if isinstance(question.truth, NoNumber):
        return question.truth.instead, ""
    return f"{question.truth.value():.{question.digits}g}", question.truth.how


def _answers(question: Question) -> Iterator[dict[str, str]]:
    yield _answer(LABBOOK, "", ours(question.ours).text(question.digits), "right", "")
    for peer in question.others:
        yield _asked(peer, question)


def _asked(peer: Peer, question: Question) -> dict[str, str]:
    """Return another program's answer, how it stands, and whether it came without a warning or an exception."""
    print(f"   {question.what}: {peer.library} {peer.call}", file=sys.stderr, flush=True)
    answer = theirs(peer)
    standing = verdict(peer, answer, question.truth)
    if answer is None:
        return _answer(peer.library, peer.call, recorded_text(peer, question.digits), standing.value, "")
    silent = "" if standing is Verdict.MENDED else "yes" if answer.silent else "no"
    return _answer(f"{peer.library} {_version(peer)}", peer.call, answer.text(question.digits), standing.value, silent)


def _answer(program: str, call: str, answer: str, standing: str, silent: str) -> dict[str, str]:
    return {"program": program, "call": call, "answer": answer, "standing": standing, "silent": silent}


def _version(peer: Peer) -> str:
    try:
        return version(peer.library)
    except PackageNotFoundError:
        return ""
