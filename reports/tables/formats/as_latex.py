"""A table as LaTeX: booktabs rules, units in the heads, every special character escaped, no wider than its column.

Numbers are text that is rounded already, so no `siunitx` is needed; a row's provenance id follows it as a comment.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass

from reports.display import NO_BREAK
from reports.fields import PROVENANCE
from reports.tables.table import Cell, Column, Row, Table

PAGE_LINES = 48
"""Lines that a page holds beside the caption; a table with more breaks over pages."""

_SIZES = ((r"\footnotesize", 87), (r"\scriptsize", 95))
"""Type sizes, and about how many letters of each stand on a line of LaTeX's `article` (345 pt)."""

_GAP_LETTERS = 1.4
_PROSE_LETTERS = 14
_SHORT_LETTERS = 8


@dataclass(frozen=True, slots=True)
class Layout:
    """A table's type size, each column's head as lines, and the share of the line of columns of broken lines.

    `lines` is about how many lines the rows take, with the names of the blocks and the space between them.
    """

    size: str
    heads: Mapping[Column, tuple[str, ...]]
    shares: Mapping[Column, float]
    lines: int


def layout_of(table: Table, columns: Sequence[Column]) -> Layout:
    """Lay out a table: heads in two lines, smaller type where they or numbers need it, words that break beside these.

    Columns of prose share the room by how much stands in them; the first of words breaks where numbers leave no room.
    """
    heads = {column: _two_lines(column.head) for column in columns}
    texts = {column: [row.cells[table.columns.index(column)].text for row in table.rows] for column in columns}
    wide = {column: max(map(len, [*heads[column], *texts[column]])) for column in columns}
    gaps = _GAP_LETTERS * (len(columns) - 1)
    least = gaps + sum(min(wide[column], _PROSE_LETTERS) if column.prose else wide[column] for column in columns)
    size, line = next(((name, letters) for name, letters in _SIZES if least <= letters), _SIZES[-1])
    breaking = [column for column in columns if column.prose]
    if least > line:
        breaking += [column for column in columns[:1] if not column.numeric and not column.prose]
    room = line - gaps - sum(wide[column] for column in columns if column not in breaking)
    wanted = sum(wide[column] for column in breaking)
    widths = (
        {} if wanted <= room else {column: max(_SHORT_LETTERS, room * wide[column] / wanted) for column in breaking}
    )
    return Layout(size, heads, {column: width / line for column, width in widths.items()}, _lines(table, texts, widths))


def _two_lines(head: str) -> tuple[str, ...]:
    """Break a head where its lines are most alike."""
    places = [place for place, letter in enumerate(head) if letter == " "]
    at = min(places, key=lambda place: max(place, len(head) - place), default=None)
    return (head,) if at is None else (head[:at], head[at + 1 :])


def _lines(table: Table, texts: Mapping[Column, Sequence[str]], widths: Mapping[Column, float]) -> int:
    rows = [
        max([1, *(math.ceil(len(texts[column][index]) / width) for column, width in widths.items())])
        for index in range(len(table.rows))
    ]
    blocks = [block for block, _ in table.blocks]
    return sum(rows) + sum(bool(block) for block in blocks) + len(blocks) // 2


_ESCAPES = str.maketrans(
    {
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
        '"': "''",
        "\u00a0": "~",
        "\u2212": r"\ensuremath{-}",
        "`": r"\textasciigrave{}",
        "\u2013": r"\textendash{}",
        "\u2014": r"\textemdash{}",
        "\u2018": "`",
        "\u2019": "'",
        "\u201c": "``",
        "\u201d": "''",
        "\u2026": r"\ldots{}",
        "\u00b5": r"\ensuremath{\mu}",
        "\u2264": r"\ensuremath{\leq}",
        "\u2265": r"\ensuremath{\geq}",
        "\u00b1": r"\ensuremath{\pm}",
        "\u00d7": r"\ensuremath{\times}",
        "\u00b2": r"\ensuremath{^2}",
        "\u00b0": r"\ensuremath{^\circ}",
        "\u221e": r"\ensuremath{\infty}",
        "\n": " ",
        "\r": " ",
        "\t": " ",
    }
)


def latex_text(text: str) -> str:
    """Escape text so that LaTeX prints it as it is; two hyphens stay two."""
    return text.translate(_ESCAPES).replace("--", "-{}-")


def latex_bytes(table: Table) -> bytes:
    r"""Write a table for `\input`; its first line names the packages that it needs.

    Letters that pdfLaTeX has no glyph for (a pack called "包") are left as they are, for XeLaTeX and LuaLaTeX.
    """
    columns = [column for column in table.heads if column.fields != PROVENANCE or table.name == "provenance"]
    layout = layout_of(table, columns)
    spec = "@{}" + "".join(_type(column, layout) for column in columns) + "@{}"
    long = layout.lines > PAGE_LINES
    heads = " & ".join(_head(column, layout) for column in columns) + r" \\"
    notes = table.footnotes
    below = [rf"\textsuperscript{{{mark}}}~{latex_text(note)}" for mark, note in table.explained.items()]
    caption = latex_text(table.caption)
    label = rf"\label{{tab:{table.name.replace('_', '-')}}}"
    packages = "array, booktabs, longtable" if long else "array, booktabs"
    small = rf"{layout.size}\setlength{{\tabcolsep}}{{2.5pt}}"
    body = _body(table, columns, notes, layout.shares)
    if long:
        lines = [
            r"\begingroup",
            rf"{small}\setlength{{\LTcapwidth}}{{\linewidth}}",
            rf"\begin{{longtable}}{{{spec}}}",
            rf"\caption{{{caption}}} {label} \\",
            *(r"\toprule", heads, r"\midrule", r"\endfirsthead"),
            r"\caption[]{(continued)} \\",
            *(r"\toprule", heads, r"\midrule", r"\endhead"),
            *(r"\bottomrule", r"\endfoot"),
            *body,
            r"\end{longtable}",
            *([r"\noindent " + r"\\ ".join(below) + r"\par"] if below else []),
            r"\endgroup",
        ]
    else:
        lines = [
            r"\begin{table}",
            r"\centering",
            rf"\caption{{{caption}}}",
            label,
            small,
            rf"\begin{{tabular}}{{{spec}}}",
            *(r"\toprule", heads, r"\midrule"),
            *body,
            *(r"\bottomrule", r"\end{tabular}"),
            *([r"\par\raggedright " + r"\\ ".join(below)] if below else []),
            r"\end{table}",
        ]
    return ("\n".join([rf"% needs \usepackage{{{packages}}}", *lines]) + "\n").encode("utf-8")


def _type(column: Column, layout: Layout) -> str:
    if column in layout.shares:
        return rf">{{\raggedright\arraybackslash}}p{{{layout.shares[column]:.3f}\linewidth}}"
    return "r" if column.numeric else "l"


def _head(column: Column, layout: Layout) -> str:
    lines = [latex_text(line) for line in layout.heads[column]]
    if len(lines) == 1 or column in layout.shares:
        return " ".join(lines)
    return rf"\shortstack[{'r' if column.numeric else 'l'}]{{" + r"\\".join(lines) + "}"


def _body(table: Table, columns: Sequence[Column], notes: dict[str, str], broken: Container[Column]) -> list[str]:
    places = {table.columns.index(column): column in broken for column in columns}
    lines: list[str] = []
    for block, rows in table.blocks:
        if lines:
            lines.append(r"\addlinespace")
        if block:
            lines.append(rf"\multicolumn{{{len(columns)}}}{{@{{}}l@{{}}}}{{\textit{{{latex_text(block)}}}}} \\*")
        for row in rows:
            text = " & ".join(_cell(row.cells[place], notes, breaks) for place, breaks in places.items())
            lines.append(text + r" \\" + _source(row, places))
    return lines


def _source(row: Row, places: Container[int]) -> str:
    """Write the row's provenance id as a comment, where it is no column of its own."""
    ids = [cell.text for place, cell in enumerate(row.cells) if cell.provenance and place not in places]
    return " % " + latex_text(" ".join(ids)) if ids else ""


def _cell(cell: Cell, notes: dict[str, str], breaks: bool) -> str:
    mark = rf"\textsuperscript{{{notes[cell.note]}}}" if cell.note in notes else ""
    text = latex_text(cell.text.replace(NO_BREAK, " ") if breaks else cell.text)
    # A line that starts with a bracket would be read as an argument of the line break before it.
    return ("{}" if text.startswith(("[", "*")) else "") + text + mark
