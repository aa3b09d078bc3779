"""What gains and sizes stand for: the formulas and values that the methods end with."""

from __future__ import annotations

from reports.content import Level, ReportContent
from reports.display import with_unit
from reports.naming import formula_text, is_number, level_value, physical_text, title_of
from reports.wording import list_text, sentence_start


def gains_text(content: ReportContent) -> str:
    """Say what gains stand for and what sizes the levels of other factors have; "" where neither is known."""
    formulas = [f"{title_of(factor).lower()} {text}" for factor in content.factors if (text := formula_text(factor))]
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
