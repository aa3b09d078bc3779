"""What was predicted beside what was measured, as tables and in words.

A table a quantity; the inputs that predictions assume; the signed bias of each group and of all jointly; limits of
agreement, how far predictions lie from what was measured, over conditions; and what all that depends on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from data_schema.vocabulary import Undefined
from reports.display import (
    DASH,
    EQUALS,
    as_shown,
    common_places,
    count_text,
    decimal_text,
    general_text,
    given_text,
    interval_text,
    list_text,
    p_text,
    sentence_start,
    shown_unit,
    value_text,
    with_unit,
)
from reports.naming import level_name, levels_name, swept_factor, swept_words
from reports.numbers import Number
from reports.results import (
    POOLED,
    AssumedInput,
    AssumedParameter,
    Judged,
    JudgedGroup,
    Limits,
    PredictedQuantity,
    Prediction,
    StudyResults,
)
from reports.tables.table import (
    Cell,
    ColumnOf,
    Columns,
    Table,
    TableKind,
    column,
    counts,
    ids,
    interval,
    interval_cell,
    number,
    number_cell,
    p_cell,
    table_of,
    text,
    value_cell,
    words,
)

if TYPE_CHECKING:
    from simulator.steady.published_results import PublishedResult

_ALWAYS = (PredictedQuantity.JOULES, PredictedQuantity.APEX, PredictedQuantity.SAVINGS)
LEGEND = (
    "std. error: one standard uncertainty of the prediction (two are about 95 %); difference: predicted less measured; "
    "ratio: difference over the expanded uncertainty of both, half the measured interval and two standard "
    "uncertainties of the prediction added in quadrature. They agree where the ratio lies within \u22121 to 1."
)
"""What the columns are."""
_VERDICTS = {True: words("yes"), False: words("no"), None: Cell(DASH, (None,))}
_UNSURE = Cell(DASH, (None,), note="two standard uncertainties of the prediction are as large as itself")


def title_text(quantity: PredictedQuantity) -> str:
    """Return what heads the table of a quantity."""
    return f"{quantity.heading}, measured and predicted"


def level_text_of(results: StudyResults, item: Prediction) -> str:
    """Name the level of a prediction: "CE", "d = 186 kg/s (gain 50)", "pooled"; "all runs" without a swept factor."""
    swept = swept_factor(results)
    if item.level == POOLED:
        return POOLED
    if swept is None:
        return levels_name(results, item.group) or "all runs"
    if item.control:
        return swept_words(swept).control_level
    levels = (condition.level(swept.name) for condition in results.conditions if not condition.control)
    level = next((level for level in levels if level is not None and level.label == item.level), None)
    return item.level if level is None else level_name(swept, level, gain=True)


def block_of(results: StudyResults, item: Prediction) -> str:
    """Name the group that a prediction stands under; "" without a swept factor."""
    return levels_name(results, item.group) if swept_factor(results) is not None else ""


def _predicted(item: Prediction, places: int) -> Cell:
    """Make a cell of a prediction, with a mark where the simulation errs by more than it may."""
    cell = number_cell(item.check.predicted, places)
    if not item.check.imprecise:
        return cell
    if item.check.numerical_error is None:
        return replace(cell, note="simulated a hundred times finer, there is no such number")
    unit, factor = shown_unit(item.check.predicted.unit)
    moved = with_unit(f"{item.check.numerical_error * factor:.1g}", unit)
    return replace(cell, note=f"simulated a hundred times finer, it moves by {moved}")


def _error(number: Number, places: int) -> Cell:
    """Make a cell of a standard uncertainty in the unit it is shown in."""
    if number.se is None and not isinstance(number.value, Undefined):
        return Cell(DASH, (None,), note="an assumed input cannot be varied so far")
    return value_cell(number.se, places, shown_unit(number.unit)[1])


_SIGNS = {"less than": "<", "greater than": ">"}


def published_text(found: PublishedResult | None) -> str:
    """Write what the thesis has, with its section: "about 15 % (5.2.1)", "p = .041 (5.2.1)"; "" for nothing."""
    if found is None or found.published is None:
        return ""
    if found.unit == "p":
        text = f"p {_SIGNS.get(found.relation, '=')} {given_text(found.published).removeprefix('0')}"
    else:
        unit, factor = ("%", 100.0) if found.unit == "1" else shown_unit(found.unit)
        text = f"{found.relation} {with_unit(given_text(factor * found.published), unit)}".strip()
    return f"{text} ({found.where})"


def _published(found: PublishedResult | None) -> Cell:
    values = (None, None, None) if found is None else (found.published, found.unit, found.where)
    return Cell(published_text(found), values)


def _make(results: StudyResults, quantity: PredictedQuantity, name: str) -> Table:
    items = results.predictions.of(quantity)
    unit, measured = quantity.unit, [item.measured for item in items]
    places = common_places(measured)
    finer = max(places, common_places([item.check.predicted for item in items], places))
    published: ColumnOf[Prediction] = text(
        "published (thesis)",
        "published published_unit published_in",
        lambda item: _published(item.published),
    )
    columns: Columns[Prediction] = (
        text(
            "condition",
            "group level",
            lambda item: Cell(level_text_of(results, item), (levels_name(results, item.group), item.level)),
        ),
        counts("n", "n_runs", lambda item: item.n),
        number("measured", "measured_{unit}", unit, lambda item: item.measured, places),
        interval(measured, unit, lambda item: item.measured, places),
        column("predicted", "predicted_{unit}", lambda item: _predicted(item, finer), unit=unit),
        column("std. error", "predicted_se_{unit}", lambda item: _error(item.check.predicted, finer), unit=unit),
        column(
            "numerical error",
            "numerical_error_{unit}",
            lambda item: Cell("", (item.check.numerical_error,)),
            unit=unit,
            shown=False,
        ),
        number("difference", "difference_{unit}", unit, lambda item: item.check.difference, places),
        number("ratio", "error_ratio", "", lambda item: item.check.error_ratio, 2),
        text(
            "agree",
            "agrees",
            lambda item: _UNSURE if item.unsure and item.agrees is None else _VERDICTS[item.agrees],
        ),
        *([published] if any(item.published for item in items) else []),
        ids(lambda item: item.check.predicted.provenance),
    )
    return table_of(
        name,
        f"{title_text(quantity)}; {LEGEND}",
        items,
        columns,
        block=lambda item: block_of(results, item),
        strong=lambda item: item.level == POOLED,
    )


def _assumed(results: StudyResults) -> Table:
    quantities = [of for of in PredictedQuantity if of in _ALWAYS or results.predictions.of(of)]
    columns: Columns[AssumedInput] = (
        text("input", "input", lambda one: one.name),
        text("value", "value unit", lambda one: _value_and_unit(one.parameter)),
        text("why", "why", lambda one: one.parameter.why, prose=True),
        column(
            "varied by",
            "varied_by",
            lambda one: Cell(given_text(100.0 * one.parameter.varied_by), (one.parameter.varied_by,)),
            unit="%",
        ),
        *map(_change, quantities),
    )
    caption = (
        "Inputs of the simulation without a source, and the most that raising or lowering each by its part changes in "
        "any condition (savings: in percentage points)."
    )
    return table_of("predicted_inputs", caption, results.predictions.assumed, columns)


def _value_and_unit(one: AssumedParameter) -> Cell:
    return Cell(with_unit(given_text(one.value), one.unit), (one.value, one.unit))


def _change(quantity: PredictedQuantity) -> ColumnOf[AssumedInput]:
    factor = shown_unit(quantity.unit)[1]
    return column(
        quantity.short,
        f"{quantity.name.lower()}_{{unit}}",
        lambda one: value_cell(one.changes.get(quantity), 2 if factor == 1.0 else 1, factor),
        unit=quantity.unit,
    )


def _table_kind(quantity: PredictedQuantity) -> TableKind:
    name = f"predicted_{quantity.name.lower()}"
    return TableKind(name, lambda results: _make(results, quantity, name))


PREDICTED = tuple(map(_table_kind, PredictedQuantity))
"""A table a quantity."""
PREDICTED_INPUTS = TableKind("predicted_inputs", _assumed)


_CI = "95\u00a0% CI"
_NAMED = 2
"""Groups that a sentence names before it only counts them."""
_ORDERED = 3
"""So many groups have an order worth a tau: of two it is 1 or -1."""


def _places_of_biases(one: Judged) -> int:
    """Return the decimals of a quantity's biases, in the unit that they are shown in."""
    return common_places([group.bias for group in one.groups])


def _group_verdict(group: JudgedGroup, places: int) -> str:
    """Say what a group's bias amounts to: "predictions 5.1 J high", "no significant bias"."""
    if group.differs:
        return f"predictions {_size([group], places)}"
    if group.agrees_only_by_assumed:
        return f"{_size([group], places)}, not significant with the assumed inputs' uncertainty included"
    return "no significant bias"


def _size(groups: Sequence[JudgedGroup], places: int) -> str:
    """Write how far predictions of groups lie to one side: "4.6 to 5.6 J high"."""
    shown = [as_shown(group.bias) for group in groups]
    values = sorted(abs(each.value) for each in shown if not isinstance(each.value, Undefined))
    ends = dict.fromkeys(decimal_text(value, places) for value in (values[0], values[-1]))
    side = "high" if _is_high(groups[0]) else "low"
    return f"{with_unit(' to '.join(ends), shown[0].unit)} {side}"


def _is_high(group: JudgedGroup) -> bool:
    return isinstance(group.bias.value, float) and group.bias.value > 0.0


def _joint_text(one: Judged) -> str:
    """Write the joint test and Kendall's tau of the order of groups: "joint p < .001, \u03c4 = 0.33"."""
    value = None if one.tau is None or len(one.groups) < _ORDERED else one.tau.value
    tau = f", \u03c4{EQUALS}{decimal_text(value, 2)}" if isinstance(value, float) else ""
    return f"joint {p_text(one.joint_p.value)}{tau}"


def verdict_text(results: StudyResults) -> str:
    """Say of each quantity whether its predictions are biased, where and by how much; "" where none can be judged."""
    found, assumed = results.predictions.judged, results.predictions.assumed
    sentences = [
        f"{sentence_start(str(each.quantity))} ({_joint_text(each)}): {_where_biased(results, each)}." for each in found
    ]
    if any(group.differs for each in found for group in each.groups):
        needed = [text for each in found if (text := _needed(each, assumed))]
        explained = f"To explain that, {'; '.join(needed)}; or an" if needed else "No assumed input explains that: an"
        sentences.append(f"{explained} effect is missing in the scene.")
    fitted = [one.name for one in assumed if one.fitted]
    if found and fitted:
        sentences.append(f"Fitted to this study: {list_text(fitted)}; agreement with the runs fitted is no test.")
    return " ".join(sentences)


def _needed(one: Judged, assumed: Sequence[AssumedInput]) -> str:
    """Say how far off the input that moves a quantity most must be to explain its largest bias alone, if linear."""
    biases = [abs(group.bias.value) for group in one.groups if group.differs and isinstance(group.bias.value, float)]
    moves = [
        (part, each) for each in assumed if isinstance(part := each.changes.get(one.quantity), float) and part > 0.0
    ]
    if not biases or not moves:
        return ""
    part, most = max(moves, key=lambda of: of[0])
    off = with_unit(general_text(100.0 * max(biases) / part * most.parameter.varied_by, 2), "%")
    within = with_unit(general_text(100.0 * most.parameter.varied_by, 2), "%")
    return f"{most.name} must be {off} off, not within {within} ({one.quantity})"


def _where_biased(results: StudyResults, one: Judged) -> str:
    parts = []
    for high in (True, False):
        biased = [each for each in one.groups if each.differs and _is_high(each) is high]
        if biased:
            parts.append(f"{_size(biased, _places_of_biases(one))}{_where(results, one.groups, biased)}")
    bought = [each for each in one.groups if each.agrees_only_by_assumed]
    if bought and not parts:
        means = "mean agrees" if len(bought) == 1 else "means agree"
        return f"group {means}{_where(results, one.groups, bought)} only with the assumed inputs' uncertainty included"
    return list_text(parts) or "no significant bias"


def _where(results: StudyResults, groups: Sequence[JudgedGroup], chosen: Sequence[JudgedGroup]) -> str:
    """Name the chosen groups, or count them; "" where a study has one group."""
    if len(groups) == 1:
        return ""
    if len(chosen) == len(groups):
        return " in all groups"
    if len(chosen) <= _NAMED:
        return f" at {list_text([levels_name(results, each.group) for each in chosen])}"
    return f" in {len(chosen)} of {count_text(len(groups), 'group')}"


def _bias_table(results: StudyResults) -> Table:
    columns: Columns[tuple[Judged, JudgedGroup]] = (
        text("quantity", "quantity", lambda row: str(row[0].quantity)),
        text("group", "group", lambda row: levels_name(results, row[1].group) or "all runs"),
        counts("days", "days", lambda row: row[1].days),
        counts("runs", "n", lambda row: row[1].bias.n, shown=False),
        number("measured", "measured", "", lambda row: row[1].measured, None, shown=False),
        number("predicted", "predicted", "", lambda row: row[1].predicted, None, shown=False),
        column("bias", "bias unit", lambda row: _bias(row[1].bias, _places_of_biases(row[0]))),
        column(_CI, "ci_low ci_high", lambda row: _ends(row[1].bias, _places_of_biases(row[0]))),
        column(
            "by measurement alone",
            "ci_low_measured ci_high_measured",
            lambda row: _ends(row[1].of_measured),
            shown=False,
        ),
        column("p", "p", lambda row: p_cell(row[1].p.value)),
        text("verdict", "verdict", lambda row: _group_verdict(row[1], _places_of_biases(row[0])), prose=True),
        column("joint test", "joint_p kendall_tau joint_id kendall_tau_id", lambda row: _joint(row[0]), shown=False),
        ids(lambda row: row[1].bias.provenance),
    )
    caption = (
        "Predicted less measured by day; intervals hold both errors. Joint p: Bonferroni's; "
        f"\u03c4: Kendall's, of groups.{_other_units(results)}"
    )
    groups = [(one, group) for one in results.predictions.judged for group in one.groups]
    return table_of("prediction_bias", caption, groups, columns)


def _bias(bias: Number, places: int) -> Cell:
    shown = as_shown(bias)
    return Cell(with_unit(value_text(shown.value, places), shown.unit), (bias.value, bias.unit))


def _ends(number: Number, places: int | None = None) -> Cell:
    return Cell(interval_text(number, places), (number.ci_low, number.ci_high))


def _joint(one: Judged) -> Cell:
    tau, tau_id = (None, None) if one.tau is None else (one.tau.value, one.tau.provenance)
    return Cell("", (one.joint_p.value, tau, one.joint_p.provenance, tau_id))


def _other_units(results: StudyResults) -> str:
    """Say which factors the scene takes in another unit than the study states; "" for none."""
    return "".join(
        f" {sentence_start(factor.title)}: {factor.unit} in the study, as many {unit} in the scene."
        for factor in results.factors
        if (factor.slope is not None or factor.unit)
        and (unit := results.predictions.units.get(factor.name, factor.unit)) != factor.unit
    )


PREDICTION_BIAS = TableKind("prediction_bias", _bias_table)


def _limits_of_agreement(results: StudyResults) -> Table:
    columns: Columns[tuple[Judged, Limits]] = (
        text("quantity", "quantity", lambda row: str(row[0].quantity)),
        text("unit", "unit", lambda row: shown_unit(row[1].mean_difference.unit)[0]),
        counts("conditions", "n", lambda row: row[1].mean_difference.n),
        *_limit_columns("mean", "mean", lambda limits: limits.mean_difference),
        *_limit_columns("lower limit", "low", lambda limits: limits.lower_limit),
        *_limit_columns("upper limit", "high", lambda limits: limits.upper_limit),
        ids(lambda row: row[1].mean_difference.provenance),
    )
    caption = (
        "Predicted less measured over conditions (Bland and Altman): mean difference, and the limits between which "
        "95\u00a0% of further conditions are expected."
    )
    found = [(one, one.limits) for one in results.predictions.judged if one.limits is not None]
    return table_of("limits_of_agreement", caption, found, columns)


def _limit_columns(
    title: str, name: str, of: Callable[[Limits], Number]
) -> tuple[ColumnOf[tuple[Judged, Limits]], ...]:
    def places(limits: Limits) -> int:
        return common_places((limits.mean_difference, limits.lower_limit, limits.upper_limit))

    return (
        column(title, name, lambda row: number_cell(of(row[1]), places(row[1]))),
        column(
            _CI,
            f"{name}_ci_low {name}_ci_high {name}_ci_level",
            lambda row: interval_cell(of(row[1]), places(row[1])),
        ),
    )


LIMITS_OF_AGREEMENT = TableKind("limits_of_agreement", _limits_of_agreement)


def scene_sentences(results: StudyResults) -> list[str]:
    """Say which factors change nothing in the scene, and whose numbers it takes as they stand."""
    about, sentences = results.predictions, []
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


def prediction_sentences(results: StudyResults) -> tuple[str, ...]:
    """Say what predictions depend on and what their errors are; nothing where nothing was predicted."""
    if not results.predictions.items:
        return ()
    return _simulated(results), _errors(results)


def _simulated(results: StudyResults) -> str:
    about = results.predictions
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


def _errors(results: StudyResults) -> str:
    about = results.predictions
    inputs = list_text([f"{one.name} by {given_text(100.0 * one.parameter.varied_by)} %" for one in about.assumed])
    inputs_text = f"inputs without a source, each raised and lowered ({inputs})" if about.assumed else "nothing else"
    accuracy = given_text(about.accuracy)
    return (
        f"The error of a prediction is that of the simulator, {accuracy} of the value, and that of {inputs_text}. "
        "Its parts are added in quadrature and count as one standard uncertainty; in the mean of a group errors are "
        f"added before squaring. {numerical_text(results)}What the scene leaves out, such as what is lost between the "
        "charger and the motors, is no part of it."
    )


def numerical_text(results: StudyResults) -> str:
    """Say how far predictions move when simulated finer, with a space after it; "" where that is not known."""
    moved = [
        error / se
        for item in results.predictions.items
        for error, se in [(item.check.numerical_error, item.check.predicted.se)]
        if error is not None and isinstance(se, float) and se > 0.0
    ]
    if not moved:
        return ""
    marked = sum(item.check.imprecise for item in results.predictions.items)
    also = f", and the tables mark {count_text(marked, 'of them', 'of them')} as imprecise" if marked else ""
    most = given_text(float(f"{max(moved):.1g}"))
    return f"Simulated again a hundred times finer, predictions move by at most {most} of their standard error{also}. "
