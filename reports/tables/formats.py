r"""Tables as CSV, LaTeX, LaTeX macros and Markdown.

CSV has full precision, stored units, and is safe to open in a spreadsheet.

LaTeX has booktabs rules, units in the heads, every special character escaped, no wider than its column.

Numbers are text that is rounded already, so no `siunitx` is needed; a row's provenance id follows it as a comment.

The macros are numbers of page one and of planned comparisons, for `\input{numbers}`: `\labbookOverallSaving{}`.

A name says what the number is and of which group; levels are spelt out, for a macro's name has letters alone. It stays
the same from report to report, so that a paper takes over new numbers when it is typeset again. Numbers of groups whose
names would be the same ("a b" and "ab") have none: a paper must not get another group's number unseen.

Markdown has the caption, then the rows; the last cell of a strong row is bold.
"""

from __future__ import annotations

import csv
import io
import math
import re
import unicodedata
from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.display import (
    NO_BREAK,
    SUPERSCRIPTS,
    as_shown,
    interval_text,
    p_text,
    places_of,
    value_text,
    with_unit,
)
from reports.naming import swept_factor
from reports.numbers import Number, Value
from reports.results import Comparison, Decision, OverallEquivalence, OverallSavings, StudyResults
from reports.tables.table import PROVENANCE, Cell, Column, Raw, Row, Table

_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\n")


def csv_bytes(table: Table) -> bytes:
    """Write a table as CSV (UTF-8, comma, LF, one line of names): floats as their shortest exact text.

    A number that does not exist is an empty field, its reason stands in the last column `undefined`. Text that a
    spreadsheet would run as a formula gets an apostrophe in front; no-break spaces become spaces, line ends LF.
    """
    names = [name for column in table.columns for name in column.fields]
    with_block = any(row.block for row in table.rows)
    with_reasons = any(
        isinstance(value, Undefined) for row in table.rows for cell in row.cells for value in cell.values
    )
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["block"] * with_block + names + ["undefined"] * with_reasons)
    for row in table.rows:  # one at a time: there are as many as runs
        values = [value for cell in row.cells for value in cell.values]
        line = [row.block] * with_block + values + [_reasons(names, values)] * with_reasons
        writer.writerow([csv_field(value) for value in line])
    return stream.getvalue().encode("utf-8")


def _reasons(names: list[str], values: list[Raw]) -> str:
    return "; ".join(f"{n}: {v.reason}" for n, v in zip(names, values, strict=True) if isinstance(v, Undefined))


def csv_field(value: Raw) -> str:
    """Return a value as a cell of a CSV file; text that a spreadsheet would run as a formula gets an apostrophe."""
    if type(value) is float:
        return repr(value)
    if type(value) is str and value.isalnum():
        return value
    match value:
        case None | Undefined():
            return ""
        case str():
            return safe_text(value)
        case int():
            return str(int(value))
        case _:
            return repr(float(value))  # a numpy float would give its type's name


def safe_text(text: str) -> str:
    """Return a text as a cell that no spreadsheet runs as a formula, with plain blanks and line ends."""
    text = text.replace(NO_BREAK, " ").replace("\r\n", "\n").replace("\r", "\n")
    return f"'{text}" if text.startswith(_FORMULA_STARTS) else text


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

    Where that is still too wide, each word of a head has its line. Columns of prose share the room by how much stands
    in them; the first of words breaks where numbers leave no room.
    """
    texts = {column: [row.cells[table.columns.index(column)].text for row in table.rows] for column in columns}
    gaps = _GAP_LETTERS * (len(columns) - 1)
    for broken in (_two_lines, _each_word):
        heads = {column: broken(column.head) for column in columns}
        wide = {column: max(map(len, [*heads[column], *texts[column]])) for column in columns}
        least = gaps + sum(min(wide[column], _PROSE_LETTERS) if column.prose else wide[column] for column in columns)
        size, line = next(((name, letters) for name, letters in _SIZES if least <= letters), _SIZES[-1])
        if least <= line:
            break
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


def _each_word(head: str) -> tuple[str, ...]:
    """Break a head at each blank."""
    return tuple(head.split())


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
        "\u00b0": r"\ensuremath{^\circ}",
        "\u221e": r"\ensuremath{\infty}",
        "\n": " ",
        "\r": " ",
        "\t": " ",
    }
)


_AS_LATIN = {"ALPHA": "A", "BETA": "B", "EPSILON": "E", "ZETA": "Z", "ETA": "H", "IOTA": "I", "KAPPA": "K", "MU": "M",
             "NU": "N", "OMICRON": "O", "RHO": "P", "TAU": "T", "CHI": "X"}  # fmt: skip
"""Greek capitals for which LaTeX has no name, because they look as Latin ones."""


def _greek() -> dict[int, str]:
    """Return what stands for each Greek letter: a factor's symbol, Kendall's tau."""
    found = {}
    for code in (*range(0x391, 0x3AA), *range(0x3B1, 0x3CA)):
        words = unicodedata.name(chr(code), "").split()
        if len(words) != 4:
            continue  # no letter, or the sigma at the end of a word
        _greek_word, size, _letter, name = words
        name = {"LAMDA": "LAMBDA"}.get(name, name)
        if size == "CAPITAL":
            found[code] = (
                rf"\ensuremath{{\mathrm{{{_AS_LATIN[name]}}}}}" if name in _AS_LATIN else _math(name.capitalize())
            )
        else:
            found[code] = "o" if name == "OMICRON" else _math(name.lower())
    return found


def _math(name: str) -> str:
    return rf"\ensuremath{{\{name}}}"


_ESCAPES.update(_greek())


def latex_text(text: str) -> str:
    """Escape text so that LaTeX prints it as it is; two hyphens stay two."""
    escaped = text.translate(_ESCAPES).replace("--", "-{}-")
    return escaped if escaped.isascii() else _RAISED.sub(_exponent, escaped)


_RAISED = re.compile(f"[{''.join(SUPERSCRIPTS.values())}]+")
_LOWERED = str.maketrans({raised: plain for plain, raised in SUPERSCRIPTS.items()})


def _exponent(raised: re.Match[str]) -> str:
    return rf"\ensuremath{{^{{{raised[0].translate(_LOWERED)}}}}}"


def latex_bytes(table: Table) -> bytes:
    r"""Write a table for `\input`; its first line names the packages that it needs.

    Letters that pdfLaTeX has no glyph for (a pack called "包") are left as they are, for XeLaTeX and LuaLaTeX.
    """
    columns = [column for column in table.heads if column.fields != (PROVENANCE,) or table.name == "provenance"]
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


_HEAD = (
    "% Numbers of a report by labbook {}: \\input this file, and write \\labbookRunsDone{{}} in a sentence.\n"
    "% After each macro stands the provenance id of its number: labbook why ID.\n"
)
_SIGNS = {
    "0": "Zero",
    "1": "One",
    "2": "Two",
    "3": "Three",
    "4": "Four",
    "5": "Five",
    "6": "Six",
    "7": "Seven",
    "8": "Eight",
    "9": "Nine",
    ".": "Point",
    "-": "Minus",
    "\u2212": "Minus",
    "+": "Plus",
}


@dataclass(frozen=True, slots=True)
class Macro:
    """A macro: its name without the backslash, the text as the report prints it, the id that it comes from."""

    name: str
    text: str
    provenance: str = ""


def macros_of(results: StudyResults) -> tuple[Macro, ...]:
    """Return a macro a number of page one and of planned comparisons, but for those whose names would be the same."""
    found = (*_counts(results), *_over_groups(results), *_by_group(results), *_contrasts(results))
    times = Counter(macro.name for macro in found)
    return tuple(macro for macro in found if times[macro.name] == 1)


def macros_bytes(results: StudyResults) -> bytes:
    """Write the macros as a file for LaTeX, UTF-8."""
    lines = [
        rf"\newcommand{{\{macro.name}}}{{{latex_text(macro.text)}}}"
        + (f" % {macro.provenance}" * bool(macro.provenance))
        for macro in macros_of(results)
    ]
    return (_HEAD.format(results.software_version) + "\n".join(lines) + "\n").encode("utf-8")


def macro_name(*words: str) -> str:
    """Join words to a name for LaTeX: letters stay, each word begins with a capital, digits and signs are spelt out.

    A sign without a word of its own, such as a letter with an accent, has its code point.
    """
    coded = (re.sub(r"[^A-Za-z0-9_ .+\u2212-]", lambda sign: f" code {ord(sign[0])} ", word) for word in words)
    spelt = (re.sub(r"[0-9.+\u2212-]", lambda sign: f" {_SIGNS[sign[0]]} ", word) for word in coded)
    parts = re.findall(r"[A-Za-z]+", " ".join(spelt).replace("_", " "))
    return "labbook" + "".join(part[0].upper() + part[1:] for part in parts)


def _counts(results: StudyResults) -> Iterator[Macro]:
    flow = results.flow
    if flow.runs_planned is not None:
        yield Macro(macro_name("runs planned"), str(flow.runs_planned))
    counts = {"done": flow.runs_done, "void": flow.runs_void, "idle": flow.runs_idle}
    for name, count in counts.items():
        yield Macro(macro_name("runs", name), str(count))
    for outcome in results.outcomes:
        yield Macro(macro_name("runs with", outcome.key), str(flow.runs_with[outcome]))
    if flow.runs_with.get(Outcome.APEX):  # jumps are counted of the runs that have apex heights
        yield Macro(macro_name("jumps made"), str(flow.jumps_made))
        yield Macro(macro_name("jumps analysed"), str(flow.jumps_analysed))
    yield Macro(macro_name("days measured"), str(len(results.days)))


def _over_groups(results: StudyResults) -> Iterator[Macro]:
    for overall in results.overall:
        name = ("overall saving", "" if overall.quantity is Outcome.JOULES else overall.quantity.key)
        yield from _number(name, overall.savings, overall.test.p)
        yield from _scope(name, overall, overall.savings)
        yield from _value((*name, "spread"), overall.spread, overall.savings)
    if results.overall_equivalence is not None:
        tested = results.overall_equivalence
        heights = ("overall apex equivalence",)
        yield from _number(heights, tested.estimate, tested.p.value)
        yield from _scope(heights, tested, tested.estimate)


def _scope(name: Iterable[str], scope: OverallSavings | OverallEquivalence, number: Number) -> Iterator[Macro]:
    yield Macro(macro_name(*name, "groups"), str(len(scope.groups)), number.provenance)
    yield Macro(macro_name(*name, "days"), str(len(scope.days)), number.provenance)


def _by_group(results: StudyResults) -> Iterator[Macro]:
    for comparison in (*results.pooled, *_planned_levels(results)):
        group = [f"{factor} {level}" for factor, level in comparison.group.items()]
        name = (comparison.quantity.key, *group, *_level(results, comparison))
        lead = comparison.decision
        if lead.savings is not None:
            yield from _number((*name, "saving"), lead.savings, lead.test.p)
        yield from _number((*name, "difference"), lead.difference, lead.test.p)
        yield from _runs(name, lead)
        if (tested := lead.equivalence) is not None:
            yield from _number((*name, "equivalence"), tested.estimate, tested.p.value)


def _contrasts(results: StudyResults) -> Iterator[Macro]:
    for one in (each for each in results.contrasts if not each.exploratory):
        words = (str(one.kind), one.quantity.key, one.factor, *one.levels, one.side)
        at = () if one.at is None else ("at", f"{one.at:g}")
        yield from _number(("contrast", *filter(None, words), *at), one.estimate, one.test.p)


def _planned_levels(results: StudyResults) -> list[Comparison]:
    """Return the comparisons of one level with the control that the plan names."""
    return [each for each in results.by_group if not (each.opens or each.exploratory)]


def _level(results: StudyResults, comparison: Comparison) -> list[str]:
    swept = swept_factor(results)
    return [] if comparison.opens or swept is None else [f"{swept.name} {comparison.level}"]


def _runs(name: tuple[str, ...], lead: Decision) -> Iterator[Macro]:
    identity = lead.difference.provenance
    yield Macro(macro_name(*name, "runs control"), str(lead.n_control), identity)
    yield Macro(macro_name(*name, "runs treatment"), str(lead.n_treatment), identity)
    yield Macro(macro_name(*name, "days"), str(len(lead.days)), identity)
    if lead.adjusted is not None:
        yield Macro(macro_name(*name, "p Holm"), p_text(lead.adjusted.value), lead.adjusted.provenance)


def _number(name: Iterable[str], number: Number, p: Value) -> Iterator[Macro]:
    """Give a number, the ends of its interval, the interval in one, and p."""
    shown, places = as_shown(number), places_of(number)
    yield from _value(name, number, number)
    for end, value in (("low", shown.ci_low), ("high", shown.ci_high)):
        if value is not None:
            yield Macro(macro_name(*name, end), _with_unit(value, places, shown.unit), number.provenance)
    if interval := interval_text(number):
        yield Macro(macro_name(*name, "interval"), interval, number.provenance)
    yield Macro(macro_name(*name, "p"), p_text(p), number.provenance)


def _value(name: Iterable[str], number: Number, digits_of: Number) -> Iterator[Macro]:
    shown = as_shown(number)
    text = _with_unit(shown.value, places_of(digits_of), shown.unit)
    yield Macro(macro_name(*name), text, number.provenance)


def _with_unit(value: Value, places: int | None, unit: str) -> str:
    text = value_text(value, places)
    return text if isinstance(value, Undefined) else with_unit(text, unit)


def markdown_text(table: Table) -> str:
    """Write the columns of a table that are shown, heads with their units."""
    head, *rows = table.texts
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for row, cells in zip(table.rows, rows, strict=True):
        texts = [text.replace("|", "\\|") for text in cells]
        if row.strong:
            texts[-1] = f"**{texts[-1]}**"
        lines.append(f"| {' | '.join(texts)} |")
    return "\n".join([f"{table.caption}\n", *lines, ""])
