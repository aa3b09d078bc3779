"""The power goes at any moment: nothing that was said is lost, nothing is broken, and the command can be given again.

Each command is recorded once, with all that it, SQLite and pyarrow do to the disk. What a power cut may leave after
each of its steps is laid into a folder of its own, checked, and the command repeated there.
"""

from __future__ import annotations

import copy
import hashlib
import shutil
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from data_schema.journal import Entry
from labbook.book.opening import opened
from tests.helpers import power
from tests.helpers.books import small_book
from tests.helpers.commands import KILLED, Commands, running_commands
from tests.helpers.figures import Count, record
from tests.helpers.statements import said_alike
from tests.helpers.upkeep import health
from tests.helpers.written_by import BACKUP, CASES, Case, check_backup, kinds_of

pytestmark = pytest.mark.skipif(shutil.which("strace") is None, reason="strace is not installed")

NOT_SYNCED = {
    "nothing of it": power.nothing_unsynced,
    "its names": power.names_only,
    "its bytes": power.bytes_only,
    "all of it": power.everything,
}
"""What the disk has of that which was not synced."""


IN_A_SOAK = {*CASES} - {"ingest", "correct"}
"""Cases tried in a soak alone: in the usual run these commands are killed."""
RECORDINGS = 5
_MISSING = object()


@dataclass(frozen=True, slots=True)
class Trial:
    """A recorded case: the disk before it, what was done to it; in the end, the book's journal and the real disk."""

    case: Case
    folder: Path
    disk: power.Disk
    calls: tuple[power.Call, ...]
    said: tuple[Entry, ...]
    last: power.Left


@dataclass(frozen=True, slots=True)
class Moment:
    """What a power cut left: after how many calls, whether the command had said by then that it was done."""

    after: int
    done: bool
    not_synced: str
    left: power.Left


@pytest.fixture(scope="module")
def recorder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Commands, Path]]:
    """Commands that are recorded, and the file that has all that they did."""
    log = tmp_path_factory.mktemp("strace") / "log"
    with running_commands(power.strace(log)) as running:
        yield running, log


def recorded(case: Case, folder: Path, recorder: tuple[Commands, Path]) -> Trial:
    """Give the case's commands to a new book, and record what becomes of its disk.

    What a command did in the moment in which it was killed may be missing in the record: then it is made again.
    """
    for attempt in range(RECORDINGS):
        trial = _recorded(case, folder / str(attempt), recorder)
        if not case.dies_after or not _differing(_played(trial), trial.last):
            break
    return trial


def _played(trial: Trial) -> power.Left:
    disk = copy.deepcopy(trial.disk)
    for call in trial.calls:
        disk.play(call)
    return disk.left(power.everything)


def _differing(one: power.Left, other: power.Left) -> list[str]:
    return sorted(path for path in {*one, *other} if one.get(path, _MISSING) != other.get(path, _MISSING))


def _recorded(case: Case, folder: Path, recorder: tuple[Commands, Path]) -> Trial:
    commands, log = recorder
    folder.mkdir(parents=True)
    if case.made:
        small_book(folder, ingested=case.ingested)
    for command in case.before:
        code, said = commands.run(*case.words(command, folder))
        assert code == 0, said
    disk = power.Disk(folder)
    already = log.stat().st_size if log.exists() else 0  # it is there from the first command on
    for number, command in enumerate(case.commands, start=1):
        dies_after = case.dies_after if number == 1 else 0
        code, said = commands.run(*case.words(command, folder), die_after_sync=dies_after)
        assert code == (KILLED if dies_after else 0), said
    with log.open() as written:
        written.seek(already)
        calls = tuple(power.calls(written.read()))
    last = power.Disk(folder).left(power.everything)
    with opened(folder / case.book) as book:
        return Trial(case, folder, disk, calls, tuple(said_alike(book)), last)


def moments(trial: Trial, chances: int, most: int | None = None) -> Iterator[Moment]:
    """Give what may be left after each call that changed or synced something; the same is given once.

    With `most`, only as many calls are looked at, among those that a sync follows: then most may be lost.
    """
    ways = {**NOT_SYNCED, **{f"by chance {seed}": power.by_chance(seed) for seed in range(chances)}}
    looked_at = _looked_at(trial, most)
    seen: set[bytes] = set()
    for number, call in enumerate(trial.calls, start=1):
        if not trial.disk.play(call) or number not in looked_at:
            continue
        for way, choose in ways.items():
            left = trial.disk.left(choose)
            name = _digest(left)
            if name not in seen:
                seen.add(name)
                yield Moment(number, False, way, left)
    assert not _differing(trial.disk.left(power.everything), trial.last)  # the model is the real thing
    at_last = {_digest(left): (way, left) for way, left in ((way, trial.disk.left(ways[way])) for way in ways)}
    for way, left in at_last.values():
        yield Moment(len(trial.calls), True, way, left)


def _looked_at(trial: Trial, most: int | None) -> Collection[int]:
    if most is None:
        return range(1, len(trial.calls) + 1)
    disk, last, before_sync = copy.deepcopy(trial.disk), 0, list[int]()
    for number, call in enumerate(trial.calls, start=1):
        if disk.syncs(call):
            before_sync += [last] if last not in (0, *before_sync) else []
        last = number if disk.play(call) and not disk.syncs(call) else last
    return set(before_sync[:: -(-len(before_sync) // most)]) if most else ()


def _digest(left: power.Left) -> bytes:
    digest = hashlib.sha256()
    for place, content in sorted(left.items()):
        digest.update(f"{place} {None if content is None else len(content)}\n".encode() + (content or b""))
    return digest.digest()


def check(trial: Trial, moment: Moment, folder: Path, commands: Commands) -> None:
    """Look at what is left, give the last command again, and look once more."""
    power.lay(moment.left, folder)
    case, book = trial.case, folder / trial.case.book
    journal = [entry.hash for entry in trial.said]
    if case.made or moment.done:
        assert health(book).problems == ()
        with opened(book) as standing:
            in_file = [entry.hash for entry in standing.mirror.entries()]
            assert in_file == journal[: len(in_file)]
            assert len(in_file) == len(journal) or not moment.done
    if moment.done:
        pages = {path.relative_to(trial.folder): path.read_bytes() for path in trial.folder.glob("book/reports/**/*.*")}
        assert {path: (folder / path).read_bytes() for path in pages} == pages
    backed_up = moment.done and case.commands[-1] == BACKUP
    check_backup(folder / f"{trial.case.book} on a stick", journal if backed_up else None)
    code, said = commands.run(*case.words(case.commands[-1], folder))
    assert code == 0 or (case.once and code == 2 and len(in_file) == len(journal)), said
    for one in (book, folder / f"{case.book} again"):
        assert not one.exists() or health(one).problems == ()
    with opened(book) as standing:
        after = said_alike(standing)
    if case.made or moment.done:
        assert [entry.hash for entry in after[: len(in_file)]] == in_file
    assert kinds_of(after) == kinds_of(trial.said)


def losses(trial: Trial, at: Iterator[Moment], folder: Path, commands: Commands) -> tuple[int, list[str]]:
    """Check moments; returns how many there were, and what was lost or broken."""
    count, lost = 0, []
    place = trial.folder if trial.case.in_place else folder / "left"
    for moment in at:
        count += 1
        shutil.rmtree(place, ignore_errors=True)
        try:
            check(trial, moment, place, commands)
        except AssertionError as error:
            lost.append(f"after call {moment.after} with {moment.not_synced} that was not synced: {error}")
    return count, lost


@pytest.mark.parametrize("name", [name for name in CASES if name not in IN_A_SOAK])
def test_nothing_that_was_said_is_lost_when_the_power_goes(
    name: str, tmp_path: Path, recorder: tuple[Commands, Path], commands: Commands
) -> None:
    trial = recorded(CASES[name], tmp_path / "trial", recorder)
    count, lost = losses(trial, moments(trial, 0, 1), tmp_path, commands)
    assert count
    assert not lost, "\n".join(lost)


@pytest.mark.soak
@pytest.mark.parametrize("name", CASES)
def test_nothing_is_lost_at_any_moment_of_any_command(
    name: str, tmp_path: Path, recorder: tuple[Commands, Path], commands: Commands
) -> None:
    trial = recorded(CASES[name], tmp_path / "trial", recorder)
    at = moments(trial, trial.case.chances, 30 if trial.case.slow else None)
    count, lost = losses(trial, at, tmp_path, commands)
    record(Count(name, "power cut", "SQLite", tried=count, cut_off=count, lost=len(lost)))
    assert not lost, "\n".join(lost)
