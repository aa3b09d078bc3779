"""`labbook watch`: take in what instruments write into folders, as soon as it is complete."""

import contextlib
import signal
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Callable

    from labbook.actions.files.watching import Happening

from data_schema.errors import UsageError
from data_schema.vocabulary import IngestStatus
from labbook.cli.common import AsOption, BookOption
from labbook.cli.declaring import Declared
from labbook.cli.web import page_beside
from labbook.terminal import Shown, asking, listed, say, tell_now


def watch(
    folders: Annotated[list[Path], typer.Argument(metavar="FOLDER...", help="Folders that instruments write to.")],
    once: Annotated[bool, typer.Option("--once", help="Take in what is there, and end.")] = False,
    still: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="How long a file is unchanged that is complete; 0.15 if not given."),
    ] = None,
    page: Annotated[bool, typer.Option("--page", help="Open what comes in as a page; at a terminal it is.")] = False,
    no_page: Annotated[bool, typer.Option("--no-page", help="The terminal alone.")] = False,
    *,
    declared: Declared,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Watch folders: ingest each file once it is complete, and say how its run does. Ctrl-C ends it.

    What was there before is taken in first, unless the book has it. A file that was taken in half-written is withdrawn
    for the whole one. A file that is refused is tried again when it changes, and when labbook.toml does. Hidden files
    and those called .part, .tmp, .crdownload or ~ are left out.
    With --json one JSON document a line is printed as things happen.

    Example: labbook watch /media/stick/logs; labbook watch logs charger --once
    """
    from ingest.formats.registry import plugins
    from labbook.actions.files.ingesting import IngestRequest
    from labbook.actions.files.watching import STILL_S
    from labbook.actions.files.watching import watch as watch_folders
    from labbook.book.write_session import new_uid
    from labbook.cli.file_options import declared_options

    if still is not None and not 0.0 < still <= _MOST_STILL_S:
        raise UsageError(f"--still {still:g} is no time to wait: give seconds above 0, at most {_MOST_STILL_S:g}.")
    if page and no_page:
        raise UsageError("--page and --no-page contradict each other: give one of them, or neither.")
    for fault in plugins().faults:
        say(fault, err=True)
    request = IngestRequest(options=declared_options(declared), person=person, batch=new_uid())
    sum_up = _Sum()
    with contextlib.ExitStack() as beside:
        if page or not (no_page or once or not asking() or find_spec("uvicorn") is None):
            url = beside.enter_context(page_beside(book, person))
            tell_now({"event": "page", "url": url}, [url])
        stop = beside.enter_context(_until_ctrl_c())
        happenings = watch_folders(book, folders, request, stop, still_s=STILL_S if still is None else still, once=once)
        with contextlib.closing(happenings):
            for happened in happenings:
                sum_up.add(happened)
                if not tell_now(*_told(happened)):
                    break
    counts, replaced = sum_up.counts, sum_up.replaced
    done = {"imported": sum_up.imported, "replaced": replaced, **counts, "left": list(sum_up.left)}
    in_place = f" ({replaced} of them in place of what was their beginning)" if replaced else ""
    line = f"{sum_up.imported} imported{in_place}, {counts['known']} there already, {counts['refused']} refused."
    failed = once and bool(counts["refused"] or counts["trouble"])
    return Shown({"event": "ended", **done}, [line], 2 if failed else 0, one_line=True)


_MOST_STILL_S = 600.0


@dataclass
class _Sum:
    """What happened in all: how many files were imported, and what became last of each one."""

    imported: int = 0
    replaced: int = 0
    became: dict[str, str] = field(default_factory=dict)
    left: tuple[str, ...] = ()

    def add(self, happened: "Happening") -> None:
        """Count what happened."""
        from labbook.actions.files.watching import Arrived, Known, Left, Trouble

        match happened:
            case Arrived(outcome):
                self.imported += outcome.status is IngestStatus.IMPORTED
                self.replaced += len(outcome.replaced)
                others = {IngestStatus.DUPLICATE: "known", IngestStatus.REFUSED: "refused"}
                self.became[outcome.name] = others.get(outcome.status, "")
            case Known(files):
                self.became |= dict.fromkeys(files, "known")
            case Trouble(about, message):
                self.became[about] = "trouble" if message else ""
            case Left(files):
                self.left = files

    @property
    def counts(self) -> dict[str, int]:
        """How many files there were of each fate but imported."""
        return {fate: [*self.became.values()].count(fate) for fate in ("known", "refused", "trouble")}


@contextlib.contextmanager
def _until_ctrl_c() -> "Iterator[Callable[[], bool]]":
    """Let Ctrl-C end what goes on after the file in hand, a second one at once; yields what tells if it was pressed."""
    pressed: list[bool] = []
    before = signal.getsignal(signal.SIGINT)

    def on_interrupt(number: int, frame: FrameType | None) -> None:
        if pressed and callable(before):
            before(number, frame)
        pressed.append(True)

    if callable(before):  # else it is to be ignored, as under nohup
        signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)


def _told(happened: "Happening") -> tuple[dict[str, Any], list[str]]:
    """Return what happened for programs, and for people: what became of a file, and below it how its runs do."""
    from labbook.actions.files.rereading import OUTDATED
    from labbook.actions.files.watching import Arrived, Known, Left, Trouble, Watching
    from labbook.cli.ingest_lines import Taken, file_line, outcome_lines, taken_json

    match happened:
        case Watching(folders):
            lines = [f"watching {listed([*map(str, folders)])}; Ctrl-C ends it."]
            return {"event": "watching", "folders": folders}, lines
        case Arrived(outcome, rig, missing):
            lines = [file_line(outcome)]
            if outcome.first is None:
                of_runs = [f"  {'LOOK' if line.concern else 'ok  '}  {line.text}" for line in rig]
                lines = [*outcome_lines(outcome, missing, remarks=False), *of_runs, ""]
            return {"event": "file", **taken_json(Taken(outcome, rig, missing)), "runs_now": rig}, lines
        case Known(files, outdated):
            more = f" Of {outdated}: {OUTDATED}" if outdated else ""
            lines = [f"{len(files)} files are in the book already: {listed(files, 4)}.{more}"]
            return {"event": "known", "files": files, "outdated": outdated}, lines
        case Trouble(about, message):
            event = "trouble" if message else "over"
            return {"event": event, "about": about, "said": message}, [f"{about}: {message or 'that is over.'}"]
        case Left(files):
            lines = [f"not taken in, for they are empty or were still being written: {listed(files)}."]
            return {"event": "left", "files": files}, lines
