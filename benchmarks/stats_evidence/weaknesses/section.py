"""The table of weaknesses in `docs/statistics.md`: truth, labbook, and what other programs return today."""

from __future__ import annotations

import sys
import textwrap
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

from benchmarks.section import Table
from benchmarks.stats_evidence.prose import WIDTH, filled, table_lines
from benchmarks.stats_evidence.weaknesses.answers import Answer, Verdict, ours, recorded_text, theirs, verdict
from benchmarks.stats_evidence.weaknesses.case import NoNumber, Peer, Question, Weakness
from benchmarks.stats_evidence.weaknesses.registry import WEAKNESSES

COLUMNS = {
    "scipy, numpy, xarray": ("scipy", "numpy", "xarray"),
    "statsmodels": ("statsmodels",),
    "pingouin, scikit-learn": ("pingouin", "scikit-learn"),
}
LIBRARIES = tuple(library for libraries in COLUMNS.values() for library in libraries)


@dataclass(frozen=True, slots=True)
class Found:
    """A program's answer to one question, and how it stands."""

    peer: Peer
    answer: Answer | None
    verdict: Verdict

    def cell(self, digits: int) -> str:
        """Return call, answer, and what is to be said of it."""
        recorded = recorded_text(self.peer, digits)
        if self.answer is None:
            return f"{self.peer.call}: {recorded} (not installed)"
        text = f"{self.peer.call}: {self.answer.text(digits)}"
        if self.verdict is Verdict.AS_RECORDED:
            return text
        return f"{text} ({self.verdict.value}; recorded {recorded})"


def section(cases: Iterable[Weakness] = tuple(WEAKNESSES.values())) -> list[str]:
    """Return the section's lines of Markdown, with every program asked anew."""
    counts: Counter[Verdict] = Counter()
    rows: list[tuple[str, ...]] = []
    given: list[str] = []
    for case in cases:
        given += textwrap.wrap(f"- {case.name}, {case.title}: {case.data}.", WIDTH, subsequent_indent="  ")
        for question in case.questions:
            found = [_asked(peer, question) for peer in question.others]
            counts.update(one.verdict for one in found)
            rows.append((f"{case.name} {question.what}", *_row(question, found)))
    told = ", ".join(f"{counts[kind]} {kind.value}" for kind in Verdict if counts[kind])
    return [
        "## Where other programs err",
        "",
        *filled(
            f"Measured with {', '.join(map(_version, LIBRARIES))}. Of {sum(counts.values())} answers: {told}. An "
            "answer that is not the wrong one recorded is marked, also where a program has mended its fault. “–” "
            "stands where none was asked. “silent?” names the programs whose wrong answer came without a warning or "
            "an exception."
        ),
        "",
        *table_lines(Table(("case", "truth", "labbook", *COLUMNS, "silent?"), tuple(rows), "")),
        "",
        "The values:",
        "",
        *given,
    ]


def _asked(peer: Peer, question: Question) -> Found:
    print(f"   {question.what}: {peer.library} {peer.call}", file=sys.stderr, flush=True)
    answer = theirs(peer)
    return Found(peer, answer, verdict(peer, answer, question.truth))


def _row(question: Question, found: list[Found]) -> tuple[str, ...]:
    if isinstance(question.truth, NoNumber):
        truth = question.truth.instead
    else:
        truth = f"{question.truth.value():.{question.digits}g} ({question.truth.how})"
    cells = [
        "; ".join(one.cell(question.digits) for one in found if one.peer.library in libraries) or "–"
        for libraries in COLUMNS.values()
    ]
    return truth, ours(question.ours).text(question.digits), *cells, _silent(found)


def _silent(found: list[Found]) -> str:
    wrong = [one for one in found if one.answer is not None and one.verdict is not Verdict.MENDED]
    if not wrong:
        return "–"
    quiet = dict.fromkeys(one.peer.library for one in wrong if one.answer is not None and one.answer.silent)
    return ", ".join(quiet) or "no"


def _version(library: str) -> str:
    try:
        return f"{library} {version(library)}"
    except PackageNotFoundError:
        return f"{library} (not installed)"
