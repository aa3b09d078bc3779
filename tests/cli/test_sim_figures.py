"""`labbook sim figures`: files and claims of the thesis's ch. 3."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from tests.cli.shell import good, labbook, refused

WANTED = ("3.2", "3.4")


def only(*numbers: str) -> list[str]:
    return [word for number in numbers for word in ("--only", number)]


def test_what_is_asked_for_is_written(tmp_path: Path) -> None:
    found = good(labbook("sim", "figures", "--out", "paper", *only(*WANTED), "--json", at=tmp_path)).json
    assert [item["number"] for item in found["figures"]] == list(WANTED)
    for item in found["figures"]:
        with Image.open(tmp_path / item["file"]) as picture:
            assert picture.format == "PNG"
            assert picture.width == 2160  # 7.2 inches
    written = {str(path.relative_to(tmp_path)) for path in (tmp_path / "paper").iterdir()}
    assert written == {*(item["file"] for item in found["figures"]), found["captions"], *found["tables"]}
    captions = (tmp_path / found["captions"]).read_text(encoding="utf-8")
    assert captions.count("## Figure 3.") == 2
    assert all(Path(item["file"]).name in captions for item in found["figures"])
    assert all(not set(WANTED).isdisjoint(claim["figures"]) for claim in found["claims"])
    assert found["agreeing"] == sum(claim["agrees"] for claim in found["claims"])
    table = (tmp_path / "paper" / "claims.csv").read_text(encoding="utf-8").splitlines()
    assert len(table) == 1 + len(found["claims"])


@pytest.mark.soak
def test_a_form_for_a_paper_and_the_same_bytes_twice(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        good(labbook("sim", "figures", "--out", folder, "--format", "pdf", *only("3.2"), at=tmp_path))
    (one,), (two,) = (list((tmp_path / folder).glob("*.pdf")) for folder in ("one", "two"))
    assert one.read_bytes().startswith(b"%PDF")
    assert one.read_bytes() == two.read_bytes()
    assert not (tmp_path / "one" / "claims.csv").exists()  # no claim is about the ground's functions alone


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--only", "3.7"], "'3.7' is no figure of ch. 3 that a simulation makes: give one of 3.2, 3.4"),
        (["--format", "jpg"], "'jpg' is not a known format"),
    ],
)
def test_what_is_not_there_is_refused(words: list[str], said: str, tmp_path: Path) -> None:
    refused(labbook("sim", "figures", *words, at=tmp_path), 2, said)
    assert list(tmp_path.iterdir()) == []
