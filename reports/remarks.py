"""Sentences beside the claims: confounding with days, what gains stand for, what predictions depend on."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.content import Claim, Comparison, Level, ReportContent
from reports.display import count_text, given_text, in_sentence, list_text, sentence_start, with_unit
from reports.naming import formula_text, is_number, level_of, level_value, levels_name, physical_text, title_of

NOT_FROM_DAYS = "cannot be told from a difference between days"
"""The mark in claims and other sentences."""
FOOTNOTE = f"groups of one day each, whose difference {NOT_FROM_DAYS}"
"""The mark in tables; their files say in full what the row's groups are."""


def all_on_one_day_each(comparisons: Sequence[Comparison]) -> bool:
    """Tell whether there are tests, and the groups of each had one day, and not the same."""
    tested = [item for item in comparisons if not isinstance(item.test.statistic, Undefined)]
    return bool(tested) and all(item.one_day_each for item in tested)


def days_claim(content: ReportContent) -> Claim | None:
    """Say how many tests over runs are confounded with days, and what would help; None where none is."""
    tested = (
        ("comparison", "", content.comparisons),
        ("test over single jumps", "tests over single jumps", content.jump_comparisons),
        ("analysis of variance", "analyses of variance", content.anovas),
    )
    counted = [
        count_text(count, one, several)
        for one, several, items in tested
        if (count := sum(bool(item.one_day_each) for item in items))
    ]
    if not counted:
        return None
    return Claim(
        f"In {list_text(counted)} the groups were measured on one day each, and not all on the same one, so that a p "
        "or an interval that counts runs or jumps cannot tell a difference between them from a difference between "
        "their days: measure the conditions on shared days. The tables mark each of them."
    )


_LISTED = 4
"""Comparisons that a sentence names before it only counts them."""


def by_day_sentences(content: ReportContent, quantity: Outcome) -> list[str]:
    """Return what is confounded with days, or left out of the model, and in which comparisons."""
    blocked = [c for c in content.comparisons if c.quantity is quantity and c.by_day is not None]
    concerned: dict[str, list[Comparison]] = {}
    for comparison in blocked:
        if comparison.by_day is not None:
            # Sides of one day each are confounded with their days: a single sentence among the claims says so.
            confounding = "" if comparison.one_day_each else comparison.by_day.confounding
            for text in filter(None, (confounding, *comparison.by_day.notes)):
                concerned.setdefault(text, []).append(comparison)
    return [f"{text} This holds for{_which(content, found, len(blocked))}." for text, found in concerned.items()]


def _which(content: ReportContent, found: list[Comparison], total: int) -> str:
    if len(found) == total:
        return " the only comparison by day" if total == 1 else f" all {count_text(total, 'comparison')} by day"
    if len(found) > _LISTED:
        return f" {len(found)} of {count_text(total, 'comparison')} by day"
    names = dict.fromkeys(f"{levels_name(content, c.group) or 'all runs'}, {level_of(content, c)}" for c in found)
    return f": {'; '.join(names)}"


def gains_text(content: ReportContent) -> str:
    """Say what gains stand for and what sizes the levels of other factors have; "" where neither is known."""
    formulas = [
        f"{in_sentence(title_of(factor))} {text}" for factor in content.factors if (text := formula_text(factor))
    ]
    found = {
        (level.factor, level.label): physical_text(level) if is_number(level) else _size_text(level)
        for condition in content.conditions
        for level in condition.levels
        if level.gain is None and level.value is not None
    }
    sentences = []
    if formulas:
        sentences.append(f"Gains g stand for physical values: {'; '.join(formulas)}.")
    for factor in content.factors:
        sizes = [text for (name, _), text in found.items() if name == factor.name]
        if sizes:
            symbol = f", {factor.symbol}" if factor.symbol else ""
            sentences.append(f"{sentence_start(factor.title)}{symbol}: {list_text(sizes)}.")
    return " ".join(sentences)


def _size_text(level: Level) -> str:
    """Write a label with its size: "small 0.038 m"."""
    return with_unit(f"{level.label} {level_value(level)}", level.unit)


def scene_sentences(content: ReportContent) -> list[str]:
    """Say which factors change nothing in the scene, and whose numbers it takes as they stand."""
    about, sentences = content.predictions, []
    if about.unmapped:
        sentences.append(
            f"Not simulated: {list_text(about.unmapped)}, for which [simulation] of labbook.toml names no parameter. "
            "Conditions that differ in nothing else have the same prediction, and savings between them are predicted "
            "as 0."
        )
    return [*sentences, *filter(None, [unconverted_text(about.unconverted)])]


def unconverted_text(factors: Sequence[tuple[str, str, str]]) -> str:
    """Say which factors are parameters of the scene as they stand, and what converts them; "" of none."""
    if not factors:
        return ""
    named = list_text([f"{factor} as {parameter} in {unit}" for factor, parameter, unit in factors])
    tables = list_text([f"[gains.{factor}]" for factor, _parameter, _unit in factors])
    return f"Simulated as it stands: {named}. Gains of a controller need {tables} (docs/your-own-data.md)."


def prediction_sentences(content: ReportContent) -> tuple[str, ...]:
    """Say what predictions depend on and what their errors are; nothing where nothing was predicted."""
    if not content.predictions.items:
        return ()
    return _simulated(content), _errors(content)


def _simulated(content: ReportContent) -> str:
    about = content.predictions
    effects = list_text([name.replace("_", " ") for name in about.effects])
    text = (
        f"Each condition is simulated as it was run: in the scene {about.scene}, with the robot and the "
        f"levels that the book states for it. The scene has these effects and no others: {effects}."
    )
    if about.unmapped:
        text += (
            f" {sentence_start(list_text(about.unmapped))} changes nothing in the scene: [simulation] of labbook.toml "
            "names no parameter for it."
        )
    if about.unconverted:
        text += f" {unconverted_text(about.unconverted)}"
    for conditions, what in (
        (
            about.branched,
            "a decision of the simulated controller hangs on a knife's edge; the jump had it fallen otherwise is part "
            "of the error",
        ),
        (
            about.on_edge,
            "a decision of the simulated controller hangs on a knife's edge, and what had come of it otherwise is in "
            "no error",
        ),
        (
            about.grown,
            "sampled active damping, or a slow foot at touchdown, lets rounding grow beyond the accuracy of the "
            "simulator; the error has that in its place",
        ),
        (about.under_surface, "the simulated body gets under the surface of the grains, which act on the foot alone"),
        (
            about.open_book,
            "the energy of the simulated jump does not add up within the accuracy: joules err by more",
        ),
        (about.ends_otherwise, "the simulated jump ends otherwise where it is simulated a hundred times finer"),
    ):
        if conditions:
            text += f" In {count_text(conditions, 'condition')} {what}."
    return text


def _errors(content: ReportContent) -> str:
    about = content.predictions
    inputs = list_text([f"{one.name} by {given_text(100.0 * one.varied_by)} %" for one in about.assumed])
    inputs_text = f"inputs without a source, each raised and lowered ({inputs})" if about.assumed else "nothing else"
    accuracy = given_text(about.accuracy)
    return (
        f"The error of a prediction is that of the simulator, {accuracy} of the value, and that of {inputs_text}. "
        "Its parts are added in quadrature and count as one standard uncertainty; in the mean of a group errors are "
        f"added before squaring. {numerical_text(content)}What the scene leaves out, such as what is lost between the "
        "charger and the motors, is no part of it."
    )


def numerical_text(content: ReportContent) -> str:
    """Say how far predictions move when simulated finer, with a space after it; "" where that is not known."""
    moved = [
        item.numerical_error / item.predicted.se
        for item in content.predictions.items
        if item.numerical_error is not None and isinstance(item.predicted.se, float) and item.predicted.se > 0.0
    ]
    if not moved:
        return ""
    marked = sum(item.imprecise for item in content.predictions.items)
    also = f", and the tables mark {count_text(marked, 'of them', 'of them')} as imprecise" if marked else ""
    most = given_text(float(f"{max(moved):.1g}"))
    return f"Simulated again a hundred times finer, predictions move by at most {most} of their standard error{also}. "
