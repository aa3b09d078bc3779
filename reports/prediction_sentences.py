"""What is said about predictions: how many are met, what was simulated, and what the predictions rest on."""

from __future__ import annotations

from reports.content import ReportContent
from reports.display import stated_text
from reports.predicted import PredictedQuantity, Prediction
from reports.wording import count_text, list_text, sentence_start


def prediction_sentences(content: ReportContent) -> tuple[str, ...]:
    """Return the paragraphs above the figure; nothing where nothing was predicted."""
    if not content.predictions.items:
        return ()
    return verdict_text(content), _simulated(content), _errors(content)


def verdict_text(content: ReportContent) -> str:
    """Say how many predictions are met, by quantity."""
    found = ((quantity, content.predictions.of(quantity)) for quantity in PredictedQuantity)
    parts = [f"{quantity}: {_agreeing(items)}" for quantity, items in found if items]
    return f"Of what was predicted, this agrees with what was measured: {'; '.join(parts)}."


def _agreeing(items: tuple[Prediction, ...]) -> str:
    told = [item for item in items if item.agrees is not None]
    untold = len(items) - len(told)
    more = f" ({count_text(untold, 'further one')} cannot be told)" if untold else ""
    return f"{sum(bool(item.agrees) for item in told)} of {len(told)}{more}"


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
            "the sampled active damping lets rounding grow beyond the accuracy of the simulator; the error has that in "
            "its place",
        ),
        (about.under_surface, "the simulated body gets under the surface of the grains, which act on the foot alone"),
        (
            about.open_book,
            "the energy of the simulated jump does not add up within the accuracy: joules err by more",
        ),
    ):
        if conditions:
            text += f" In {count_text(conditions, 'condition')} {what}."
    return text


def _errors(content: ReportContent) -> str:
    about = content.predictions
    inputs = list_text([f"{one.name} by {stated_text(100.0 * one.varied_by)} %" for one in about.assumed])
    rests = f"inputs without a source, each raised and lowered ({inputs})" if about.assumed else "nothing else"
    accuracy = stated_text(about.accuracy)
    return (
        f"The error of a prediction is that of the simulator, {accuracy} of the value, and that of {rests}. Its parts "
        "are added in quadrature and count as one standard uncertainty. What the scene leaves out, such as what is "
        "lost between the charger and the motors, is no part of it."
    )
