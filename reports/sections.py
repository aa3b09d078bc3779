"""The order and the words of the page: the headline first, then the evidence, then how it was got."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from data_schema.outcomes import Outcome
from reports.content import Anova, Condition, ReportContent
from reports.display import significance_text
from reports.naming import (
    control_name,
    levels_name,
    swept_factor,
    swept_words,
    title_of,
)
from reports.remarks import NOT_FROM_DAYS, by_day_sentences, gains_text, prediction_sentences
from reports.wording import count_text, list_text


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
class TableHere:
    """The place of a table of the registry."""

    name: str


_FEW_RUN_VALUES = 60
"""Up to so many values of single runs the page lists them; beyond, figures and files have them."""

Part: TypeAlias = Paragraph | Bullets | Heading | FigureHere | TableHere


@dataclass(frozen=True, slots=True)
class Section:
    """A section of the page; `anchor` is what the contents link to."""

    anchor: str
    title: str
    parts: tuple[Part, ...]


def sections_of(content: ReportContent) -> tuple[Section, ...]:
    """Return the sections of the page in reading order; a section without parts is left out."""
    sections = (
        _in_short(content),
        *(_measured_outcome(content, outcome) for outcome in content.outcomes),
        _predicted(content),
        _certainty(content),
        _measured(content),
        _methods(content),
        Section(
            "tests",
            "Tests in full",
            (
                *(TableHere(f"tests_{outcome.key}") for outcome in content.outcomes),
                TableHere("tests_jumps"),
                TableHere("anovas"),
            ),
        ),
        _provenance(content),
    )
    return tuple(section for section in sections if section.parts)


def _in_short(content: ReportContent) -> Section:
    parts: list[Part] = []
    if content.claims:
        first, *others = content.claims
        parts.append(Paragraph(first.text, first.provenance, lead=True))
        if others:
            parts.append(Bullets(tuple(Paragraph(claim.text, claim.provenance) for claim in others)))
    else:
        parts.append(Paragraph(f"Nothing is claimed from this selection: {_why_no_claim(content)}.", lead=True))
    parts += [TableHere("headlines"), FigureHere("savings")]
    return Section("in-short", "In short", tuple(parts))


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
        f"{title_of(swept).lower()}"
    )


def _measured_outcome(content: ReportContent, outcome: Outcome) -> Section:
    parts: list[Part] = [
        FigureHere(f"{outcome.key}_by_damping"),
        TableHere(f"{outcome.key}_by_condition"),
        *_anova_paragraph(content, outcome),
        FigureHere(f"estimation_{outcome.key}"),
        TableHere(f"comparisons_{outcome.key}"),
        *map(Paragraph, by_day_sentences(content, outcome)),
        TableHere(f"by_day_{outcome.key}"),
    ]
    if outcome.has_equivalence:
        parts += [*map(Paragraph, filter(None, (content.no_equivalence,))), TableHere("equivalence")]
    return Section(outcome.key.replace("_", "-"), outcome.heading, tuple(parts))


def _anova_paragraph(content: ReportContent, quantity: Outcome) -> tuple[Paragraph, ...]:
    anovas = [anova for anova in content.anovas if anova.quantity is quantity]
    if not anovas:
        return ()
    results = [f"{significance_text(anova.test, name=False)} ({_anova_words(content, anova)})" for anova in anovas]
    text = (
        "Whether the level of the treatment matters is tested by a one-way analysis of variance over the levels "
        f"of the {swept_words(swept_factor(content)).coefficient}, control left out: {list_text(results)}."
    )
    if reasons := dict.fromkeys(anova.exploratory for anova in anovas if anova.exploratory):
        text += f" That is exploratory, because {list_text(list(reasons))}."
    return (Paragraph(text, tuple(anova.provenance for anova in anovas if anova.provenance)),)


def _anova_words(content: ReportContent, anova: Anova) -> str:
    name = levels_name(content, anova.group) or anova.label
    return f"{name}; {NOT_FROM_DAYS}" if anova.one_day_each else name


def _predicted(content: ReportContent) -> Section:
    if not content.predictions.items:
        return Section("predicted", "Predicted and measured", ())
    tables = ("predicted_joules", "predicted_apex", "predicted_savings", "predicted_inputs")
    parts: list[Part] = [Paragraph(text) for text in prediction_sentences(content)]
    parts += [FigureHere("predictions"), *map(TableHere, tables)]
    return Section("predicted", "Predicted and measured", tuple(parts))


def _certainty(content: ReportContent) -> Section:
    parts: list[Part] = []
    if content.budget:
        parts += [Heading("Uncertainty of a joule"), TableHere("uncertainty_budget")]
    parts.append(Heading("Passive drain"))
    fits = content.drains
    for fit in fits:
        lead = f"{fit.robot}: " if len(fits) > 1 else ""
        parts.append(Paragraph(lead + fit.range_sentence, tuple(filter(None, (fit.at_run.provenance,)))))
    parts += [FigureHere("passive_drain"), TableHere("passive_drain")]
    parts.append(Heading("Order of the day and battery packs"))
    parts += [Paragraph(sentence) for sentence in content.order.sentences]
    parts += [FigureHere("day_order"), FigureHere("packs"), TableHere("packs")]
    parts += [Heading("The headlines computed another way"), FigureHere("sensitivity")]
    return Section("certainty", "How sure these numbers are", tuple(parts))


def _measured(content: ReportContent) -> Section:
    flow = content.flow
    parts: list[Part] = []
    if flow.runs_done:
        days = f" on {count_text(len(content.days), 'day')}" if content.days else ""
        who = f" People of the book: {list_text(content.people)}." if content.people else ""
        made = "was" if flow.runs_done == 1 else "were"
        used = [f"{outcome.plural} from {flow.runs_with[outcome]}" for outcome in content.outcomes]
        jumps = (
            f"; {count_text(flow.jumps_analysed, 'jump')} of {flow.jumps_made} made are analysed"
            if flow.runs_with[Outcome.APEX]
            else ""
        )
        parts.append(
            Paragraph(
                f"{count_text(flow.runs_done, 'run')} of this selection {made} made{days}; "
                f"{', '.join(used)}{jumps}.{who}"
            )
        )
    if len(content.robots) > 1:
        counts = list_text([f"{count_text(runs, 'run')} of {robot}" for robot, runs in content.robots.items()])
        parts.append(
            Paragraph(
                f"The analysed runs are of {len(content.robots)} robots: {counts}. Means and comparisons take the runs "
                "of all robots together; the tables of conditions count each robot's."
            )
        )
    parts += [FigureHere("flow"), TableHere("days")]
    if sum(_run_count(condition) for condition in content.conditions) <= _FEW_RUN_VALUES:
        parts.append(TableHere("run_values"))
    return Section("measured", "What was measured", tuple(parts))


def _run_count(condition: Condition) -> int:
    return sum(len(summary.runs) for summary in condition.summaries.values())


def _methods(content: ReportContent) -> Section:
    parts: list[Part] = [Paragraph(text) for text in content.methods]
    if content.known_errors:
        introduction, *designs = content.known_errors
        parts += [Paragraph(introduction), Bullets(tuple(map(Paragraph, designs)))]
    if gains := gains_text(content):
        parts.append(Paragraph(gains))
    if content.decided:
        parts.append(Heading("What was decided before the first measurement was ingested"))
        parts += map(Paragraph, content.decided)
    if content.departures:
        parts.append(Bullets(tuple(map(Paragraph, content.departures))))
    if content.limitations:
        parts += [Heading("Limitations"), Bullets(tuple(map(Paragraph, content.limitations)))]
    if content.assumed:
        parts += [Heading("Assumed parameters"), TableHere("assumed")]
    return Section("methods", "Methods", tuple(parts))


def _provenance(content: ReportContent) -> Section:
    if not content.provenance:
        return Section("provenance", "Provenance", ())
    return Section("provenance", "Provenance", (TableHere("provenance"),))
