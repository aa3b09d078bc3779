"""A report on disk: one self-contained HTML page, its figures as SVG, every table as CSV and LaTeX."""

from __future__ import annotations

import importlib.resources
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import Any

import jinja2

from data_schema.disk import replace_together
from data_schema.errors import UsageError
from data_schema.outcomes import Outcome
from reports.display import count_text, list_text
from reports.figures.by_level import file_name
from reports.figures.registry import DRAWN, FIGURES, Wanted, cached_figure, figures_of
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN, is_narrow
from reports.page.policy import content_policy
from reports.page.sections import (
    Bullets,
    FigureHere,
    FiguresBeside,
    Paragraph,
    Part,
    Section,
    TableHere,
    references_bib,
    sections_of,
)
from reports.results import StudyResults
from reports.tables.each_run import name_points, run_anchors
from reports.tables.formats import csv_bytes, latex_bytes, macros_bytes
from reports.tables.headlines import HEADLINES
from reports.tables.registry import TABLES, tables_of
from reports.tables.table import Table
from reports.tables.word import WORD, word_bytes

_PROLOG = re.compile(r"^.*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>|<!--.*?-->", re.DOTALL)
_OPENING = re.compile(r"<svg\b[^>]*>")
_VIEW_BOX = re.compile(r'viewBox="([^"]*)"')


def inline_svg(svg: bytes, name: str, title: str, alternative: str) -> str:
    """Return the drawing as an `<svg>` element for HTML, described to those who cannot see it.

    `name` goes in front of every id, so that two figures on one page do not take each other's shapes.
    """
    text = _METADATA.sub("", _PROLOG.sub("", svg.decode("utf-8")))
    for before in (' id="', 'href="#', "url(#"):
        text = text.replace(before, f"{before}{name}-")
    opening = _OPENING.search(text)
    box = _VIEW_BOX.search(text)
    if opening is None or box is None:
        raise ValueError(f"figure {name!r} is no SVG with a viewBox")
    width_pt = float(box.group(1).split()[2])
    wide = "" if is_narrow(width_pt / 72) else 'class="wide" '
    head = (
        f'<svg {wide}viewBox="{box.group(1)}" style="width:{width_pt / 72:.3f}in" role="img" '
        f'aria-labelledby="{name}-title {name}-desc">'
        f'<title id="{name}-title">{escape(title)}</title><desc id="{name}-desc">{escape(alternative)}</desc>'
    )
    return head + text[opening.end() :].strip()


_WIDTHS = {"": TWO_COLUMNS_IN, "_one_column": ONE_COLUMN_IN}
"""File name's end -> width: each figure fits both columns of a paper, and one."""


def report_files(
    results: StudyResults,
    *,
    summary: bool = False,
    every_figure: bool = False,
    word: bool = False,
    templates: Path | None = None,
) -> dict[str, bytes]:
    """Make a report: name below its folder -> bytes, in the order in which they are written, its pages last.

    The figures are those of the page, at the width that they have there; with `every_figure` each as SVG and PDF, at
    both widths. With `summary` its first page stands alone in `summary.html`, too; with `word` the tables are in
    `tables.docx` as well. Pages come from the `templates` of a lab where its folder has them.
    """
    of_page = None if every_figure else _drawn_on(sections_of(results))
    figures = _figure_files(results, of_page)
    drawings = {name.removesuffix(".svg"): data for name, data in figures.items() if name.endswith(".svg")}
    return {
        **{_figure_path(name, results): data for name, data in figures.items()},
        **_but_figures(results, drawings, summary=summary, word=word, templates=templates),
    }


def files_beside_figures(
    results: StudyResults, drawn: Mapping[str, bytes], *, summary: bool = False
) -> dict[str, bytes]:
    """Make a report's files but for its figures, which are `drawn` already: name below its folder -> bytes.

    Raises `KeyError` with the name of a figure that is not there, `ValueError` where one is no drawing.
    """
    wanted = _drawn_on(sections_of(results))
    known = {f"{kind.name}{ending}" for kind in figures_of(results) for ending in _WIDTHS}
    drawings = {name: drawn[_figure_path(f"{name}.svg", results)] for name in sorted(wanted & known)}
    return _but_figures(results, drawings, summary=summary)


def _figure_path(name: str, results: StudyResults) -> str:
    return f"figures/{file_name(name, results)}"


def _but_figures(
    results: StudyResults,
    drawings: Mapping[str, bytes],
    *,
    summary: bool,
    word: bool = False,
    templates: Path | None = None,
) -> dict[str, bytes]:
    tables, table_files = _tables(results)
    pages = {"report.html": render_page(results, drawings, tables, templates=templates)}
    if summary:
        pages = {"summary.html": render_page(results, drawings, tables, first_only=True, templates=templates), **pages}
    return {
        **({WORD: word_bytes(results, tables.values())} if word else {}),
        **{f"tables/{name}": data for name, data in table_files.items()},
        "numbers.tex": macros_bytes(results),
        "references.bib": references_bib(results),
        MARK: f"{results.made_at}{'' if results.stored else ' unsaved'}".encode(),
        **{name: page.encode("utf-8") for name, page in pages.items()},
    }


def _tables(results: StudyResults) -> tuple[dict[str, Table], dict[str, bytes]]:
    """Return the tables by name, and their files."""
    many = not run_anchors(results)  # so many runs are for programs, and no paper prints them
    tables, files = {}, {}
    for kind in tables_of(results):
        table = kind.make(results)
        files[f"{kind.name}.csv"] = csv_bytes(table)
        tables[kind.name] = table = replace(table, rows=()) if many and kind.by_run else table
        files[f"{kind.name}.tex"] = latex_bytes(table)
    return tables, files


def write_report(files: Mapping[str, bytes], out_dir: Path) -> Path:
    """Write what `report_files` made into a folder, which is made where it is missing.

    Once all are on disk each replaces its predecessor in one step, the page last: where one cannot be written, an
    earlier report stays whole. What else it left of its files is removed: it would show other numbers than the page.
    Returns where the page is. Raises `UsageError` where the folder cannot be written to.
    """
    refuse_foreign(out_dir)
    try:
        out_dir.mkdir(parents=True, exist_ok=True)
        (out_dir / MARK).touch()  # first: a folder with others and without it would be refused as a paper's own
        for folder in ("figures", "tables"):
            (out_dir / folder).mkdir(exist_ok=True)
        written = {out_dir / name: data for name, data in files.items()}
        with replace_together(written):
            pass
        for path in _of_a_report(out_dir) - written.keys():
            path.unlink(missing_ok=True)
    except OSError as error:
        raise UsageError(
            f"the report cannot be written to {str(out_dir)!r} ({error.strerror or error}): give a folder that can be "
            "written, with --out."
        ) from error
    return out_dir / "report.html"


def refuse_foreign(out_dir: Path) -> None:
    """Raise `UsageError` for a folder with files that a report would replace, but of no report: a paper's own."""
    found = [name for name in _NAMES if (out_dir / name).exists()]
    if not found or (out_dir / MARK).exists():
        return
    raise UsageError(
        f"{str(out_dir)!r} has {list_text(found)}, which no report of labbook wrote and this one would replace: name "
        f"another folder, such as {str(out_dir / 'report')!r}."
    )


def _of_a_report(out_dir: Path) -> set[Path]:
    """Return every path that a report may write but for those that all write."""
    figures = {f"{name}{ending}.{suffix}" for name in FIGURES for ending in _WIDTHS for suffix in _FORMATS}
    for suffix in _FORMATS:  # also those named after the factor of another study
        by_factor = (path.name for one in Outcome for path in (out_dir / "figures").glob(f"{one.key}_by_*.{suffix}"))
        figures.update(by_factor)
    tables = {f"{name}.{suffix}" for name in TABLES for suffix in ("csv", "tex")}
    return {
        *(out_dir / "figures" / name for name in figures),
        *(out_dir / "tables" / name for name in tables),
        *(out_dir / name for name in (*_PAGES, WORD)),
    }


OWN_TEMPLATES = ("report.html.j2", "parts.html.j2", "report.css", "report.js")
"""What a lab's folder of templates may hold; what it lacks is labbook's own."""
_FORMATS = ("svg", "pdf")
MARK = ".labbook-report"
"""A file in the folder of a report, which says when it was made: what has the names of its files there is labbook's."""
_PAGES = ("report.html", "summary.html", "report.pdf", "summary.pdf")
_NAMES = (*_PAGES, WORD, "numbers.json", "numbers.tex", "references.bib", "figures", "tables")
"""What a report puts into its folder."""


def _figure_files(results: StudyResults, of_page: set[str] | None) -> dict[str, bytes]:
    """Draw figures, file name -> bytes.

    `of_page` names those of the page, "_one_column" behind the narrow ones, which are wanted as SVG; None for every
    figure at both widths as SVG and PDF.
    """
    formats = _FORMATS if of_page is None else ("svg",)
    files = {
        f"{kind.name}{ending}.{suffix}": data
        for kind in figures_of(results)
        for ending, width_in in _WIDTHS.items()
        if of_page is None or f"{kind.name}{ending}" in of_page
        for suffix, data in cached_figure(results, Wanted(kind, width_in, formats)).items()
    }
    DRAWN.forget_unused()
    return files


def _drawn_on(sections: Sequence[Section]) -> set[str]:
    """Return the names of the drawings on a page."""
    parts = [part for section in sections for part in section.parts]
    wide = {part.name for part in parts if isinstance(part, FigureHere)}
    return wide | {f"{name}_one_column" for part in parts if isinstance(part, FiguresBeside) for name in part.names}


def render_page(
    results: StudyResults,
    drawings: Mapping[str, bytes],
    tables: Mapping[str, Table],
    *,
    first_only: bool = False,
    templates: Path | None = None,
) -> str:
    """Return the page's HTML; `drawings` has the SVG of each figure by name, "_one_column" behind it for the narrow.

    With `first_only` it is the first section alone, whose numbers keep their ids without a table to link to, and whose
    references to other sections say where these are.
    """
    anchors = {} if first_only else run_anchors(results)
    if first_only:
        results = replace(results, first_only=True)
        tables = {**tables, HEADLINES.name: HEADLINES.make(results)}
    planned = sections_of(results)[:1] if first_only else sections_of(results)
    traced = {**tables, "provenance": _of_this_page(tables["provenance"], _ids_of(planned, tables))}
    page = _Page(results, drawings, traced, anchors)
    sections = list(map(page.section, planned))
    shown = {
        "content": results,
        "summary": _summary(results),
        "facts": _facts(results),
        "sections": [section for section in sections if section["parts"]],
        "first_only": first_only,
        "known_ids": set() if first_only else {row.cells[0].text for row in traced["provenance"].rows},
    }
    try:
        return environment(templates).get_template("report.html.j2").render(**shown)
    except jinja2.TemplateError as error:
        if templates is None:
            raise
        raise UsageError(
            f"the templates in {str(templates)!r} fail ({_where(error)}): docs/own-page.md lists what they get."
        ) from error


class _Compiled(jinja2.BytecodeCache):
    """Templates as they were compiled before, in the cache of drawn figures: a tenth of the page's time."""

    def load_bytecode(self, bucket: jinja2.bccache.Bucket) -> None:
        """Take what was compiled of the same source, where it is there."""
        if (known := DRAWN.read(self._name(bucket))) is not None:
            bucket.bytecode_from_string(known)

    def dump_bytecode(self, bucket: jinja2.bccache.Bucket) -> None:
        """Keep what was compiled."""
        DRAWN.write(self._name(bucket), bucket.bytecode_to_string())

    def _name(self, bucket: jinja2.bccache.Bucket) -> str:
        return f"{bucket.key}-{bucket.checksum}.template"


def environment(own: Path | None = None) -> jinja2.Environment:
    """Return what renders the templates of pages: a lab's `own`, where its folder has one of the name.

    Templates that are not labbook's are run in a sandbox: they see what they are given, and no file.
    """

    def load(name: str) -> str | None:
        if own is not None and name in OWN_TEMPLATES and (own / name).is_file():
            return (own / name).read_text(encoding="utf-8")
        return _template(name)

    made = jinja2.Environment
    if own is not None:
        from jinja2.sandbox import SandboxedEnvironment  # other reports do not wait for it

        made = SandboxedEnvironment
    found = made(
        loader=jinja2.FunctionLoader(load),
        bytecode_cache=_Compiled() if own is None else None,  # what is compiled for a sandbox runs in one alone
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.globals["content_policy"] = content_policy
    return found


def _where(error: jinja2.TemplateError) -> str:
    """Return the line of a template at which it went wrong."""
    line = error.lineno if isinstance(error, jinja2.TemplateSyntaxError) else None
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == "<template>":
            line = trace.tb_lineno
        trace = trace.tb_next
    return f"{error}" if line is None else f"line {line}: {error}"


def refuse_no_template(folder: Path) -> None:
    """Raise `UsageError` for a folder without a template of pages, or with one that is no template."""
    found = [name for name in OWN_TEMPLATES if (folder / name).is_file()]
    if not found:
        raise UsageError(
            f"{str(folder)!r} has no template of labbook's page: put one of {', '.join(OWN_TEMPLATES)} there, "
            "beginning with a copy of labbook's own."
        )
    for name in found:
        try:
            environment(folder).get_template(name)
        except UnicodeDecodeError as error:
            raise UsageError(f"{str(folder / name)!r} is not UTF-8 ({error}): mend it.") from error
        except jinja2.TemplateError as error:
            raise UsageError(f"{str(folder / name)!r} cannot be used ({_where(error)}): mend it.") from error


def figure_page(svg: bytes, title: str, alternative: str) -> str:
    """Return a page of one drawing that fills the window and zooms on request; it asks nothing of the network."""
    drawing = inline_svg(svg, "figure", title, alternative)
    return environment().get_template("figure.html.j2").render(title=title, drawing=drawing, alternative=alternative)


def _ids_of(sections: Sequence[Section], tables: Mapping[str, Table]) -> set[str]:
    """Return the provenance ids that stand somewhere on the page."""
    parts = [part for section in sections for part in section.parts]
    paragraphs = [part for part in parts if isinstance(part, Paragraph)]
    paragraphs += [item for part in parts if isinstance(part, Bullets) for item in part.items]
    found = {identity for paragraph in paragraphs for identity in paragraph.provenance}
    placed = [tables[part.name] for part in parts if isinstance(part, TableHere) and part.name != "provenance"]
    cells = (cell for table in placed for row in table.rows for cell in table.cells(row))
    return found | {cell.text for cell in cells if cell.provenance}


def _of_this_page(table: Table, ids: set[str]) -> Table:
    """Cut the table of provenance down to the ids that a reader of the page can meet; the file has them all."""
    rows = tuple(row for row in table.rows if row.cells[0].text in ids)
    left = len(table.rows) - len(rows)
    more = f" {count_text(left, 'more number')}: tables/provenance.csv." if left else ""
    return replace(table, rows=rows, caption=table.caption + more)


def _template(name: str) -> str | None:
    if Path(name).is_absolute() or ".." in Path(name).parts:
        return None
    return importlib.resources.files("reports").joinpath("templates", name).read_text(encoding="utf-8")


def _summary(results: StudyResults) -> str:
    """Return the line under the title: what was selected, and when it was measured."""
    parts = [results.selection or "all runs"]
    if results.days:
        first, last = results.days[0].date, results.days[-1].date
        dates = first if first == last else f"{first} to {last}"
        parts.append(f"{dates}, {count_text(len(results.days), 'day')}")
    made = f"Report of {results.made_at}."
    return f"{'; '.join(parts)}. {f'As of {results.as_of}. ' if results.as_of else ''}{made}"


def _facts(results: StudyResults) -> list[tuple[str, str]]:
    """Return what stands under the answer: name and text."""
    facts = [] if results.study in results.title else [("Study", results.study)]
    if results.people:
        facts.append(("People", list_text(results.people)))
    facts += [
        ("Software", f"labbook {results.software_version}, labbook.toml {results.configuration_hash}"),
        ("Detector", results.detector),
    ]
    if results.as_of:
        facts.append(("As of", f"{results.as_of}, by the journal; what was stated since is not in it"))
    elif results.entry:
        facts.append(("As of", f"entry {results.entry} of the journal"))
    if not results.stored:
        facts.append(("Stored", "no: `labbook why` knows those of its numbers that a stored report has too"))
    return facts


@dataclass
class _Page:
    """What the parts of a page are made of, and how many figures and tables it has so far."""

    results: StudyResults
    drawings: Mapping[str, bytes]
    tables: Mapping[str, Table]
    anchors: Mapping[str, str]
    n_figures: int = 0
    n_tables: int = 0

    def section(self, section: Section) -> dict[str, Any]:
        """Turn a section into what the template shows; empty tables are left out."""
        parts = [part for part in map(self.part, section.parts) if part is not None]
        return {"anchor": section.anchor, "title": section.title, "folded": section.folded, "parts": parts}

    def part(self, part: Part) -> dict[str, Any] | None:
        """Turn a part into what the template shows; figures and tables get their number."""
        match part:
            case FigureHere(name):
                return self.figure(name, name)
            case FiguresBeside(names):
                narrow = [self.figure(name, f"{name}_one_column") for name in names]
                return {"kind": "FiguresBeside", "figures": narrow}
            case TableHere(name):
                if not self.tables[name].rows:
                    return None
                self.n_tables += 1
                return {"kind": "TableHere", "number": self.n_tables, "table": self.tables[name]}
            case _:
                return {"kind": type(part).__name__, "part": part}

    def figure(self, name: str, drawn: str) -> dict[str, Any]:
        """Show a drawing under the next number, or say why there is none."""
        kind = FIGURES[name]
        if (reason := kind.absent(self.results)) is not None:
            return {"kind": "Paragraph", "part": Paragraph(reason)}
        self.n_figures += 1
        drawing = inline_svg(self.drawings[drawn], name, kind.title, kind.alternative(self.results))
        return {
            "kind": "FigureHere",
            "number": self.n_figures,
            "name": name,
            "caption": kind.caption(self.results),
            "drawing": name_points(drawing, name, self.results, self.anchors),
        }
