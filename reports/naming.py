"""What things are called: factors, levels, groups of conditions, the treatment and its control, gain formulas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from reports.display import (
    EQUALS,
    MINUS,
    NO_BREAK,
    count_text,
    general_text,
    given_text,
    in_sentence,
    list_text,
    sentence_start,
    with_unit,
)
from reports.results import Comparison, Condition, Factor, Level, StudyResults

_MEANINGS = {"kg/s": "Damping coefficient", "N/m": "Stiffness"}


@dataclass(frozen=True, slots=True)
class SweptWords:
    """What the control and the swept factor's levels are called in sentences and on axes.

    `control` stands in formulas, `control_level` beside the treated levels, `the_control` in sentences.
    """

    control: str
    control_level: str
    the_control: str
    coefficient: str


def swept_words(factor: Factor | None) -> SweptWords:
    """Return the words for a swept factor: those that labbook.toml gives, else by its title and the control's label."""
    coefficient = "condition" if factor is None else in_sentence(title_of(factor))
    if factor is not None and factor.control_name:
        return SweptWords(factor.control_name, factor.control_name, factor.control_name, coefficient)
    level = f"control ({_control_label(factor)})" if factor is not None and factor.control is not None else "control"
    return SweptWords("control", level, f"the {level}", coefficient)


def _control_label(factor: Factor) -> str:
    label = factor.control or ""
    return f"gain{NO_BREAK}{label}" if factor.slope is not None else with_unit(label, factor.unit)


def title_of(factor: Factor) -> str:
    """Return what a factor's physical values are called: its title, or by its unit where the title is only its name."""
    if factor.slope is not None and factor.title == factor.name.replace("_", " "):
        return _MEANINGS.get(factor.unit, factor.title)
    return factor.title


def formula_text(factor: Factor) -> str:
    """Write how gains become physical values: "k = 2.56 g + 67.36 N/m"; "" where the levels are no gains."""
    if factor.slope is None or factor.offset is None:
        return ""
    sign = "+" if factor.offset >= 0 else MINUS
    slope, offset = given_text(factor.slope), given_text(abs(factor.offset))
    text = f"{factor.symbol} = {slope} g {sign} {offset}".replace(" ", NO_BREAK)
    called = factor.control_name or "the control"
    zero = f"; gain {factor.control} is {called} and stands for 0" if factor.control is not None else ""
    return with_unit(text, factor.unit) + zero


def gains_text(results: StudyResults) -> str:
    """Say what gains stand for and what sizes the levels of other factors have; "" where neither is known."""
    formulas = [
        f"{in_sentence(title_of(factor))} {text}" for factor in results.factors if (text := formula_text(factor))
    ]
    found = {
        (level.factor, level.label): physical_text(level) if is_number(level) else _size_text(level)
        for condition in results.conditions
        for level in condition.levels
        if level.gain is None and level.value is not None
    }
    sentences = []
    if formulas:
        sentences.append(f"Gains g stand for physical values: {'; '.join(formulas)}.")
    for factor in results.factors:
        sizes = [text for (name, _), text in found.items() if name == factor.name]
        if sizes:
            symbol = f", {factor.symbol}" if factor.symbol else ""
            sentences.append(f"{sentence_start(factor.title)}{symbol}: {list_text(sizes)}.")
    return " ".join(sentences)


def _size_text(level: Level) -> str:
    """Write a label with its size: "small 0.038 m"."""
    return with_unit(f"{level.label} {level_value(level)}", level.unit)


def level_value(level: Level) -> str:
    """Write a level's value: what its gain stands for with three digits, any other with all its digits."""
    write = given_text if level.gain is None else general_text
    return write(level.value or 0.0)


def physical_text(level: Level) -> str:
    """Write a level's physical value, "835 N/m", or its label where it has none."""
    return level.label if level.value is None else with_unit(level_value(level), level.unit)


def is_number(level: Level) -> bool:
    """Whether a level is a number without a gain formula: its label says no more than its value."""
    if level.gain is not None or level.value is None:
        return False
    try:
        return float(level.label) == level.value
    except ValueError:
        return False


def level_name(factor: Factor, level: Level, *, gain: bool = False) -> str:
    """Name a level: "small foot", "drop height = 45 cm", "k = 1091 N/m"; with `gain`, "k = 1091 N/m (gain 400)"."""
    if level.gain is None:
        name = in_sentence(factor.title)
        return f"{name}{EQUALS}{physical_text(level)}" if is_number(level) else f"{level.label} {name}"
    beside = f" (gain{NO_BREAK}{given_text(level.gain)})" if gain else ""
    return f"{factor.symbol or factor.title}{EQUALS}{physical_text(level)}{beside}"


def group_name(results: StudyResults, condition: Condition, *, gain: bool = False, axis: Factor | None = None) -> str:
    """Name what a condition shares with its control: every level but that of the swept factor, and of `axis`."""
    others = (factor for factor in results.factors if not factor.swept and factor != axis)
    pairs = ((factor, condition.level(factor.name)) for factor in others)
    return ", ".join(level_name(factor, level, gain=gain) for factor, level in pairs if level is not None)


def levels_name(results: StudyResults, group: Mapping[str, str]) -> str:
    """Name a group given as factor -> label; a label that no condition has is shown as it is."""
    return ", ".join(level_names(results, group))


def level_names(results: StudyResults, group: Mapping[str, str]) -> list[str]:
    """Return the names of a group's levels, one a factor, in the order of the study's factors."""
    known = _known_levels(results)
    factors = {factor.name: factor for factor in results.factors}
    names = []
    for name in sorted(group, key=lambda name: list(factors).index(name) if name in factors else len(factors)):
        label = group[name]
        level = known.get((name, label))
        names.append(f"{name} {label}" if level is None else level_name(factors[name], level))
    return names


def headline_name(results: StudyResults, comparison: Comparison) -> str:
    """Name what a pooled comparison claims: "savings, small foot"."""
    quantity = comparison.quantity
    what = "savings" if quantity.has_savings else f"difference of {quantity}"
    return f"{what}, {levels_name(results, comparison.group)}"


def _known_levels(results: StudyResults) -> dict[tuple[str, str], Level]:
    return {(level.factor, level.label): level for condition in results.conditions for level in condition.levels}


def level_of(results: StudyResults, comparison: Comparison) -> str:
    """Name the level that a comparison sets against its control: "d = 186 kg/s (gain 50)", or "pooled" of several."""
    swept = swept_factor(results)
    known = None if swept is None else _known_levels(results).get((swept.name, comparison.level))
    if comparison.opens and len(alone := treated_levels(results, comparison.group)) == 1:
        known = alone[0]
    return comparison.level if swept is None or known is None else level_name(swept, known, gain=True)


def swept_factor(results: StudyResults) -> Factor | None:
    """Return the factor on the x axis, None where the study has none."""
    return next((factor for factor in results.factors if factor.swept), None)


_FEW_LEVELS = 3
"""Up to so many treated levels a sentence names; of more it says how many there are."""


def treatment_name(results: StudyResults, group: Mapping[str, str]) -> str:
    """Name the treatment of a group in a sentence: as labbook.toml does ("active damping"), else by its levels.

    "smooth", "gravel and mud", "drop height = 45 cm"; of many levels "the treatment (5 levels of the stiffness)".
    """
    swept = swept_factor(results)
    levels = treated_levels(results, group)
    if swept is None or swept.treatment or not levels:
        return swept.treatment if swept is not None and swept.treatment else "the treatment"
    if len(levels) > _FEW_LEVELS:
        return f"the treatment ({count_text(len(levels), 'level')} of the {in_sentence(title_of(swept))})"
    return _levels_listed(swept, levels)


def treatment_label(results: StudyResults) -> str:
    """Name the treatment in a formula or a legend: its name or its only level, else "treatment"."""
    swept = swept_factor(results)
    if swept is not None and (swept.treatment or len(treated_levels(results, {})) == 1):
        return treatment_name(results, {})
    return "treatment"


def treated_levels(results: StudyResults, group: Mapping[str, str]) -> list[Level]:
    """Return the treated levels of a group's conditions, each once."""
    swept = swept_factor(results)
    name = "" if swept is None else swept.name
    treated = (one for one in results.conditions if not one.control and group.items() <= one.labels.items())
    levels = (level for one in treated if (level := one.level(name)) is not None)
    return list({level.label: level for level in levels}.values())


def _levels_listed(factor: Factor, levels: list[Level]) -> str:
    if levels[0].gain is None and not is_number(levels[0]):
        return list_text([level.label for level in levels])
    values = list_text([level_value(level) for level in levels])
    name = factor.symbol or in_sentence(factor.title)
    return f"{name}{EQUALS}{with_unit(values, levels[0].unit)}"


def control_name(results: StudyResults) -> str:
    """Name the control in a sentence: as labbook.toml does ("CE"), else with its level: "the control (sand)"."""
    return swept_words(swept_factor(results)).the_control
