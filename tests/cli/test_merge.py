"""`labbook merge` as a person gives it: a dry run, the merge, again, and two verdicts that contradict each other."""

from __future__ import annotations

import shutil
from pathlib import Path

from tests.cli.shell import contents, good, labbook, unchanged
from tests.helpers.books import SmallBook
from tests.helpers.wording import says


def test_a_laptop_s_book_comes_home(stated: SmallBook, tmp_path: Path) -> None:
    home, laptop = stated.folder, tmp_path / "laptop"
    shutil.copytree(home, laptop)
    good(labbook("ingest", stated.log("r001"), stated.log("r002"), at=laptop))
    good(labbook("note", "r009", "mud on the foot", at=laptop))
    good(labbook("note", "r001", "at the lab", at=home))
    with unchanged(home):
        shown = good(labbook("merge", laptop, "--dry-run", "--json", at=home)).json
    assert (shown["entries"], shown["raw_copies"]) == ({"file": 2, "note": 1}, 2)

    says(good(labbook("merge", laptop, at=home)).out, "file", "2", "1")
    good(labbook("files", "show", "r002.csv", at=home))
    says(good(labbook("show", "r009", at=home)).out, "on the foot")
    good(labbook("db", "check", "--deep", at=home))
    with unchanged(home):
        assert "nothing to add" in good(labbook("merge", laptop, at=home)).out

    good(labbook("jumps", "reject", "r001", "1", "--reason", "misfire", at=home))
    good(labbook("jumps", "accept", "r001", "1", "--reason", "looks_right", at=laptop))
    good(labbook("jumps", "reject", "r002", "1", "--reason", "misfire", at=laptop))
    before = contents(home)
    for options, code in ((["--dry-run"], 1), ([], 2)):
        against = labbook("merge", laptop, *options, at=home)
        assert against.code == code
        says(against.out + against.err, "jump of run", "r001")
        assert contents(home) == before
