"""How results stand in a notebook: a sentence and a small table as HTML, every text escaped."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from data_schema.rounding import number_text

MOST_ROWS = 30
"""Rows that a notebook shows; `to_frame` and CSV have all."""
_DIGITS = 4


def value_text(value: Any) -> str | None:
    """Write one value to four significant digits; None for what has parts of its own."""
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "\u2013"}[value]
    if isinstance(value, float):
        return number_text(value, _DIGITS) if math.isfinite(value) else "\u2013"
    return str(value) if isinstance(value, int | str) else None


def table_html(head: Sequence[str], rows: Sequence[Sequence[str]], *, caption: str = "") -> str:
    """Write a table of texts; beyond `MOST_ROWS` rows it says how many more there are."""
    cells = [f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in rows[:MOST_ROWS]]
    heads = f"<thead><tr>{''.join(f'<th>{escape(text)}</th>' for text in head)}</tr></thead>" if head else ""
    more = f"<p>{len(rows) - MOST_ROWS} more rows</p>" if len(rows) > MOST_ROWS else ""
    titled = f"<caption>{escape(caption)}</caption>" if caption else ""
    return f"<table>{titled}{heads}<tbody>{''.join(cells)}</tbody></table>{more}"


def fields_html(data: Mapping[str, Any], *, sentence: str = "") -> str:
    """Write a result's fields one under the other, below its sentence; what is undefined has its reason."""
    rows = []
    for name, value in data.items():
        text = value_text(value)
        if text is None or name.endswith("_reason"):
            continue
        reason = data.get(f"{name}_reason")
        rows.append((name, f"{text} ({reason})" if reason else text))
    paragraph = f"<p>{escape(sentence)}</p>" if sentence else ""
    return f"{paragraph}<details><summary>numbers</summary>{table_html((), rows)}</details>"
