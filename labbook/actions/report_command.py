"""What `labbook report` does: which runs, the analysis, the statement, the files."""

from __future__ import annotations

import hashlib
import itertools
import os
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import make_folder, sync_all, write_whole
from data_schema.errors import BookReadOnly, UsageError, unknown_name
from data_schema.queries.runs import refuse_empty_selection
from data_schema.queries.study import config_in_force
from data_schema.vocabulary import Action
from data_schema.where import as_number, comparing
from ingest.store import STORED, Store
from labbook.analysis.study import Analysis, analyse
from labbook.book.opening import CONFIGURATION, JOURNAL, REPORTS, Book
from labbook.book.report_numbers import NUMBERS, numbers_bytes, numbers_of_report, numbers_path
from labbook.book.write_session import Statement, new_uid, now_utc
from labbook.config.parsing import Configuration, settings_of_numbers
from labbook.terminal import listed
from reports.page.printing import print_pdf
from reports.page.writing import refuse_foreign, refuse_no_template, report_files, write_report

_ATTEMPTS = 5
_OWN_NAME = re.compile(r"\d{8}T\d{6}Z(-\d+)?")
"""How these are named, by the time."""


@dataclass(frozen=True, slots=True)
class WrittenReport:
    """Where a report was written, and its claims.

    `page` is the first one alone where that was asked for; `as_of` is the number of the last entry that it is of, after
    which `later` others were stated while it was made. `pdf` is "" where none was made, and `no_pdf` is the reason.
    """

    page: str
    folder: str
    claims: tuple[str, ...]
    as_of: int
    later: int = 0
    pdf: str = ""
    no_pdf: str = ""


@dataclass(frozen=True, slots=True)
class DrawnReport:
    """A report's files, name to bytes, their folder as it counts from the book's, and what puts them there."""

    folder: str
    files: Mapping[str, bytes]
    put: Callable[[], None]


def selection(
    configuration: Configuration, where: str | None, extra: Sequence[str], options: Mapping[str, object]
) -> str | None:
    """Join `--where` with factor options (`--foot small`, `--foot=small`) to one expression.

    `options` are the command's own by name, with the value of each that was given, None where it was not. Raises
    `UsageError` where one could as well mean the factor of its name.
    """
    for name, given in options.items():
        same = configuration.factors.get(name.replace("-", "_"))
        levels = [] if same is None else [level.label for level in same.levels]
        if (given is True and levels) or str(given) in levels:
            level = levels[0] if given is True else given
            raise UsageError(
                f"--{name} is an option of this command and the name of a factor too: select by the factor with "
                f'--where "{name.replace("-", "_")}={level}".'
            )
    parts = [f"({where})"] if where and extra else [where] if where else []
    words = [word for item in extra for word in (item.split("=", 1) if item.startswith("--") else [item])]
    for word in words:
        if word.startswith("--") and word.removeprefix("--").replace("-", "_") not in configuration.factors:
            raise unknown_name("option", word, [f"--{option}" for option in (*configuration.factors, *options)])
    if len(words) % 2 or any(not words[index].startswith("--") for index in range(0, len(words), 2)):
        raise UsageError(f"{' '.join(extra)!r} is not understood: write --FACTOR LEVEL, for example --foot small.")
    for name, level in zip(words[::2], words[1::2], strict=True):
        factor = name.removeprefix("--").replace("-", "_")
        _refuse_unknown_level(configuration, factor, level, name)
        parts.append(comparing(factor, level))
    return " and ".join(part for part in parts if part) or None


def _refuse_unknown_level(configuration: Configuration, factor: str, level: str, option: str) -> None:
    levels = configuration.factors[factor].levels
    labels = [one.label for one in levels]
    number = as_number(level)
    if level in labels or (number is not None and any(one.value == number for one in levels)):
        return
    what = f"level of {factor} ({option})"
    if number is None:
        raise unknown_name(what, level, labels)
    raise UsageError(f"{level!r} is not a known {what}: allowed are {listed(labels)}.")


def write(
    book: Book,
    where: str | None,
    out: Path | None,
    person: str | None,
    step: Callable[[str], None],
    *,
    unsaved: bool = False,
    summary: bool = False,
    pdf: bool = False,
    every_figure: bool = False,
    word: bool = False,
    templates: Path | None = None,
    as_of: str | None = None,
) -> WrittenReport:
    """Analyse, write the page, state that the report was made.

    With `unsaved` the page is written to `out` and the book stays as it is, as it has to for who may only read it; so
    it is of the book `as_of` an earlier entry or time.
    With `summary` the first page is written alone, too; with `pdf` it, or the whole, is printed where a browser is.
    With `every_figure` each is written as SVG and PDF at both widths, with `word` the tables for Word too. `templates`
    is a folder with a lab's own page.
    """
    if templates is not None:
        refuse_no_template(templates)
    unsaved = unsaved or as_of is not None
    if unsaved and out is None:
        asked = "--unsaved" if as_of is None else "--as-of"
        raise UsageError(f"{asked} writes nothing into the book: add --out DIR, a folder of your own for the report.")
    if out is not None:
        refuse_store(out)
        _refuse_replacing(book, out)
        refuse_foreign(out)
        _check_writable(out)

    def draw(made: Analysis) -> Mapping[str, bytes]:
        step("writing the page")
        return report_files(made.results, summary=summary, every_figure=every_figure, word=word, templates=templates)

    later = 0
    if unsaved:
        made = _unsaved_report(book, where, step) if as_of is None else _report_as_of(book, where, as_of, step)
        drawn = _drawn(book, made, out, draw(made))
        drawn.put()
    else:
        own = {} if templates is None else {"own_page": True}
        made, drawn, later = _saved_report(book, where, out, person, step, draw, own)
    folder = out or book.folder / drawn.folder
    page = folder / ("summary.html" if summary else "report.html")
    printed = page.with_suffix(".pdf")
    if pdf:
        step("printing the page")
    no_pdf = print_pdf(page, printed, one_sheet=summary) if pdf else ""
    return WrittenReport(
        page=str(page),
        folder=str(folder),
        claims=tuple(claim.text for claim in made.results.claims),
        as_of=made.results.entry,
        later=later,
        pdf=str(printed) if pdf and not no_pdf else "",
        no_pdf=no_pdf,
    )


def _drawn(book: Book, made: Analysis, out: Path | None, files: Mapping[str, bytes]) -> DrawnReport:
    """Return a report's files, its `numbers.json` among them, for the folder `out` or a new one of the book."""
    folder = out or _new_folder(book, made)
    every = {**files, NUMBERS: numbers_bytes(numbers_of_report(made))}

    def put() -> None:
        make_folder(folder)
        write_report(every, folder)
        sync_all(folder)

    return DrawnReport(os.path.relpath(folder.resolve(), book.folder.resolve()), every, put)


def _new_folder(book: Book, made: Analysis) -> Path:
    """Return a folder named after the time of the report, and after its number where two are of one second."""
    name = made.results.made_at.replace(":", "").replace("-", "").split(".")[0]
    names = itertools.chain([name], (f"{name}-{number}" for number in itertools.count(2)))
    return next(folder for each in names if not (folder := book.folder / REPORTS / each).exists())


def _saved_report(
    book: Book,
    where: str | None,
    out: Path | None,
    person: str | None,
    step: Callable[[str], None],
    draw: Callable[[Analysis], Mapping[str, bytes]],
    about: Mapping[str, object],
) -> tuple[Analysis, DrawnReport, int]:
    try:
        if out is None and os.access(book.folder, os.W_OK):  # else the session reports who may not write
            _check_writable(book.folder / REPORTS)
        made = _make_report(book, where, person, step)
        return _stated(book, where, out, person, made, draw(made), about)
    except BookReadOnly as error:
        raise BookReadOnly(f"{error} `labbook report --unsaved --out DIR` needs no right to write.") from error


def _unsaved_report(book: Book, where: str | None, step: Callable[[str], None]) -> Analysis:
    """Make a report that the book does not have."""
    with book.reading() as connection:
        return _not_stored(_made(connection, book.store, book.configuration, where, step))


def _report_as_of(book: Book, where: str | None, as_of: str, step: Callable[[str], None]) -> Analysis:
    """Make the report of a book as it stood at an earlier entry or time."""
    from labbook.book.as_of import book_as_of  # brings readers of files, for which no other report waits

    with book_as_of(book, as_of, step) as past:
        made = _not_stored(_made(past.connection, book.store, past.configuration, where, step))
    return replace(made, results=replace(made.results, as_of=past.called))


def _not_stored(made: Analysis) -> Analysis:
    return replace(made, results=replace(made.results, stored=False))


def _made(
    connection: sa.Connection,
    store: Store,
    configuration: Configuration,
    where: str | None,
    step: Callable[[str], None],
) -> Analysis:
    refuse_empty_selection(connection, where)
    made_at = now_utc().split(".")[0] + "Z"
    return analyse(connection, store, configuration, where=where, made_at=made_at, progress=step)


def _make_report(book: Book, where: str | None, person: str | None, step: Callable[[str], None]) -> Analysis:
    """Make a report of the book as it stands, without a lock: what is stated meanwhile is not in it."""
    for _attempt in range(_ATTEMPTS):
        with book.session(person):
            pass  # takes over what labbook.toml adds before anything is computed
        with book.reading() as connection:
            row = config_in_force(connection)
            if row is not None and row.sha256 == book.configuration.sha256:
                return _made(connection, book.store, book.configuration, where, step)
    raise UsageError("others keep giving commands under another labbook.toml: write the same in each and try again.")


def refuse_store(out: Path) -> None:
    """Raise `UsageError` for a folder among the raw copies or samples of any book, or among what else makes it one."""
    place = out.resolve()
    if (place / CONFIGURATION).exists() or (place.name == REPORTS and (place.parent / CONFIGURATION).exists()):
        raise UsageError(
            f"{str(out)!r} is a folder of the book, where other things lie: give one of the report's own, with --out."
        )
    for folder in (place, *place.parents):
        if folder.name in STORED and (folder.parent / JOURNAL).exists():
            raise UsageError(
                f"{str(out)!r} is in the store of the book's files {folder}, where nothing else belongs: give a folder "
                "outside it, with --out."
            )


def _refuse_replacing(book: Book, out: Path) -> None:
    """Raise `UsageError` for a folder that labbook named for another report; one that a person named is made anew."""
    place = out.resolve()
    is_own = place.parent == book.folder.resolve() / REPORTS and _OWN_NAME.fullmatch(place.name)
    if is_own and (place / NUMBERS).exists():
        raise UsageError(f"{str(out)!r} is the folder of another report: name one of your own, with --out.")


def _check_writable(folder: Path) -> None:
    """Try to write in the folder, or the nearest one above it that is there, before the report is stated."""
    try:
        with tempfile.TemporaryFile(
            dir=next(place for place in (folder, *folder.absolute().parents) if os.path.lexists(place))
        ):
            pass
    except OSError as error:
        raise UsageError(
            f"the report cannot be written to {str(folder)!r} ({error.strerror or error}): give a folder that can be "
            "written, with --out."
        ) from error


def state_report(book: Book, where: str | None, person: str | None, step: Callable[[str], None]) -> Analysis:
    """Make a report of which nothing is drawn: its numbers alone."""
    made = _make_report(book, where, person, step)
    _stated(book, where, None, person, made, {})
    return made


def _stated(
    book: Book,
    where: str | None,
    out: Path | None,
    person: str | None,
    made: Analysis,
    files: Mapping[str, bytes],
    about: Mapping[str, object] = {},
) -> tuple[Analysis, DrawnReport, int]:
    """State that a report was made and put its files in place; returns how many entries came in after those it is of.

    `about` stands in the entry beside what every report has, such as that its page is a lab's own. The files get their
    folder while nobody else can take it: a report is in the journal only when they are there, whole.
    """
    with book.session(person) as session:
        drawn = _drawn(book, made, out, files)
        later = journal.head(session.connection)[0] + len(session.entries) - made.results.entry
        hashes = {name: hashlib.sha256(data).hexdigest() for name, data in drawn.files.items()}
        new = {
            "where": where,
            "made_at": made.results.made_at,
            "numbers": len(made.shown),
            "versions": made.versions,
            "settings": settings_of_numbers(book.configuration),
            "folder": drawn.folder,
            "files": hashes,
            **({"as_of": made.results.entry} if later else {}),
            **about,
        }
        session.state(Statement(Action.REPORT, "report", new_uid(), new=new))
        drawn.put()
        write_whole(numbers_path(book.store.root, hashes[NUMBERS]), drawn.files[NUMBERS])
    return made, drawn, later
