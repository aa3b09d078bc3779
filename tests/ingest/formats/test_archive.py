"""Archives: their members are read as files; what is unsafe, damaged, nested or too large is refused in a sentence."""

from __future__ import annotations

import gzip
import io
import stat
import time
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations, Limits, ReadFile
from ingest.read import read_file
from ingest.spool import map_and_hash
from tests.helpers.wording import says
from tests.ingest.reading import finding, rules
from tests.ingest.synthetic import SHEET, robot_log

LOG = robot_log(100)
OTHER = robot_log(100, seed=2)


def zipped(members: dict[str, bytes], link: str = "") -> bytes:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            member = zipfile.ZipInfo(name)
            member.compress_type = zipfile.ZIP_DEFLATED
            if name == link:
                member.external_attr = (stat.S_IFLNK | 0o777) << 16
            archive.writestr(member, content)
    return target.getvalue()


def read(data: bytes, **limits: int) -> ReadFile:
    return read_file(data, Declarations(limits=Limits(**limits)))


def same(one: ReadFile, other: ReadFile) -> bool:
    return all(
        np.array_equal(a.values, b.values) and (a.name, a.unit) == (b.name, b.unit)
        for part, again in zip(one.parts, other.parts, strict=True)
        for a, b in zip(part.channels, again.channels, strict=True)
    )


def test_a_packed_log_is_the_log() -> None:
    plain, packed = read(LOG), read(gzip.compress(LOG))
    assert not packed.refused
    assert same(plain, packed)
    assert [part.part for part in packed.parts] == [part.part for part in plain.parts]
    assert (packed.rows_read, packed.role) == (plain.rows_read, plain.role)


def test_a_packed_log_reads_twice_from_a_mapped_file(tmp_path: Path) -> None:
    mapped_log, _ = map_and_hash(b"", io.BytesIO(gzip.compress(LOG)), tmp_path)
    for result in (read(mapped_log), read(mapped_log)):
        assert not result.refused
        assert same(read(LOG), result)


def test_parts_of_a_zip_are_named_after_their_members() -> None:
    result = read(
        zipped({"day/run 1.csv": LOG, "__MACOSX/._run 1.csv": b"x", "day/run 2.csv": OTHER, "b/run 2.txt": LOG})
    )
    assert not result.refused
    assert [part.part for part in result.parts] == ["run_1", "run_2", "run_2_2"]
    assert (result.rows_read, result.role) == (300, "log")
    assert same(read(OTHER), ReadFile(result.parts[1:2], format="", reader_version=0, findings=()))


def test_charges_of_several_sheets_are_numbered_through() -> None:
    result = read(zipped({"a.csv": SHEET.encode(), "b.csv": SHEET.replace("r00", "r10").encode()}))
    assert [charge.row_number for charge in result.charges] == [1, 2, 3, 4, 5, 6]


def test_a_declared_column_needs_to_stand_in_one_member() -> None:
    other = LOG.replace(b"k_gain", b"gain_k")
    declared = Declarations(columns={"gain_k": ColumnDeclaration("k_gain")})
    result = read_file(zipped({"a.csv": LOG, "b.csv": other}), declared)
    assert not result.refused
    assert "declared_column_absent" not in rules(result)


BOMB = gzip.compress(bytes(8 << 20))


@pytest.mark.parametrize(
    ("data", "rule", "said"),
    [
        (zipped({"a.csv": LOG, "sheet.csv": SHEET.encode()}), "members_differ", "unpack"),
        (zipped({"a.csv": LOG, "picture.png": b"\x89PNG" + bytes(90)}), "member_unknown", "unpack"),
        (zipped({"../a.csv": LOG}), "archive_refused", "'../a.csv'"),
        (zipped({"/etc/a.csv": LOG}), "archive_refused", "'/etc/a.csv'"),
        (zipped({"C:\\a.csv": LOG}), "archive_refused", "leads out"),
        (zipped({"a.csv": b"/etc/passwd"}, link="a.csv"), "archive_refused", "link"),
        (zipped({}), "archive_refused", "no file"),
        (zipped({"a.csv": LOG})[:-30], "archive_refused", "damaged"),
        (BOMB, "archive_refused", "largest_expansion"),
        (zipped({"a.csv": bytes(8 << 20)}), "archive_refused", "largest_expansion"),
        (gzip.compress(LOG)[:-9], "archive_refused", "middle"),
        (gzip.compress(LOG) + b"trailing", "archive_refused", "damaged"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_refused_and_why(data: bytes, rule: str, said: str) -> None:
    result = read(data)
    assert result.refused
    assert not any(part for part in result.parts if rule == "archive_refused")
    says(finding(result, rule).message, said)


@pytest.mark.parametrize("name", ["a.csv", "xl/workbook.xml"])
def test_a_directory_that_lies_about_a_size_is_refused_before_it_fills_the_memory(name: str) -> None:
    n_bytes = 64 << 20
    data = zipped({name: bytes(n_bytes)})
    lying = data.replace(n_bytes.to_bytes(4, "little"), (1000).to_bytes(4, "little"))
    assert lying != data
    tracemalloc.start()
    assert read(lying).refused
    _now, most_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most_bytes < 8 << 20


def test_a_member_that_goes_on_behind_its_stated_size_is_refused_and_not_read_in_part() -> None:
    data, part = zipped({"a.csv": LOG}), LOG[: LOG.rindex(b"\n", 0, 2000) + 1]
    for said, lie in ((len(LOG), len(part)), (zlib.crc32(LOG), zlib.crc32(part))):
        data = data.replace(said.to_bytes(4, "little"), lie.to_bytes(4, "little"))
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.read("a.csv") == part
    assert rules(read(data)) >= {"archive_refused"}
    assert read(zipped({"a.csv": part})).parts


def test_archives_in_each_other_expand_together_within_the_bound() -> None:
    one = gzip.compress(8 * b"".join(b"%d,%d\n" % (place, place * place % 997) for place in range(1000)))
    packed = zipped({f"{number}.csv.gz": 50 * one for number in range(20)})
    inside, text = 20 * 50 * len(one), 20 * 50 * len(gzip.decompress(one))
    assert inside < 200 * len(packed) < text < 200 * inside
    result = read(packed)
    assert result.refused
    says(result.findings[0].message, "largest_expansion")


def test_a_hundred_thousand_members_one_after_another_are_read_in_linear_time() -> None:
    began_s = time.process_time()
    assert same(read(LOG), read(gzip.compress(b"") * 100_000 + gzip.compress(LOG)))
    assert read(gzip.compress(gzip.compress(b"") * 40_000)).refused
    assert time.process_time() - began_s < 20  # 140 s where what follows a member is copied for each


@pytest.mark.parametrize("every", [8, pytest.param(1, marks=pytest.mark.soak)])
def test_no_damaged_directory_leaves_a_member_out(every: int) -> None:
    """A longer extra field of one entry swallows the next, and zipfile says nothing."""
    data = zipped({"a.csv": LOG, "b.csv": OTHER})
    plain = read(data)
    for place in range(data.index(b"PK\1\2"), len(data)):
        for bit in range(place % every, 8, every):
            mutant = bytearray(data)
            mutant[place] ^= 1 << bit
            result = read(bytes(mutant))
            assert result.refused or same(plain, result)


@pytest.mark.parametrize("packing", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_text_in_an_archive_has_the_page_that_it_has_outside(packing: int) -> None:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", packing) as archive:
        archive.writestr("run.csv", LOG)
    for data in (target.getvalue(), gzip.compress(LOG, 0)):
        result = read(data)
        assert result.explanation.encoding == "utf-8"
        assert "encoding_declared" not in rules(result)
    paged = read(gzip.compress(LOG.replace(b"height", b"h\xf6he"), 0))
    assert paged.explanation.encoding == "cp1252"


def test_a_run_named_above_the_table_counts_in_an_archive_of_one_file() -> None:
    log, other = (b"# run " + name + b"\n" + robot_log(9) for name in (b"r012", b"r013"))
    assert [read(data).named_runs for data in (log, gzip.compress(log), zipped({"log.csv": log}))] == [("r012",)] * 3
    assert read(zipped({"log.csv": log, "other.csv": other})).named_runs == ()
