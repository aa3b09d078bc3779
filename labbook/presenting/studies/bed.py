"""The bed study (thesis ch. 5): the report's comparisons as sentences, as tables, as data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, Undefined
from labbook.analysis.studies.compaction import Compaction
from labbook.presenting.numbers import number_data, published_data, value_data
from labbook.presenting.studies import compaction
from reports.content import Comparison, Condition, ReportContent
from reports.decided_sentences import groups_in_one_sentence
from reports.display import (
    BESIDE,
    DASH,
    as_shown,
    common_places,
    count_text,
    in_sentence,
    interval_text,
    list_text,
    p_text,
    places_of,
    sentence_start,
    value_text,
    with_unit,
)
from reports.evidence import POOLED, MeansContrast
from reports.figures.by_level import coefficient_of, has_quantity, points_text
from reports.naming import levels_name
from reports.numbers import Number, Value
from reports.predicted import PredictedQuantity, Prediction
from reports.remarks import scene_sentences
from reports.tables.contrasts import contrast_name
from reports.tables.headlines import groups
from reports.tables.predictions import published_text
from simulator.steady.published_results import published_results

HEAD = (
    "group",
    "gain",
    "n",
    "joules ± SE (J)",
    "saving (%)",
    "p",
    "p over runs",
    "thesis p",
    "apex ± SE (mm)",
    "its change (mm)",
)
_MEANS = ("joules ± SE (J)", "apex ± SE (mm)")
OUTCOMES = (Outcome.JOULES, Outcome.APEX)
_KEYS = {PredictedQuantity.JOULES: Outcome.JOULES.key, PredictedQuantity.APEX: Outcome.APEX.key}
"""Names of simulated quantities in JSON, as those of what was measured."""
_NONE = Number(0.0, "1")
_FEET = {"control": "bed.foot_ce", "treated": "bed.foot_ad"}
"""By side what is published of the difference between the feet."""


@dataclass(frozen=True, slots=True)
class BedStudy:
    """What the report has of a selection, and how densely the grains lie where the book has a sheet of flasks.

    `on_bed` says whether the robot jumped on a bed: only then are published numbers shown beside. `named` are the
    factors whose levels are words, as the foot; `remarks` say what is not there, and why; `files` are
    the sheet of flasks by name, with its SHA-256.
    """

    content: ReportContent
    on_bed: bool
    named: tuple[str, ...]
    compaction: Compaction | None
    remarks: tuple[str, ...]
    files: tuple[tuple[str, str], ...] = ()

    def predicted(self, quantity: PredictedQuantity, group: Mapping[str, str], level: str) -> Prediction | None:
        """Return what is predicted of a level, None where nothing is."""
        found = (one for one in self.content.predictions.of(quantity) if (one.group, one.level) == (group, level))
        return next(found, None)

    def each(self, outcome: Outcome, group: Mapping[str, str], level: str) -> Comparison | None:
        """Return the comparison of a level with its control."""
        found = (one for one in self.content.comparisons if (one.quantity, one.level) == (outcome, level))
        return next((one for one in found if one.group == group), None)


def sentences(study: BedStudy) -> list[str]:
    """Say what active damping saves, in all and by group, whether height is lost, and how densely the grains lie."""
    content = study.content
    lines = [claim.text for claim in content.claims]
    if content.overall:
        savings = {name: joules.lead.savings for name, (joules, _apex) in groups(content).items() if joules is not None}
        places = common_places(savings.values())
        by_group = [f"{_text(saving, places)} with {name}" for name, saving in savings.items()]
        lines.append(f"Saved by group: {list_text(by_group)}.")
    if together := groups_in_one_sentence(content, Outcome.APEX):
        lines.append(f"Apex height, {in_sentence(together)}")
    lines.append(content.no_equivalence)
    lines += [_absence(content, outcome) for outcome in OUTCOMES if not has_quantity(content, outcome)]
    lines += scene_sentences(content)
    lines += [] if study.compaction is None else compaction.sentences(study.compaction)[:1]
    return [*filter(None, lines), *study.remarks]


def _absence(content: ReportContent, outcome: Outcome) -> str:
    why = list_text([f"{count_text(n, 'run')}: {reason}" for reason, n in content.flow.runs_without[outcome].items()])
    return f"There are no {outcome.plural} of these runs{f' ({why})' if why else ''}."


def figure_caption(study: BedStudy) -> str:
    """Say what is drawn."""
    drawn = [outcome for outcome in OUTCOMES if has_quantity(study.content, outcome)]
    what = sentence_start(list_text([in_sentence(outcome.heading) for outcome in drawn]))
    points = dict.fromkeys(points_text(study.content, outcome) for outcome in drawn)
    return " ".join([f"{what} against the {coefficient_of(study.content)} (thesis figures 5.3, 5.4).", *points])


def rows(study: BedStudy) -> list[list[str]]:
    """Return a row for each group and damping gain: means with standard errors, what is saved, how the apex changes.

    p is by shared days, and over runs as the thesis tested; beside it the thesis's.
    """
    content, cells = study.content, []
    for condition in content.conditions:
        group, level = _place(content, condition)
        joules, apex = (study.each(outcome, group, level) for outcome in OUTCOMES)
        means = [None if (found := condition.summary(outcome)) is None else found.mean for outcome in OUTCOMES]
        saving = study.predicted(PredictedQuantity.SAVINGS, group, level)
        of_thesis = None if saving is None else saving.published
        p = None if of_thesis is None or of_thesis.unit != "p" else of_thesis.published
        cells.append(
            (
                levels_name(content, group) or "all runs",
                "CE" if condition.control else level,
                str((means[0] or means[1] or _NONE).n or 0),
                means[0],
                None if joules is None else joules.lead.savings,
                DASH if joules is None else _p(joules.lead.test.p),
                DASH if joules is None else _p(joules.test.p),
                DASH if p is None else _p(p),
                means[1],
                None if apex is None else apex.lead.difference,
            )
        )
    columns = [_column(column, errors=HEAD[of] in _MEANS) for of, column in enumerate(zip(*cells, strict=True))]
    return [list(row) for row in zip(*columns, strict=True)]


def _p(p: Value) -> str:
    """Write p for a cell, which has no room for a reason."""
    return DASH if isinstance(p, Undefined) else p_text(p, name=False)


def _column(cells: Sequence[str | Number | None], *, errors: bool) -> list[str]:
    """Write the numbers of a column to the same digits: means with standard errors, others with intervals."""
    numbers = [cell for cell in cells if isinstance(cell, Number)]
    places = common_places(numbers)
    return [cell if isinstance(cell, str) else _text(cell, places, errors=errors, unit=False) for cell in cells]


def comparison_rows(study: BedStudy) -> list[tuple[str, ...]]:
    """Return the pooled comparisons of 5.2.1 and the apex of 5.2.2: measured, simulated, published."""
    content, found = study.content, list[tuple[str, ...]]()
    published = {result.id: published_text(result) if study.on_bed else "" for result in published_results()}
    for name, (joules, _apex) in groups(content).items():
        if joules is not None:
            one = study.predicted(PredictedQuantity.SAVINGS, joules.group, POOLED)
            texts = (DASH, "") if one is None else (_text(one.predicted), published_text(one.published))
            found.append((f"saving, {name}", _tested(joules, joules.lead.savings), *texts))
    for factor in study.named:
        found += _between(study, factor, published)
    p = [one.test.p for one in content.anovas if one.quantity is Outcome.JOULES and isinstance(one.test.p, float)]
    if p:
        name = f"joules at all damping gains alike, ANOVA in {count_text(len(p), 'group')}"
        found.append((name, f"{'least ' if len(p) > 1 else ''}{p_text(min(p))}", "", published["bed.anova"]))
    rises = [one.lead.difference for one in content.comparisons if one.quantity is Outcome.APEX and not one.opens]
    known = {one.value: one for one in rises if isinstance(one.value, float)}
    if known:
        name, largest = f"largest rise of the apex, of {len(known)}", replace(known[max(known)], ci_low=None)
        found.append((name, _text(largest), _rise(study), published["bed.apex_gain"]))
    return [tuple(cell or DASH for cell in row) for row in found]


def _between(study: BedStudy, factor: str, published: Mapping[str, str]) -> list[tuple[str, ...]]:
    """Return the differences in joules between the levels of a factor, as between the feet."""
    content, found = study.content, list[tuple[str, ...]]()
    labels = {level.label for one in content.conditions if (level := one.level(factor)) is not None}
    of_feet = study.on_bed and labels == {"small", "large"}
    for one in content.contrasts:
        if (one.kind, one.quantity, one.factor) == (ContrastKind.DIFFERENCE, Outcome.JOULES, factor):
            means = [_simulated_j(study, factor, level, one.side) for level in one.levels]
            simulated = "" if means[0] is None or means[1] is None else _text(Number(means[1] - means[0], "J"), 1)
            p = one.test.p
            tested = "; ".join([_text(one.estimate, 1), p_text(p) if isinstance(p, float) else "no test by days"])
            found.append(
                (contrast_name(content, one), tested, simulated, published[_FEET[one.side]] if of_feet else "")
            )
    return found


def _place(content: ReportContent, condition: Condition) -> tuple[dict[str, str], str]:
    """Return the levels in common with the control, and that of the swept factor."""
    swept = {factor.name for factor in content.factors if factor.swept}
    levels = {level.factor: level.label for level in condition.levels}
    group = {name: label for name, label in levels.items() if name not in swept}
    return group, next((label for name, label in levels.items() if name in swept), "")


def _text(number: Number | None, places: int | None = None, *, errors: bool = False, unit: bool = True) -> str:
    """Write a number with its interval, "7.7 % (2.0 to 12.9)", or with its standard error, "41.55 ± 0.66"."""
    if number is None or isinstance(number.value, Undefined):
        return DASH
    shown, places = as_shown(number), places_of(number) if places is None else places
    text = value_text(shown.value, places)
    if errors:
        return text if shown.se is None else f"{text} ± {value_text(_se(shown), places)}"
    text, ends = with_unit(text, shown.unit) if unit else text, interval_text(number, places, unit=False)
    return f"{text} ({ends})" if isinstance(shown.ci_low, float) else text


def _se(number: Number) -> Value:
    """Return the standard error of a mean, with what its runs have in common."""
    parts = [part for part in (number.se, number.shared_se) if isinstance(part, float)]
    return number.se if isinstance(number.se, Undefined) else math.hypot(*parts)


def _tested(comparison: Comparison, number: Number | None, places: int | None = None) -> str:
    """Write what was compared, its p by shared days where there is one, and over runs, as the thesis tested."""
    p = comparison.lead.test.p
    by_days = p_text(p) if isinstance(p, float) else "no test by days" if comparison.decision is not None else ""
    return "; ".join(filter(None, [_text(number, places), by_days, f"over runs {p_text(comparison.test.p)}"]))


def _simulated_j(study: BedStudy, factor: str, level: str, side: str) -> float | None:
    """Return the mean over the groups of a factor's level of their simulated joules, each over the runs of a side."""
    groups: dict[tuple[str, ...], list[tuple[float, int]]] = {}
    for one in study.content.predictions.of(PredictedQuantity.JOULES):
        of_side = one.group.get(factor) == level and one.control is (side == "control")
        if of_side and isinstance(one.predicted.value, float):
            groups.setdefault(tuple(one.group.values()), []).append((one.predicted.value * one.n, one.n))
    means = [sum(total for total, _n in known) / sum(n for _total, n in known) for known in groups.values()]
    return sum(means) / len(means) if means else None


def _rise(study: BedStudy) -> str:
    """Write the largest simulated rise of the apex above the control's."""
    apexes = study.content.predictions.of(PredictedQuantity.APEX)
    controls = {tuple(one.group.items()): one.predicted.value for one in apexes if one.control}
    pairs = [(one.predicted.value, controls.get(tuple(one.group.items()))) for one in apexes if not one.control]
    rises = [value - of_ce for value, of_ce in pairs if isinstance(value, float) and isinstance(of_ce, float)]
    return _text(Number(max(rises), "m")) if rises else ""


def as_data(study: BedStudy) -> dict[str, Any]:
    """Return all numbers for JSON, unrounded."""
    content, heights = study.content, study.content.overall_equivalence
    return {
        "claims": [claim.text for claim in content.claims],
        "overall_saving": next(
            (number_data(one.savings) for one in content.overall if one.quantity is Outcome.JOULES), None
        ),
        "overall_apex_change": None if heights is None else number_data(heights.tested.estimate),
        "apex_equivalent": None if heights is None else heights.tested.shown,
        "conditions": [_condition_data(study, one) for one in content.conditions],
        "comparisons": [_comparison_data(one) for one in content.comparisons],
        "contrasts": [_contrast_data(one) for one in content.contrasts],
        "anovas": [
            {"quantity": str(one.quantity), "group": dict(one.group), "p": value_data(one.test.p)}
            for one in content.anovas
        ],
        "beside": [dict(zip(BESIDE, one, strict=True)) for one in comparison_rows(study)],
        "compaction": None if study.compaction is None else compaction.as_data(study.compaction),
        "remarks": list(study.remarks),
    }


def _condition_data(study: BedStudy, condition: Condition) -> dict[str, Any]:
    group, level = _place(study.content, condition)
    means = {outcome.key: number_data(summary.mean) for outcome, summary in condition.summaries.items()}
    simulated = {
        _KEYS.get(quantity, str(quantity)): number_data(one.predicted)
        for quantity in PredictedQuantity
        if (one := study.predicted(quantity, group, level)) is not None
    }
    about = {"group": group, "level": level, "control": condition.control, "measured": means, "simulated": simulated}
    return about | {"published": published_data(study.predicted(PredictedQuantity.SAVINGS, group, level))}


def _contrast_data(one: MeansContrast) -> dict[str, Any]:
    return {
        "kind": str(one.kind),
        "quantity": str(one.quantity),
        "factor": one.factor,
        "levels": list(one.levels),
        "side": one.side or None,
        "estimate": number_data(one.estimate),
        "unit": one.estimate.unit,
        "p": value_data(one.test.p),
        "days": len(one.days),
        "exploratory": one.exploratory or None,
    }


def _comparison_data(one: Comparison) -> dict[str, Any]:
    lead = one.lead
    return {
        "quantity": str(one.quantity),
        "family": one.family,
        "group": dict(one.group),
        "level": one.level,
        "n": [lead.n_control, lead.n_treatment],
        "days": list(lead.days),
        "difference": number_data(lead.difference),
        "saving_percent": None if lead.savings is None else number_data(lead.savings),
        "p": value_data(lead.test.p),
        "p_holm": None if lead.adjusted is None else value_data(lead.adjusted.value),
        "p_over_runs": value_data(one.test.p),
        "test_over_runs": one.test.name,
        "equivalent": None if lead.equivalence is None else lead.equivalence.shown,
    }
