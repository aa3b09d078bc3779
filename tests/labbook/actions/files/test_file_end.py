"""Whether the last bytes of a file show its end: of an archive for certain, of text that it is not there."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labbook.actions.files.watching import End, end_of


def archive(members: dict[str, bytes], comment: bytes = b"") -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as writer:
        for name, content in members.items():
            writer.writestr(name, content)
        writer.comment = comment
    return made.getvalue()


INNER = archive({"a.csv": b"t,h\n1,2\n"})
ARCHIVES = [INNER, archive({"inner.zip": INNER, "b.csv": b"x" * 3000})]


@pytest.mark.parametrize("whole", ARCHIVES)
def test_an_archive_ends_where_its_last_record_says_and_nowhere_before(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "logs.zip"
    path.write_bytes(whole)
    assert end_of(path) is End.THERE
    for length in range(4, len(whole)):
        path.write_bytes(whole[:length])
        assert end_of(path) is End.MISSING
        path.write_bytes(whole[:length] + bytes(len(whole) - length))  # its space was allocated beforehand
        assert end_of(path) is (End.THERE if whole[length:].strip(b"\0") == b"" else End.MISSING)


def test_of_an_archive_with_a_remark_the_end_is_not_certain(tmp_path: Path) -> None:
    path = tmp_path / "logs.zip"
    path.write_bytes(archive({"a": b"1"}, b"with a remark"))
    assert end_of(path) is End.UNKNOWN


@given(st.lists(st.text("0123456789.,t", max_size=20), min_size=1, max_size=50))
@pytest.mark.parametrize("page", ["utf-8", "utf-16"])
def test_text_lacks_its_end_where_its_last_line_has_none(
    tmp_path_factory: pytest.TempPathFactory, page: str, lines: list[str]
) -> None:
    path = tmp_path_factory.mktemp("text") / "log.csv"
    for end in ("\n", "\r\n"):
        path.write_bytes((end.join(lines) + end).encode(page))
        assert end_of(path) is End.UNKNOWN
        path.write_bytes((end.join(lines) + end + "1.5").encode(page))
        assert end_of(path) is End.MISSING


def test_of_other_bytes_nothing_is_known(tmp_path: Path) -> None:
    path = tmp_path / "record.bsf"
    for content in (b"", bytes(range(32)) * 100):
        path.write_bytes(content)
        assert end_of(path) is End.UNKNOWN
