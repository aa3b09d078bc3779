"""The order of the page: the answer on one sheet, then results and how they were got; all else folded below.

Also what a report used and names: software with versions, methods with their sources, as a sentence and as BibTeX.
"""

from __future__ import annotations

import importlib.resources
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.claims import group_claim, groups_in_one_sentence
from reports.display import in_sentence, list_text, true_minus
from reports.figures.registry import figures_of
from reports.naming import control_name, gains_text, swept_factor, title_of
from reports.results import StudyResults
from reports.tables.each_run import run_anchors
from reports.tables.formats import latex_text
from reports.tables.predictions import PREDICTED, prediction_sentences, verdict_text
from reports.trust import flow_sentence, review_sentence, sentences_on_rules, trust_sentences


@dataclass(frozen=True, slots=True)
class Paragraph:
    """A paragraph and the provenance ids of its numbers; `lead` is the sentence that opens the page."""

    text: str
    provenance: tuple[str, ...] = ()
    lead: bool = False


@dataclass(frozen=True, slots=True)
class Bullets:
    """Sentences one under the other, each with the provenance ids of its numbers."""

    items: tuple[Paragraph, ...]


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading within a section."""

    text: str


@dataclass(frozen=True, slots=True)
class FigureHere:
    """The place of a figure of the registry."""

    name: str


@dataclass(frozen=True, slots=True)
class FiguresBeside:
    """The place of figures side by side, each as wide as one column of a paper."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TableHere:
    """The place of a table of the registry."""

    name: str


Part: TypeAlias = Paragraph | Bullets | Heading | FigureHere | FiguresBeside | TableHere


@dataclass(frozen=True, slots=True)
class Section:
    """A section of the page; `anchor` is what the contents link to. What is `folded` a reader opens where wanted."""

    anchor: str
    title: str
    parts: tuple[Part, ...]
    folded: bool = False


def sections_of(results: StudyResults) -> tuple[Section, ...]:
    """Return the sections of the page in reading order; a section without parts is left out."""
    tests = (*(f"tests_{outcome.key}" for outcome in results.outcomes), "tests_jumps", "anovas")
    each_run = _tables("each_run") if run_anchors(results) else ()
    robustness = (FigureHere("sensitivity"), *_said(*sentences_on_rules(results)))
    sections = (
        Section("answer", "Answer", _answer(results)),
        Section("results", "Results", _results(results)),
        Section("predicted", "Predicted and measured", _predicted(results)),
        Section("robustness", "Robustness", robustness if results.pooled else ()),
        Section("plan", "Plan and deviations", _plan(results)),
        Section("methods", "Methods", _methods(results)),
        *(_outcome_in_full(results, outcome) for outcome in results.outcomes),
        Section("tests", "The thesis's tests", (*_said(_TESTS if results.comparisons else ""), *_tables(*tests)), True),
        Section("predictions", "Predictions in full", _predictions_in_full(results), True),
        Section("certainty", "Uncertainty, drain, packs, order of the day", _certainty(results), True),
        Section("measured", "Days and runs", (*_tables("flow", "days"), *each_run), True),
        Section("provenance", "Provenance", _tables("provenance") if results.provenance else (), True),
    )
    drawn = [kind for kind in figures_of(results) if kind.section and kind.absent(results) is None]
    full = (
        replace(one, parts=(*one.parts, *(FigureHere(kind.name) for kind in drawn if kind.section == one.anchor)))
        for one in sections
    )
    return tuple(section for section in full if section.parts)


_TESTS = (
    "Beside the tests that decide stand the thesis's own (5.2.1), as published. They take runs for independent, "
    "whatever their days, and nothing is claimed from them."
)


def _said(*texts: str) -> tuple[Part, ...]:
    return tuple(Paragraph(text) for text in texts if text)


def _tables(*names: str) -> tuple[Part, ...]:
    return tuple(map(TableHere, names))


def _listed(texts: Sequence[str]) -> tuple[Part, ...]:
    return (Bullets(tuple(map(Paragraph, texts))),) if texts else ()


def _answer(results: StudyResults) -> tuple[Part, ...]:
    """The first sheet: the answer, the groups, both outcomes drawn, what came of the runs, how far to trust it."""
    leads = results.claims if len(results.claims) == 2 else results.claims[:1]
    claims = [Paragraph(claim.text, claim.provenance, lead=claim in leads) for claim in results.claims]
    if not claims:
        claims = [Paragraph(f"Nothing is claimed from this selection: {_why_no_claim(results)}.", lead=True)]
    return (
        *claims,
        TableHere("headlines"),
        FiguresBeside(tuple(f"{outcome.key}_by_level" for outcome in (Outcome.JOULES, Outcome.APEX))),
        Paragraph(" ".join(filter(None, (flow_sentence(results), review_sentence(results))))),
        *_listed(trust_sentences(results)),
    )


def _why_no_claim(results: StudyResults) -> str:
    swept = swept_factor(results)
    if not results.conditions:
        return "none of its runs has joules or apex heights"
    if swept is None:
        return (
            "no factor names a control level, so nothing is compared with a control (write `control = ...` under a "
            "[factors.NAME] of labbook.toml)"
        )
    return (
        f"no group of its conditions has runs of both {control_name(results)} and another level of the "
        f"{in_sentence(title_of(swept))}"
    )


def _results(results: StudyResults) -> tuple[Part, ...]:
    """Each group in a sentence, outcome by outcome; page one has the first two drawn."""
    parts: list[Part] = []
    for outcome in results.outcomes:
        together = groups_in_one_sentence(results, outcome)
        found: list[Part] = [Paragraph(together)] if together else _each_group(results, outcome)
        if outcome not in (Outcome.JOULES, Outcome.APEX):
            found.append(FigureHere(f"{outcome.key}_by_level"))
        if outcome.has_savings:
            found.append(FigureHere("savings"))
        if outcome.has_equivalence:
            found += _said(results.no_equivalence)
        if found:
            parts += [Heading(outcome.heading), *found]
    if _contrasts_planned(results):
        parts += [Heading("What the saving depends on"), TableHere("contrasts")]
    return tuple(parts)


def _contrasts_planned(results: StudyResults) -> bool:
    """Whether contrasts were decided on; else their table is folded."""
    return any(not one.exploratory for one in results.contrasts)


def _each_group(results: StudyResults, outcome: Outcome) -> list[Part]:
    """Return the claims of the groups that page one does not open with."""
    decided = [each for each in results.pooled if each.quantity is outcome]
    claims = [claim for claim in (group_claim(results, each) for each in decided) if claim not in results.claims]
    return [Bullets(tuple(Paragraph(claim.text, claim.provenance) for claim in claims))] if claims else []


def _outcome_in_full(results: StudyResults, outcome: Outcome) -> Section:
    contrasts = results.contrasts and outcome is results.contrasts[0].quantity and not _contrasts_planned(results)
    parts = (
        *(_each_group(results, outcome) if groups_in_one_sentence(results, outcome) else ()),
        *_tables(f"{outcome.key}_by_condition", f"comparisons_{outcome.key}"),
        *(_tables("equivalence") if outcome.has_equivalence else ()),
        *(_tables("contrasts") if contrasts else ()),
    )
    return Section(f"{outcome.key.replace('_', '-')}-in-full", f"{outcome.heading}: conditions", parts, True)


def _predicted(results: StudyResults) -> tuple[Part, ...]:
    hypotheses = _tables("hypotheses") if results.hypotheses else ()
    if not results.predictions.items:
        return hypotheses
    return (*hypotheses, *_said(verdict_text(results)), TableHere("prediction_bias"))


def _predictions_in_full(results: StudyResults) -> tuple[Part, ...]:
    hypotheses = _tables("hypotheses_in_full") if results.hypotheses else ()
    if not results.predictions.items:
        return hypotheses
    tables = ("limits_of_agreement", *(kind.name for kind in PREDICTED), "predicted_inputs", "assumed")
    return (*hypotheses, *_said(*prediction_sentences(results)), *_tables(*tables))


def _certainty(results: StudyResults) -> tuple[Part, ...]:
    budget = (Heading("Uncertainty of a joule"), TableHere("uncertainty_budget")) if results.budget is not None else ()
    drains = [
        Paragraph(
            f"{lead}{drain.line.sentence(result.run_duration_s)}", tuple(filter(None, (result.at_run.provenance,)))
        )
        for drain in results.drains
        for lead, result in [(f"{drain.robot}: " if len(results.drains) > 1 else "", drain.result)]
        if not isinstance(drain.line, Undefined)
    ]
    return (
        *budget,
        Heading("Passive drain"),
        *drains,
        FigureHere("passive_drain"),
        TableHere("passive_drain"),
        Heading("Order of the day and battery packs"),
        *_said(*results.confounded),
        TableHere("packs"),
    )


def _plan(results: StudyResults) -> tuple[Part, ...]:
    return (*_said(*map(true_minus, results.plan.decided)), *_listed(results.plan.departures), *_said(results.void))


def _methods(results: StudyResults) -> tuple[Part, ...]:
    limitations = (Heading("Limitations"), *_listed(results.limitations)) if results.limitations else ()
    assumed = results.assumed and not results.predictions.items
    return (
        *_said(*results.methods, gains_text(results), software_sentence(results)),
        *limitations,
        *((Heading("Assumed parameters"), TableHere("assumed")) if assumed else ()),
    )


def software_sentence(results: StudyResults) -> str:
    """Name software with versions, and the sources of methods, for the paragraph on methods."""
    used = list_text([f"{name} {version}" for name, version in _software(results).items()])
    entries = _entries()
    sources = [_short(entries[key]) for key in results.sources]
    return f"Software: {used}.{f' Sources: {list_text(sources)}.' if sources else ''}"


def references_bib(results: StudyResults) -> bytes:
    """Write software and sources as BibTeX, UTF-8: what `software_sentence` names, no more and no less."""
    entries = _entries()
    year = results.made_at[:4]
    software = [
        entries[name].replace("VERSION", latex_text(version)).replace("{YEAR}", f"{{{year}}}")
        for name, version in _software(results).items()
        if name in entries
    ]
    return ("\n\n".join([*software, *(entries[key] for key in results.sources)]) + "\n").encode("utf-8")


def _software(results: StudyResults) -> dict[str, str]:
    return {"labbook": results.software_version, **dict(results.software)}


def _entries() -> dict[str, str]:
    """Return the entries of the file of references by their keys."""
    text = importlib.resources.files("reports").joinpath("templates", "references.bib").read_text(encoding="utf-8")
    return {entry.partition("{")[2].partition(",")[0]: entry for entry in text.strip().split("\n\n")}


def _short(entry: str) -> str:
    """Write who and when, as a sentence cites it."""
    authors, year = (re.search(rf"{field} = {{(.*)}},", entry) for field in ("author", "year"))
    assert authors is not None  # noqa: S101 - every entry has both, as the tests see to
    assert year is not None  # noqa: S101
    names = [name.partition(",")[0].replace(r"{\"u}", "ü") for name in authors[1].split(" and ")]
    return f"{list_text(names) if len(names) < 3 else names[0] + ' et al.'} {year[1]}"
