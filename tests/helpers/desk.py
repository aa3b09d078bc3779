"""A person at an open book, who hands in files, says what they are, and looks at what counts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from data_schema.queries.charges import charges_by_run
from data_schema.queries.files import inbox
from labbook.actions.files.ingesting import FileOutcome, IngestRequest, ingest_file
from labbook.actions.files.rereading import RereadRequest
from labbook.actions.files.stored_files import reread_named, restore, withdraw
from labbook.actions.runs.correcting import correct, state_charge
from labbook.book.naming import run_named
from labbook.book.opening import Book
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.statements import state
from tests.helpers.upkeep import rebuilt_alike

T = TypeVar("T")
Options = Mapping[str, Any]


def of_column(name: str, unit: str = "mAh") -> Options:
    """Declare in which column the charges are."""
    return {"columns": {name: {"channel": "charge", "unit": unit}}}


@dataclass(frozen=True, slots=True)
class Desk:
    """The book, and the folder in which the files lie."""

    small: SmallBook
    book: Book
    folder: Path

    def take(
        self, name: str, data: str | bytes, options: Options | None = None, run: str | None = None, **more: Any
    ) -> FileOutcome:
        """Ingest a file that is written for it."""
        path = self.folder / name
        path.write_bytes(data.encode() if isinstance(data, str) else data)
        return ingest_file(self.book, path, IngestRequest(run, options, person=ADA, **more))

    def read_again(self, name: str, options: Options) -> None:
        assert not reread_named(self.book, name, RereadRequest(options, ADA, "otherwise")).read.refused

    def say(self, action: Callable[..., T], *given: object, **named: Any) -> T:
        return state(self.book, action, *given, **named)

    def use(self, *steps: str) -> None:
        """Withdraw (`-NAME`) and restore (`+NAME`) files in this order."""
        for step in steps:
            self.say(withdraw if step.startswith("-") else restore, step[1:], "a draft")

    def type_in(self, run: str, mah: float, **named: Any) -> None:
        self.say(state_charge, run, mah, None, None, **named)

    def correct_charge(self, run: str, said: str) -> None:
        self.say(correct, f"charge:{self.uid_of(run)}", [said], "misread")

    def charges(self) -> dict[str, list[float]]:
        """What was put back after each of four runs."""
        with self.book.reading() as connection:
            by_uid = charges_by_run(connection)
            runs = {name: run_named(connection, name).uid for name in ("r001", "r002", "r003", "r004")}
        return {name: [charge.charge_mah for charge in by_uid.get(uid, [])] for name, uid in runs.items()}

    def uid_of(self, run: str) -> str:
        with self.book.reading() as connection:
            return charges_by_run(connection)[run_named(connection, run).uid][0].uid

    def inbox(self) -> list[str]:
        """Files and rows whose run is unknown."""
        with self.book.reading() as connection:
            return [item.name for item in inbox(connection)]


@contextmanager
def desk_at(folder: Path, **how: Any) -> Iterator[Desk]:
    """Open a book with runs; at the end a rebuild has to make the same rows."""
    small = small_book(folder, ingested=False, **how)
    with small.open() as book:
        yield Desk(small, book, folder)
    rebuilt_alike(small)
