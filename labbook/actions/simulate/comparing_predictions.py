"""What `labbook compare` does: predictions of a selection beside what was measured, and hypotheses; it writes nothing.

Hypotheses of what was measured need no scene.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from data_schema.errors import UsageError
from data_schema.queries.runs import refuse_empty_selection
from data_schema.vocabulary import Undefined
from labbook.analysis.prediction.predicting import PredictionResult
from labbook.analysis.results import Results
from labbook.analysis.study import analyse
from labbook.book.opening import Book
from labbook.book.write_session import now_utc
from labbook.terminal import columns
from reports.display import sentence_start
from reports.numbers import Number, Value
from reports.results import Hypothesis, PredictedQuantity, StudyResults, Verdict
from reports.tables.hypotheses import verdict_sentence
from reports.tables.predictions import (
    LEGEND,
    PREDICTED,
    level_text_of,
    numerical_text,
    scene_sentences,
    title_text,
    verdict_text,
)
from reports.tables.registry import TABLES
from reports.tables.table import Table

_MOST = {
    PredictedQuantity.JOULES: "most_joules",
    PredictedQuantity.APEX: "most_apex_m",
    PredictedQuantity.CONTACT_TIME: "most_contact_time_s",
    PredictedQuantity.IMPULSE_HEIGHT: "most_impulse_height_m",
    PredictedQuantity.SAVINGS: "most_savings_percent",
}
_PUBLISHED = ("id", "where", "published", "unit", "relation")
COMPARED = {
    "hypotheses_in_full": None,
    **{kind.name: title_text(quantity) for kind, quantity in zip(PREDICTED, PredictedQuantity, strict=True)},
    "prediction_bias": None,
    "limits_of_agreement": None,
    "predicted_inputs": None,
}
"""The tables in their order, and the title of each; None: its caption."""


@dataclass(frozen=True, slots=True)
class ComparedPredictions:
    """The results, and on which side of the boundary the simulated ground lies; "" where that is none."""

    results: StudyResults
    ground: str = ""

    @property
    def fails(self) -> bool:
        """Whether a hypothesis fails as measured."""
        return any(one.verdict is Verdict.FAILS for one in self.results.hypotheses)

    @property
    def met(self) -> bool:
        """Whether no hypothesis fails, and of predictions, if there are, some can be compared and none misses."""
        items = self.results.predictions.items
        agreements = [item.agrees for item in items if item.agrees is not None]
        return not self.fails and (not items or bool(agreements)) and all(agreements)


def compare_predictions(book: Book, where: str | None, step: Callable[[str], None]) -> ComparedPredictions:
    """Predict and compare; raises `UsageError` where there is nothing to predict or nothing to compare with."""
    configuration = book.configuration
    if configuration.simulation is None and not configuration.hypotheses:
        raise UsageError(
            'labbook.toml names no scene to predict with: write scene = "bed" under [simulation], and which factor is '
            "which parameter; or state what you expect under [hypotheses.NAME]."
        )
    with book.reading() as connection:
        refuse_empty_selection(connection, where)
        made = analyse(connection, book.store, book.configuration, where=where, made_at=now_utc(), progress=step)
    items = made.results.predictions.items
    if not items and configuration.simulation is not None:
        raise UsageError(
            f"no run of this selection ({where or 'all runs'}) has joules or an apex height to compare with: select "
            "others, or ingest their logs and charges."
        )
    return ComparedPredictions(made.results, _ground(made.computed))


def _ground(computed: Results) -> str:
    """Say whether active damping saves on the book's ground, as its conditions are simulated (docs/falsify.md).

    The ground is also taken softer and firmer, as each of its assumed parameters is varied.
    """
    from labbook.presenting.simulation.falsified import ground_sentence
    from simulator.falsify import has_damping, judge_scenes
    from simulator.scene_file import parse_scene

    found = [one for one in computed.made.values() if isinstance(one, PredictionResult)]
    scenes = [(parse_scene(one.scene_toml, one.scene, one.scene), one.assumed) for one in found]
    treated = [(scene, assumed) for scene, assumed in scenes if has_damping(scene)]
    if not treated:
        return ""
    as_it_is, varied = [scene for scene, _ in treated], []
    for scene, assumed in treated:
        for name, one in assumed.items():
            for sign in (-1.0, 1.0):
                with contextlib.suppress(UsageError):  # of what no scene can have
                    varied.append(scene.changed({name: scene[name] * (1.0 + sign * one.varied_by)}))
    judged = judge_scenes([*as_it_is, *varied], found[0].accuracy)
    return ground_sentence(judged, len(as_it_is))


def as_lines(compared: ComparedPredictions) -> list[str]:
    """Return the tables for people, under their captions, and above them what is not simulated."""
    lines = [f"{verdict_sentence(compared.results, one)}." for one in compared.results.hypotheses]
    lines += [""] if lines else []
    if not compared.results.predictions.items:
        return [_plain(line).rstrip() for line in (*lines, *_tables(compared.results))]
    lines += [compared.ground, ""] if compared.ground else []
    lines += [line for notes in scene_sentences(compared.results) for line in (notes, "")]
    lines += _tables(compared.results)
    notes = (
        sentence_start(LEGEND),
        *filter(None, [numerical_text(compared.results)]),
        "",
        verdict_text(compared.results),
    )
    return [_plain(line).rstrip() for line in (*lines, *notes)]


def _tables(results: StudyResults) -> list[str]:
    lines: list[str] = []
    for name, title in COMPARED.items():
        table = TABLES[name].make(results)
        if table.rows:
            lines += [f"{title}:" if title else table.caption, "", *_table_lines(table), ""]
    return lines


def as_data(compared: ComparedPredictions) -> dict[str, Any]:
    """Return the same for programs, in stored units and unrounded."""
    about = compared.results.predictions
    return {
        "met": compared.met,
        "scene": about.scene,
        "effects": about.effects,
        "accuracy": about.accuracy,
        "ground": compared.ground or None,
        "not_in_scene": about.unmapped,
        "as_they_stand": [
            {"factor": factor, "parameter": parameter, "unit": unit} for factor, parameter, unit in about.unconverted
        ],
        "hypotheses": [_hypothesis(one) for one in compared.results.hypotheses],
        "predictions": [
            {
                "quantity": str(item.quantity),
                "group": dict(item.group),
                "level": item.level,
                "condition": level_text_of(compared.results, item).replace("\N{NO-BREAK SPACE}", " "),
                "control": item.control,
                "n": item.n,
                "unit": item.measured.unit,
                "measured": _number_data(item.measured),
                "predicted": _number_data(item.check.predicted),
                "numerical_error": item.check.numerical_error,
                "imprecise": item.check.imprecise,
                "difference": _value_data(item.check.difference.value),
                "error_ratio": _value_data(item.check.error_ratio.value),
                "agrees": item.agrees,
                "unsure": item.unsure,
                "published": item.published and {name: getattr(item.published, name) for name in _PUBLISHED},
            }
            for item in about.items
        ],
        "bias": [
            {
                "quantity": str(one.quantity),
                "unit": group.bias.unit,
                "group": dict(group.group),
                "days": group.days,
                "bias": _number_data(group.bias),
                "by_measurement_alone": _number_data(group.of_measured),
                "p": _value_data(group.p.value),
                "joint_p": _value_data(one.joint_p.value),
                "kendall_tau": None if one.tau is None else _value_data(one.tau.value),
            }
            for one in about.judged
            for group in one.groups
        ],
        "limits_of_agreement": [
            {
                "quantity": str(one.quantity),
                "unit": one.limits.mean_difference.unit,
                "n": one.limits.mean_difference.n,
                "mean": _number_data(one.limits.mean_difference),
                "low": _number_data(one.limits.lower_limit),
                "high": _number_data(one.limits.upper_limit),
            }
            for one in about.judged
            if one.limits is not None
        ],
        "assumed": [
            {
                "name": one.name,
                **asdict(one.parameter),
                **{key: _value_data(one.changes.get(quantity)) for quantity, key in _MOST.items()},
            }
            for one in about.assumed
        ],
    }


def _hypothesis(one: Hypothesis) -> dict[str, Any]:
    return {
        "name": one.name,
        "text": one.text,
        "source": one.source,
        "published": one.published,
        "verdict": one.verdict,
        "simulated_verdict": one.simulated_verdict,
        "comparisons": [
            {
                "of": dict(part.of),
                "against": dict(part.against),
                "above_percent": part.low,
                "below_percent": part.high,
                "measured_percent": _number_data(part.measured),
                "verdict": part.verdict,
                "simulated_percent": _number_data(part.simulated),
                "simulated_verdict": part.simulated_verdict,
            }
            for part in one.parts
        ],
    }


def _table_lines(table: Table) -> list[str]:
    """Set a table in columns, a group's rows under its name; provenance is the report's, and left out."""
    shown = [place for place, column in enumerate(table.heads) if column.fields != ("provenance",)]
    heads = [table.heads[place].head for place in shown]
    notes = {"": "", **{reason: f" ({mark})" for reason, mark in table.footnotes.items()}}
    texts = [
        [f"{cells[place].text}{notes[cells[place].note]}" for place in shown] for cells in map(table.cells, table.rows)
    ]
    head, *set_rows = columns(heads, texts)
    lines, left = [head], iter(set_rows)
    for block, rows in table.blocks:
        lines += [block] if block else []
        lines += itertools.islice(left, len(rows))
    return [*lines, *(f"  {mark}: {reason}" for reason, mark in table.footnotes.items())]


def _plain(line: str) -> str:
    return line.replace("\N{NO-BREAK SPACE}", " ")


def _number_data(number: Number) -> dict[str, Any]:
    """Return a number for JSON, unrounded and in its stored unit."""
    found = {"value": _value_data(number.value), "se": _value_data(number.se)}
    if number.ci_low is not None:
        ends = {"ci_low": _value_data(number.ci_low), "ci_high": _value_data(number.ci_high)}
        found |= {**ends, "ci_level": number.ci_level}
    if isinstance(number.value, Undefined):
        found["undefined"] = number.value.reason
    return found


def _value_data(value: Value | tuple[float, float] | None) -> Any:
    """Return a value or an interval for JSON, None where it is undefined."""
    return None if isinstance(value, Undefined) else value
