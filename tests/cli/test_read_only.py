"""On a disk that may only be read, what is refused is called by the name that was asked for, not by that of a part."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.cli.shell import LABBOOK, environment
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

READ_ONLY = 'mount --bind "$0" "$0" && mount -o remount,ro,bind "$0" && exec "$@"'
"""A shell's script that makes a folder read-only, also for root, for one command alone."""


def within(folder: Path, *command: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a command for which `folder` is on a disk that may only be read."""
    own = ["unshare", "--mount"] if os.geteuid() == 0 else ["unshare", "--map-root-user", "--mount"]
    words = [*own, "sh", "-c", READ_ONLY, folder, *command]
    return subprocess.run(words, cwd=folder.parent, env=environment(), capture_output=True, text=True, check=False)


def test_a_file_of_labbook_is_named_by_its_own_name(tmp_path: Path, fresh: SmallBook) -> None:
    """It was "Read-only file system .../.g.toml.part"."""
    folder = tmp_path / "locked"
    folder.mkdir()
    if shutil.which("unshare") is None or within(folder, "true").returncode != 0:
        pytest.skip("no mounts of our own can be made here")
    plan = ("plan", "--seed", "3", "--out", folder / "plan.csv", "--book", fresh.folder)
    for words, name in ((("init", folder, "--as", "Ada Nwosu"), "labbook.toml:"), (plan, "plan.csv cannot")):
        told = within(folder, LABBOOK, *words)
        assert told.returncode != 0
        assert "/." not in says(told.stderr.splitlines()[-1], "Read-only file system", name)
    assert not list(folder.iterdir())
