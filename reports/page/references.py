"""What a report used and names: software with versions, methods with their sources, as a sentence and as BibTeX."""

from __future__ import annotations

import importlib.resources
import re

from reports.content import ReportContent
from reports.display import list_text
from reports.tables.formats.as_latex import latex_text


def software_sentence(content: ReportContent) -> str:
    """Name software with versions, and the sources of methods, for the paragraph on methods."""
    used = list_text([f"{name} {version}" for name, version in _software(content).items()])
    entries = _entries()
    sources = [_short(entries[key]) for key in content.sources]
    return f"Software: {used}.{f' Sources: {list_text(sources)}.' if sources else ''}"


def references_bib(content: ReportContent) -> bytes:
    """Write software and sources as BibTeX, UTF-8: what `software_sentence` names, no more and no less."""
    entries = _entries()
    year = content.made_at[:4]
    software = [
        entries[name].replace("VERSION", latex_text(version)).replace("{YEAR}", f"{{{year}}}")
        for name, version in _software(content).items()
        if name in entries
    ]
    return ("\n\n".join([*software, *(entries[key] for key in content.sources)]) + "\n").encode("utf-8")


def _software(content: ReportContent) -> dict[str, str]:
    return {"labbook": content.software_version, **dict(content.software)}


def _entries() -> dict[str, str]:
    """Return the entries of the file of references by their keys."""
    text = importlib.resources.files("reports").joinpath("templates", "references.bib").read_text(encoding="utf-8")
    return {entry.partition("{")[2].partition(",")[0]: entry for entry in text.strip().split("\n\n")}


def _short(entry: str) -> str:
    """Write who and when, as a sentence cites it."""
    authors, year = (re.search(rf"{field} = {{(.*)}},", entry) for field in ("author", "year"))
    assert authors is not None  # noqa: S101 - every entry has both, as the tests see to
    assert year is not None  # noqa: S101
    names = [name.partition(",")[0].replace(r"{\"u}", "ü") for name in authors[1].split(" and ")]
    return f"{list_text(names) if len(names) < 3 else names[0] + ' et al.'} {year[1]}"
