"""`labbook merge` as a person gives it: a dry run, the merge, again, and two verdicts that contradict each other."""

from __future__ import annotations

import shutil
from pathlib import Path

from tests.cli.shell import contents, labbook
from tests.helpers.books import ADA, SmallBook
from tests.helpers.wording import says

SPEAKER = ("--as", ADA)


def test_a_laptop_s_book_comes_home(stated: SmallBook, tmp_path: Path) -> None:
    laptop = tmp_path / "laptop"
    shutil.copytree(stated.folder, laptop)
    assert labbook("ingest", stated.log("r001"), stated.log("r002"), *SPEAKER, at=laptop).code == 0
    assert labbook("note", "r009", "mud on the foot", *SPEAKER, at=laptop).code == 0
    assert labbook("note", "r001", "at the lab", *SPEAKER, at=stated.folder).code == 0
    before = contents(stated.folder)

    shown = labbook("merge", laptop, "--dry-run", "--json", *SPEAKER, at=stated.folder)
    assert (shown.code, shown.json["entries"], shown.json["raw_copies"]) == (0, {"file": 2, "note": 1}, 2)
    assert contents(stated.folder) == before

    done = labbook("merge", laptop, *SPEAKER, at=stated.folder)
    assert (done.code, done.err) == (0, "")
    says(done.out, "file", "2", "1")
    assert labbook("files", "show", "r002.csv", at=stated.folder).code == 0
    says(labbook("show", "r009", at=stated.folder).out, "on the foot")
    assert labbook("db", "check", "--deep", at=stated.folder).code == 0

    after = contents(stated.folder)
    again = labbook("merge", laptop, *SPEAKER, at=stated.folder)
    assert (again.code, contents(stated.folder)) == (0, after)
    assert "nothing to add" in again.out

    assert labbook("jumps", "reject", "r001", "1", "--reason", "misfire", *SPEAKER, at=stated.folder).code == 0
    assert labbook("jumps", "accept", "r001", "1", "--reason", "looks_right", *SPEAKER, at=laptop).code == 0
    assert labbook("jumps", "reject", "r002", "1", "--reason", "misfire", *SPEAKER, at=laptop).code == 0
    after = contents(stated.folder)
    for options, code in ((["--dry-run"], 1), ([], 2)):
        against = labbook("merge", laptop, *options, *SPEAKER, at=stated.folder)
        assert against.code == code
        says(against.out + against.err, "jump of run", "r001")
        assert contents(stated.folder) == after
