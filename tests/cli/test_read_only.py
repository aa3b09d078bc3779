"""On a disk that may only be read, what is refused is called by the name that was asked for, not by that of a part."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.cli.shell import LABBOOK, environment
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

READ_ONLY = 'mount --bind "$0" "$0" && mount -o remount,ro,bind "$0" && exec "$@"'
"""A shell's script that makes a folder read-only, also for root, for one command alone."""


def within(folder: Path, command: Sequence[str | Path]) -> subprocess.CompletedProcess[str]:
    """Run a command for which `folder` is on a disk that may only be read."""
    own = ["unshare", "--mount"] if os.geteuid() == 0 else ["unshare", "--map-root-user", "--mount"]
    words = [*own, "sh", "-c", READ_ONLY, folder, *command]
    return subprocess.run(words, cwd=folder.parent, env=environment(), capture_output=True, text=True, check=False)


@pytest.fixture
def locked(tmp_path: Path) -> Path:
    """A folder that can be made read-only; the test is skipped where the system does not let us."""
    folder = tmp_path / "locked"
    folder.mkdir()
    try:
        made = within(folder, ["true"])
    except FileNotFoundError:
        pytest.skip("there is no unshare")
    if made.returncode != 0:
        pytest.skip(f"no mounts of our own: {made.stderr}")
    return folder


def test_a_file_of_labbook_is_named_by_its_own_name(locked: Path, fresh: SmallBook) -> None:
    """It was "Read-only file system .../.g.toml.part"."""
    writes = (
        "from data_schema.disk import write_whole; from pathlib import Path; write_whole(Path('locked/g.toml'), b'')"
    )
    for command, name in (
        ((sys.executable, "-c", writes), "locked/g.toml'"),
        ((LABBOOK, "init", locked, "--as", "Ada Nwosu"), "labbook.toml:"),
        ((LABBOOK, "plan", "--seed", "3", "--out", locked / "plan.csv", "--book", fresh.folder), "plan.csv cannot"),
    ):
        told = within(locked, command)
        assert told.returncode != 0
        assert "Read-only file system" in told.stderr
        assert name in says(told.stderr.splitlines()[-1], "Read-only file system")
        assert "/." not in told.stderr.splitlines()[-1]
    assert not list(locked.iterdir())
