"""Who may read what labbook makes: files have the rights that the umask leaves, a shared drive those of its group."""

from __future__ import annotations

import contextlib
import os
import shutil
import struct
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook
from tests.ingest.bad_input import LOG

LAB, BEN = 64_999, 64_998
"""A group and a user of it that no system has."""


@contextlib.contextmanager
def umask(mask: int) -> Iterator[None]:
    before = os.umask(mask)
    try:
        yield
    finally:
        os.umask(before)


@pytest.mark.parametrize("mask", [0o077, 0o027, 0o022])
def test_files_have_the_rights_that_the_umask_leaves(fresh: SmallBook, tmp_path: Path, mask: int) -> None:
    with umask(mask):
        at = tmp_path / "made"
        good(labbook("init", at, "--as", "Ada Nwosu", at=tmp_path))
        good(labbook("ingest", fresh.log("r001"), at=at))
        good(labbook("rebuild", at=at))
        good(labbook("backup", tmp_path / "backup", at=at))
        good(labbook("restore", tmp_path / "backup", tmp_path / "again", at=tmp_path))
    wanted = ~mask & 0o777
    for folder in (at, tmp_path / "backup", tmp_path / "again"):
        for path in (folder, *folder.rglob("*")):
            mode = path.stat().st_mode & 0o777
            assert mode & ~wanted == 0, path
            assert mode & 0o444 == wanted & 0o444, path


def acl(path: Path, group: int) -> None:
    """Do what `setfacl -m d:g:GROUP:rwX` does: what is made in the folder can be written by the group."""
    anyone, rwx, rx = 0xFFFFFFFF, 7, 5
    entries = [(1, rwx, anyone), (4, rwx, anyone), (8, rwx, group), (16, rwx, anyone), (32, rx, anyone)]
    value = struct.pack("<I", 2) + b"".join(struct.pack("<HHI", *entry) for entry in entries)
    try:
        os.setxattr(path, "system.posix_acl_default", value)
    except (AttributeError, OSError) as error:
        pytest.skip(f"no access control lists here: {error}")


@pytest.fixture
def drive() -> Iterator[Path]:
    """A folder as docs/shared-book.md sets it up."""
    if os.geteuid() != 0:
        pytest.skip("only root can be two users")
    above = Path(tempfile.mkdtemp(prefix="labbook-drive-", dir="/tmp"))
    try:
        above.chmod(0o755)
        shared = above / "lab"
        shared.mkdir()
        os.chown(shared, -1, LAB)
        shared.chmod(0o2770)
        acl(shared, LAB)
        yield shared
    finally:
        shutil.rmtree(above)


def as_ben(*words: str | Path, at: Path) -> int:
    """Give a command as another user of the group, in a process of his own."""
    child = os.fork()
    if child == 0:
        try:
            os.environ["LABBOOK_CACHE"] = str(at / "cache")
            os.setgroups([])
            os.setgid(LAB)
            os.setuid(BEN)
            answer = labbook(*words, at=at)
            print(answer)
            os._exit(answer.code)
        finally:
            os._exit(99)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def test_two_users_write_to_a_shared_book_at_umask_022(drive: Path, tmp_path: Path, postgres_url: str) -> None:
    for name, data in (("a.csv", LOG), ("b.csv", LOG + b"# again\n")):
        (drive.parent / name).write_bytes(data)
    with umask(0o022):
        words = ("init", "mybook", "--as", "Ada Nwosu", "--database", postgres_url, "--store", drive / "mybook-store")
        good(labbook(*words, at=tmp_path))
        good(labbook("ingest", drive.parent / "a.csv", at=tmp_path / "mybook"))
        good(labbook("db", "check", at=tmp_path / "mybook"))
        bens = drive.parent / "ben"
        bens.mkdir()
        shutil.copyfile(tmp_path / "mybook" / "labbook.toml", bens / "labbook.toml")
        for path in (bens, bens / "labbook.toml"):
            os.chown(path, BEN, LAB)
        assert as_ben("ingest", drive.parent / "b.csv", at=bens) == 0
        good(labbook("files", "withdraw", "b.csv", "--why", "the same log", at=tmp_path / "mybook"))
        assert as_ben("db", "check", at=bens) == 0
    assert good(labbook("db", "check", "--deep", at=tmp_path / "mybook")).out
