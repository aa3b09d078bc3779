"""A table as LaTeX: booktabs rules, units in the heads, every special character escaped."""

from __future__ import annotations

from reports.tables.table import Cell, Table

_LONG_ROWS = 45

_ESCAPES = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    "\u00a0": "~",
    "\u2212": r"\ensuremath{-}",
    "\u2013": "--",
    "\u00b1": r"\ensuremath{\pm}",
    "\u00d7": r"\ensuremath{\times}",
    "\u00b2": r"\ensuremath{^2}",
    "\u00b0": r"\ensuremath{^\circ}",
    "\u221e": r"\ensuremath{\infty}",
    "\n": " ",
    "\r": " ",
    "\t": " ",
}


def latex_text(text: str) -> str:
    """Escape text so that LaTeX prints it as it is."""
    return "".join(_ESCAPES.get(letter, letter) for letter in text)


def latex_bytes(table: Table) -> bytes:
    r"""Write a table for `\input`: needs `booktabs`, and `longtable` where it is longer than a page."""
    width = len(table.heads)
    spec = "".join("r" if column.numeric else "l" for column in table.heads)
    heads = " & ".join(latex_text(column.head) for column in table.heads) + r" \\"
    notes = table.footnotes
    body = _body(table, notes, width)
    caption = rf"\caption{{{latex_text(table.caption)}}}"
    label = rf"\label{{tab:{table.name.replace('_', '-')}}}"
    below = [rf"\textsuperscript{{{mark}}}~{latex_text(note)}" for note, mark in notes.items()]
    if len(table.rows) > _LONG_ROWS:
        lines = [
            rf"\begin{{longtable}}{{{spec}}}",
            rf"{caption} {label} \\",
            r"\toprule",
            heads,
            r"\midrule",
            r"\endhead",
            r"\bottomrule",
            r"\endlastfoot",
            *body,
            r"\end{longtable}",
            *([r"{\footnotesize " + r"\\ ".join(below) + r"\par}"] if below else []),
        ]
    else:
        lines = [
            r"\begin{table}",
            r"\centering",
            caption,
            label,
            rf"\begin{{tabular}}{{{spec}}}",
            r"\toprule",
            heads,
            r"\midrule",
            *body,
            r"\bottomrule",
            r"\end{tabular}",
            *([r"\par\footnotesize " + r"\\ ".join(below)] if below else []),
            r"\end{table}",
        ]
    return ("\n".join(lines) + "\n").encode("utf-8")


def _body(table: Table, notes: dict[str, str], width: int) -> list[str]:
    lines: list[str] = []
    for block, rows in table.blocks:
        if lines:
            lines.append(r"\addlinespace")
        if block:
            lines.append(rf"\multicolumn{{{width}}}{{l}}{{\textit{{{latex_text(block)}}}}} \\")
        lines += [" & ".join(_cell(cell, notes) for cell in table.cells(row)) + r" \\" for row in rows]
    return lines


def _cell(cell: Cell, notes: dict[str, str]) -> str:
    mark = rf"\textsuperscript{{{notes[cell.note]}}}" if cell.note else ""
    text = latex_text(cell.text)
    # A line that starts with a bracket would be read as an argument of the line break before it.
    return ("{}" if text.startswith(("[", "*")) else "") + text + mark
