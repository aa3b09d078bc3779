"""The order of the page: the answer on one sheet, then results and how they were got; all else folded below.

Also what a report used and names: software with versions, methods with their sources, as a sentence and as BibTeX.
"""

from __future__ import annotations

import importlib.resources
import re
from dataclasses import dataclass, replace
from typing import TypeAlias

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.claims import group_claim, groups_in_one_sentence
from reports.content import ReportContent
from reports.display import count_text, in_sentence, list_text
from reports.figures.registry import figures_of
from reports.naming import control_name, gains_text, swept_factor, title_of
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


def sections_of(content: ReportContent) -> tuple[Section, ...]:
    """Return the sections of the page in reading order; a section without parts is left out."""
    sections = (
        _answer(content),
        _results(content),
        _predicted(content),
        _robustness(content),
        _plan(content),
        _methods(content),
        *(_outcome_in_full(content, outcome) for outcome in content.outcomes),
        _tests(content),
        _predictions_in_full(content),
        _certainty(content),
        _measured(content),
        _provenance(content),
    )
    return tuple(_with_figures(section, content) for section in sections if section.parts)


def _with_figures(section: Section, content: ReportContent) -> Section:
    """Add the figures that name this section themselves."""
    named = (kind for kind in figures_of(content) if kind.section == section.anchor and kind.absent(content) is None)
    return replace(section, parts=(*section.parts, *(FigureHere(kind.name) for kind in named)))


def _answer(content: ReportContent) -> Section:
    """The first sheet: the answer, the groups, both outcomes drawn, what came of the runs, how far to trust it."""
    parts: list[Part] = []
    if content.claims:
        first, *others = content.claims
        parts.append(Paragraph(first.text, first.provenance, lead=True))
        parts += [Paragraph(claim.text, claim.provenance, lead=len(others) == 1) for claim in others]
    else:
        parts.append(Paragraph(f"Nothing is claimed from this selection: {_why_no_claim(content)}.", lead=True))
    parts.append(TableHere("headlines"))
    parts.append(FiguresBeside(tuple(f"{outcome.key}_by_level" for outcome in (Outcome.JOULES, Outcome.APEX))))
    parts.append(Paragraph(" ".join(filter(None, (flow_sentence(content), review_sentence(content))))))
    parts.append(Bullets(tuple(map(Paragraph, trust_sentences(content)))))
    return Section("answer", "Answer", tuple(parts))


def _why_no_claim(content: ReportContent) -> str:
    swept = swept_factor(content)
    if not content.conditions:
        return "none of its runs has joules or apex heights"
    if swept is None:
        return (
            "no factor names a control level, so nothing is compared with a control (write `control = ...` under a "
            "[factors.NAME] of labbook.toml)"
        )
    return (
        f"no group of its conditions has runs of both {control_name(content)} and another level of the "
        f"{in_sentence(title_of(swept))}"
    )


def _results(content: ReportContent) -> Section:
    """Each group in a sentence, outcome by outcome; page one has the first two drawn."""
    parts: list[Part] = []
    for outcome in content.outcomes:
        together = groups_in_one_sentence(content, outcome)
        found: list[Part] = [Paragraph(together)] if together else _each_group(content, outcome)
        if outcome not in (Outcome.JOULES, Outcome.APEX):
            found.append(FigureHere(f"{outcome.key}_by_level"))
        if outcome.has_savings:
            found.append(FigureHere("savings"))
        if outcome.has_equivalence:
            found += [Paragraph(text) for text in (content.no_equivalence,) if text]
        if found:
            parts += [Heading(outcome.heading), *found]
    if _contrasts_planned(content):
        parts += [Heading("What the saving depends on"), TableHere("contrasts")]
    return Section("results", "Results", tuple(parts))


def _contrasts_planned(content: ReportContent) -> bool:
    """Whether contrasts were decided on; else their table is folded."""
    return any(not one.exploratory for one in content.contrasts)


def _each_group(content: ReportContent, outcome: Outcome) -> list[Part]:
    """Return the claims of the groups that page one does not open with."""
    decided = [each for each in content.pooled if each.quantity is outcome]
    claims = [claim for claim in (group_claim(content, each) for each in decided) if claim not in content.claims]
    return [Bullets(tuple(Paragraph(claim.text, claim.provenance) for claim in claims))] if claims else []


def _outcome_in_full(content: ReportContent, outcome: Outcome) -> Section:
    parts: list[Part] = [
        *(_each_group(content, outcome) if groups_in_one_sentence(content, outcome) else ()),
        TableHere(f"{outcome.key}_by_condition"),
        TableHere(f"comparisons_{outcome.key}"),
        *([TableHere("equivalence")] if outcome.has_equivalence else []),
    ]
    if content.contrasts and outcome is content.contrasts[0].quantity and not _contrasts_planned(content):
        parts.append(TableHere("contrasts"))
    return Section(f"{outcome.key.replace('_', '-')}-in-full", f"{outcome.heading}: conditions", tuple(parts), True)


def _tests(content: ReportContent) -> Section:
    """What the thesis tested: F, then t, over runs; analysis of variance; in the study that repeats it, over jumps."""
    parts: list[Part] = []
    if content.comparisons:
        parts.append(
            Paragraph(
                "Beside the tests that decide stand the thesis's own (5.2.1), as published. They take runs for "
                "independent, whatever their days, and nothing is claimed from them."
            )
        )
    names = (*(f"tests_{outcome.key}" for outcome in content.outcomes), "tests_jumps", "anovas")
    parts += map(TableHere, names)
    return Section("tests", "The thesis's tests", tuple(parts), folded=True)


def _predicted(content: ReportContent) -> Section:
    parts: list[Part] = [TableHere("hypotheses")] if content.hypotheses else []
    if content.predictions.items:
        parts += [Paragraph(text) for text in (verdict_text(content),) if text]
        parts.append(TableHere("prediction_bias"))
    return Section("predicted", "Predicted and measured", tuple(parts))


def _predictions_in_full(content: ReportContent) -> Section:
    parts: list[Part] = [TableHere("hypotheses_in_full")] if content.hypotheses else []
    if content.predictions.items:
        tables = ("limits_of_agreement", *(kind.name for kind in PREDICTED), "predicted_inputs", "assumed")
        parts += [*map(Paragraph, prediction_sentences(content)), *map(TableHere, tables)]
    return Section("predictions", "Predictions in full", tuple(parts), folded=True)


def _robustness(content: ReportContent) -> Section:
    rules = map(Paragraph, sentences_on_rules(content))
    return Section("robustness", "Robustness", (FigureHere("sensitivity"), *rules) if content.pooled else ())


def _certainty(content: ReportContent) -> Section:
    parts: list[Part] = []
    if content.budget is not None:
        parts += [Heading("Uncertainty of a joule"), TableHere("uncertainty_budget")]
    parts.append(Heading("Passive drain"))
    for drain in content.drains:
        lead, at_run = f"{drain.robot}: " if len(content.drains) > 1 else "", drain.result.at_run
        if not isinstance(drain.line, Undefined):
            said = drain.line.sentence(drain.result.run_duration_s)
            parts.append(Paragraph(lead + said, tuple(filter(None, (at_run.provenance,)))))
    parts += [FigureHere("passive_drain"), TableHere("passive_drain")]
    parts.append(Heading("Order of the day and battery packs"))
    parts += [Paragraph(sentence) for sentence in content.confounded]
    parts.append(TableHere("packs"))
    return Section("certainty", "Uncertainty, drain, packs, order of the day", tuple(parts), folded=True)


def _measured(content: ReportContent) -> Section:
    parts: list[Part] = []
    if len(content.robots) > 1:
        counts = list_text([f"{count_text(runs, 'run')} of {robot}" for robot, runs in content.robots.items()])
        parts.append(
            Paragraph(
                f"The analysed runs are of {len(content.robots)} robots: {counts}. Means and comparisons take the runs "
                "of all robots together; the tables of conditions count each robot's."
            )
        )
    parts += [TableHere("flow"), TableHere("days")]
    if run_anchors(content):
        parts.append(TableHere("each_run"))
    return Section("measured", "Days and runs", tuple(parts), folded=True)


def _plan(content: ReportContent) -> Section:
    parts: list[Part] = [*map(Paragraph, content.decided)]
    if content.departures:
        parts.append(Bullets(tuple(map(Paragraph, content.departures))))
    parts += [Paragraph(content.void)] if content.void else []
    return Section("plan", "Plan and deviations", tuple(parts))


def _methods(content: ReportContent) -> Section:
    parts: list[Part] = [Paragraph(text) for text in content.methods]
    if gains := gains_text(content):
        parts.append(Paragraph(gains))
    parts.append(Paragraph(software_sentence(content)))
    if content.limitations:
        parts += [Heading("Limitations"), Bullets(tuple(map(Paragraph, content.limitations)))]
    if content.assumed and not content.predictions.items:
        parts += [Heading("Assumed parameters"), TableHere("assumed")]
    return Section("methods", "Methods", tuple(parts))


def _provenance(content: ReportContent) -> Section:
    if not content.provenance:
        return Section("provenance", "Provenance", ())
    return Section("provenance", "Provenance", (TableHere("provenance"),), folded=True)


def software_sentence(content: ReportContent) -> str:
    """Name software with versions, and the sources of methods, for the paragraph on methods."""
    used = list_text([f"{name} {version}" for name, version in _software(content).items()])
    entries = _entries()
    sources = [_short(entries[key]) for key in content.sources]
    return f"Software: {used}.{f' Sources: {list_text(sources)}.' if sources else ''}"


def references_bib(content: ReportContent) -> bytes:
    """Write software and sources as BibTeX, UTF-8: what `software_sentence` names, no more and no less."""
    entries = _entries()
    year = content.made_at[:4]
    software = [
        entries[name].replace("VERSION", latex_text(version)).replace("{YEAR}", f"{{{year}}}")
        for name, version in _software(content).items()
        if name in entries
    ]
    return ("\n\n".join([*software, *(entries[key] for key in content.sources)]) + "\n").encode("utf-8")


def _software(content: ReportContent) -> dict[str, str]:
    return {"labbook": content.software_version, **dict(content.software)}


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
