"""Sentences beside the claims: what gains stand for, what predictions depend on."""

from __future__ import annotations

from collections.abc import Sequence

from reports.content import Level, ReportContent
from reports.display import count_text, given_text, in_sentence, list_text, sentence_start, with_unit
from reports.naming import formula_text, is_number, level_value, physical_text, title_of


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
    inputs = list_text([f"{one.name} by {given_text(100.0 * one.parameter.varied_by)} %" for one in about.assumed])
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
        error / se
        for item in content.predictions.items
        for error, se in [(item.check.numerical_error, item.check.predicted.se)]
        if error is not None and isinstance(se, float) and se > 0.0
    ]
    if not moved:
        return ""
    marked = sum(item.check.imprecise for item in content.predictions.items)
    also = f", and the tables mark {count_text(marked, 'of them', 'of them')} as imprecise" if marked else ""
    most = given_text(float(f"{max(moved):.1g}"))
    return f"Simulated again a hundred times finer, predictions move by at most {most} of their standard error{also}. "
