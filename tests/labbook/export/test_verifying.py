"""A capsule that was altered, by accident or on purpose, is named or refused, and a hostile one does no harm."""

from __future__ import annotations

import hashlib
import json
import random
import stat
import struct
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest

from data_schema.errors import InputRefused, LabbookError, UsageError
from data_schema.journal import Entry
from data_schema.vocabulary import Action
from ingest.store import raw_path
from labbook.export import archive as archives
from labbook.export.capsule import write_capsule
from labbook.export.crate import METADATA
from labbook.export.verifying import Verified, is_active, verify
from tests.cli.shell import good, labbook
from tests.helpers.books import ADA, reported_book, small_book
from tests.helpers.capsules import (
    Files,
    capsule_of_drawn_report,
    capsule_of_small_book,
    entries_of,
    files_of,
    forged,
    rechained,
    restated,
    with_new,
)
from tests.helpers.folders import contents
from tests.helpers.wording import refuses, says


@pytest.fixture
def capsule(tmp_path: Path) -> Path:
    return capsule_of_small_book(tmp_path / "small")


@pytest.fixture(autouse=True)
def _writes_nothing_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Temporary files lie in a folder of the test, which is empty in the end."""
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    yield
    assert contents(place) == {}


def repacked(capsule: Path, out: Path, change: Callable[[zipfile.ZipFile], None] | None = None, **how: int) -> Path:
    """Pack the files of a capsule by Python's own zip, and add to them."""
    with zipfile.ZipFile(out, "w", **how) as archive:  # type: ignore[arg-type]
        for path, data in files_of(capsule).items():
            archive.writestr(f"study/{path}", data)
        if change is not None:
            change(archive)
    return out


def test_a_capsule_is_whole_under_any_name(capsule: Path) -> None:
    found = verify(capsule.rename(capsule.with_name("my study.eln")))
    assert not found.differences
    numbers = json.loads(files_of(capsule.with_name("my study.eln"))["report/numbers.json"])["numbers"]
    assert (found.numbers, found.raw_copies, found.tables) == (len(numbers), 14, 9)
    assert says(found.sentence, "my study.eln", "whole", len(numbers))


def test_the_command_exits_with_0_or_1_and_says_what_differs(capsule: Path, tmp_path: Path) -> None:
    answer = good(labbook("verify", capsule, "--json", at=tmp_path))
    assert answer.json["whole"] is True

    def add(files: Files) -> None:
        files["notes.txt"] = b"more"

    other = labbook("verify", forged(capsule, tmp_path / "other.eln", add), "--json", at=tmp_path)
    assert (other.code, other.json["whole"]) == (1, False)
    assert says(other.json["differences"], "notes.txt")
    missing = labbook("verify", tmp_path / "none.eln", at=tmp_path)
    assert missing.code == 2
    assert says(missing.err, "none.eln")


def test_a_capsule_of_a_selection_and_of_an_earlier_report_is_whole(tmp_path: Path) -> None:
    book = reported_book(tmp_path / "book", "b_ad_gain=0", None)
    good(labbook("jumps", "reject", "r001", "2", "--reason", "misfire", "--as", ADA, at=book.folder))
    with book.open() as opened:
        write_capsule(opened, tmp_path / "first.eln", "1")
    assert not verify(tmp_path / "first.eln").differences


# What an accident does


def in_a_soak(case: str) -> Any:
    return pytest.param(case, marks=pytest.mark.soak)


def flipped(capsule: Path, out: Path, place: int, value: int) -> Path:
    data = bytearray(capsule.read_bytes())
    data[place] ^= value
    out.write_bytes(data)
    return out


def passes(altered: Path) -> bool:
    """Whether an altered capsule is taken for whole."""
    try:
        return verify(altered).whole
    except LabbookError:
        return False


@pytest.mark.parametrize("seeds", [range(40), pytest.param(range(1000), marks=pytest.mark.soak)])
def test_a_byte_that_changed_is_named_or_refused(capsule: Path, tmp_path: Path, seeds: range) -> None:
    n_bytes = capsule.stat().st_size
    draws = [random.Random(seed) for seed in seeds]
    changes = [(rng.randrange(n_bytes), rng.randrange(1, 256)) for rng in draws]
    assert [change for change in changes if passes(flipped(capsule, tmp_path / "altered.eln", *change))] == []


@pytest.mark.parametrize("most", [4, pytest.param(98, marks=pytest.mark.soak)])
def test_a_byte_around_the_files_that_changed_is_named_or_refused(capsule: Path, tmp_path: Path, most: int) -> None:
    """Bytes of the first file's head, of the first row of the list of names, and of the archive's end."""
    data = capsule.read_bytes()
    row = data.index(b"PK\1\2")
    places = [*range(30), *range(row, row + 46), *range(len(data) - 22, len(data))]
    some = random.Random(3).sample(places, most)
    assert [place for place in some if passes(flipped(capsule, tmp_path / "altered.eln", place, 1))] == []


def test_a_place_beyond_the_archive_is_refused(capsule: Path, tmp_path: Path) -> None:
    data = bytearray(capsule.read_bytes())
    struct.pack_into("<L", data, data.index(b"PK\1\2") + 42, 0xFFFFFFF0)
    (tmp_path / "altered.eln").write_bytes(data)
    assert not passes(tmp_path / "altered.eln")


@pytest.mark.parametrize("n_bytes", [0, 3, 1000, -1, -100])
def test_one_that_was_cut_off_is_refused(capsule: Path, tmp_path: Path, n_bytes: int) -> None:
    (tmp_path / "cut.eln").write_bytes(capsule.read_bytes()[:n_bytes])
    with refuses(InputRefused, "cut.eln"):
        verify(tmp_path / "cut.eln")


def test_one_that_another_program_packed_is_read_and_said_to_be(capsule: Path, tmp_path: Path) -> None:
    found = verify(repacked(capsule, tmp_path / "packed.eln", compression=zipfile.ZIP_DEFLATED))
    assert len(found.differences) == 1
    assert says(found.differences, "packed anew")
    assert found.numbers > 0


# What somebody did who made all hashes fit


def differences(capsule: Path, out: Path, change: Callable[[Files], None]) -> Verified:
    found = verify(forged(capsule, out, change))
    assert not found.whole
    return found


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "forged.eln"


def test_a_number_that_was_made_better_is_named_with_its_amount(capsule: Path, out: Path) -> None:
    first: list[str] = []

    def change(files: Files) -> None:
        numbers = json.loads(files["report/numbers.json"])
        uid, number = next((uid, one) for uid, one in numbers["numbers"].items() if one["value"])
        number["value"] *= 1.5
        first.append(uid)
        files["report/numbers.json"] = json.dumps(numbers).encode()
        restated(files)

    found = differences(capsule, out, change)
    assert says(found.differences, first[0], "a difference of", "33 %")


def test_a_page_that_was_exchanged_is_found(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        files["report/report.html"] = b"<p>better"

    assert says(differences(capsule, out, change).differences, "report")


def test_pages_are_written_anew_around_their_figures(tmp_path: Path, out: Path) -> None:
    drawn = capsule_of_drawn_report(tmp_path / "drawn")
    found = verify(drawn)
    assert not found.differences
    assert says(found.remarks, "figures", "not drawn again")
    assert says(found.remarks, entries_of(files_of(drawn))[-1].hash)

    def change(files: Files) -> None:
        files["report/report.html"] = files["report/report.html"].replace(b" J", b" kJ")
        files["report/tables/each_run.csv"] = b"run,joules_J\nr001,3\n"
        files["report/tables/more.csv"] = b""
        del files["report/tables/each_run.tex"]
        restated(files)

    found = differences(drawn, out, change)
    for facts in (("report.html", "kJ"), ("each_run.csv", "joules_J"), ("more.csv",), ("each_run.tex", "missing")):
        assert says(found.differences, *facts)


@pytest.mark.soak
def test_a_figure_that_is_missing_and_pages_of_other_software_are_said_to_be(tmp_path: Path, out: Path) -> None:
    drawn = capsule_of_drawn_report(tmp_path / "drawn")

    def figure(files: Files) -> None:
        del files["report/figures/savings.svg"]
        restated(files)

    assert says(differences(drawn, out, figure).differences, "figure", "savings")
    out.unlink()

    def other_software(files: Files) -> None:
        files["report/report.html"] = files["report/report.html"].replace(b"numpy ", b"numpy 0.")
        restated(files)

    assert says(verify(forged(drawn, out, other_software)).remarks, "not compared", "numpy")


def test_a_cell_of_a_table_is_named_with_its_amount(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        text = files["tables/jumps.csv"].decode()
        height = text.splitlines()[1].split(",")[5]
        files["tables/jumps.csv"] = text.replace(height, repr(float(height) + 0.1), 1).encode()

    assert says(differences(capsule, out, change).differences, "tables/jumps.csv", "apex_height_m", "0.1")


def test_a_raw_file_that_was_altered_gives_other_numbers(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        entry = next(one for one in entries_of(files) if (one.new or {}).get("original_name") == "r001.csv")
        sha256 = (entry.new or {})["sha256"]
        data = pa.input_stream(pa.py_buffer(files.pop(raw_path(sha256))), compression="zstd").read()
        head, *lines = data.decode().splitlines()
        cells = [line.split(",") for line in lines]
        higher = [",".join([time_ms, f"{1.05 * float(height):.6f}", *rest]) for time_ms, height, *rest in cells]
        data = "\n".join([head, *higher, ""]).encode()
        other = archives.member("", data).sha256
        compressed = pa.Codec("zstd").compress(data)
        files[raw_path(other)] = bytes(memoryview(compressed))
        rechained(
            files,
            lambda one: (
                with_new(one, sha256=other, n_bytes=len(data)) if (one.new or {}).get("sha256") == sha256 else one
            ),
        )

    assert says(differences(capsule, out, change).differences, "number")


def test_an_entry_that_was_changed_breaks_the_chain(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        files["journal.jsonl"] = files["journal.jsonl"].replace(b"Ada Nwosu", b"Ida Nwosu", 1)

    assert says(differences(capsule, out, change).differences, "journal entry 1", "changed")


def test_an_entry_that_was_left_out_breaks_the_chain(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        lines = files["journal.jsonl"].splitlines(keepends=True)
        files["journal.jsonl"] = b"".join(lines[:30] + lines[31:])

    assert says(differences(capsule, out, change).differences, "journal entry")


def test_samples_that_were_exchanged_are_named(capsule: Path, out: Path) -> None:
    paths: list[str] = []

    def change(files: Files) -> None:
        paths.extend([path for path in files if path.startswith("signals/")][:2])
        files[paths[0]] = files[paths[1]]

    assert says(differences(capsule, out, change).differences, paths[0] if paths else "signals/")


def test_the_configuration_is_that_of_the_journal(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        files["labbook.toml"] = files["labbook.toml"].replace(b"15.4", b"16.8")

    assert says(differences(capsule, out, change).differences, "labbook.toml", "15.4", "16.8")


def test_what_the_crate_says_of_itself_is_what_the_book_says(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        files[METADATA] = files[METADATA].replace(b"Ada Nwosu", b"Ida Nwosu")

    assert says(differences(capsule, out, change).differences, METADATA, "Ida Nwosu")


@pytest.mark.parametrize(
    "path",
    ["raw/00/more.zst", "more.txt", *map(in_a_soak, ("signals/00/more.parquet", "tables/more.csv"))],
)
def test_a_file_that_nothing_gives_is_named(capsule: Path, out: Path, path: str) -> None:
    def change(files: Files) -> None:
        files[path] = b"more"

    assert says(differences(capsule, out, change).differences, path)


@pytest.mark.parametrize(
    "beginning", ["raw/", "report/", *map(in_a_soak, ("signals/", "tables/", "analysis.json", "labbook.toml"))]
)
def test_a_file_that_is_missing_is_named(capsule: Path, out: Path, beginning: str) -> None:
    def change(files: Files) -> None:
        del files[min(path for path in files if path.startswith(beginning))]

    assert says(differences(capsule, out, change).differences, beginning)


# What could do harm


def test_a_journal_that_leads_out_of_the_folder_is_named(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        rechained(files, lambda one: with_new(one, sha256="../../etc/passwd") if one.action is Action.INGEST else one)

    assert says(differences(capsule, out, change).differences, "passwd", "not in the archive")


def test_a_journal_that_no_labbook_wrote_is_named(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        rechained(files, lambda one: replace(one, new={}) if one.entity_kind == "run" else one)

    assert says(differences(capsule, out, change).differences, "cannot be played back")
    out.unlink()

    def nest(files: Files) -> None:
        files["journal.jsonl"] = b"[" * 100_000 + b"\n" + files["journal.jsonl"]

    assert says(differences(capsule, out, nest).differences, "journal")


def test_a_raw_file_that_unpacks_without_end_is_stopped(capsule: Path, out: Path) -> None:
    def change(files: Files) -> None:
        path = next(path for path in files if path.startswith("raw/"))
        files[path] = bytes(memoryview(pa.Codec("zstd").compress(bytes(50_000_000))))

    began = time.monotonic()
    assert says(differences(capsule, out, change).differences, "holds more")
    assert time.monotonic() - began < 10


def test_a_journal_that_lets_files_ask_for_anything_is_named(capsule: Path, out: Path) -> None:
    def raised(entry: Entry) -> Entry:
        if entry.action is not Action.INGEST:
            return entry
        settings = (entry.new or {})["settings"]
        declared = settings["declared"]
        limits = {**declared["limits"], "largest_expanded_bytes": 10**15}
        return with_new(entry, settings={**settings, "declared": {**declared, "limits": limits}})

    found = differences(capsule, out, lambda files: rechained(files, raised))
    assert says(found.differences, "largest_expanded_bytes", 10**15)


NAMES = {
    "absolute": "/etc/cron.d/study",
    "above": "study/../../study.txt",
    "backslash": "study\\..\\..\\study.txt",
    "drive": "C:/study.txt",
    "control": "study/a\nb",
    "long": f"study/{'x' * 300}",
    "deep": f"study/{'x/' * 600}y",
    "dot": "study/./raw/x",
    "empty": "study//x",
    "root": "study.txt",
    "second_root": "other/x.txt",
    "twice": "study/journal.jsonl",
    "case": "study/Journal.jsonl",
    "folder_and_file": "study/journal.jsonl/x",
}


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)
def test_a_name_that_could_do_harm_is_refused(capsule: Path, out: Path, name: str) -> None:
    above = contents(out.parent)
    with refuses(InputRefused, "forged.eln"):
        verify(repacked(capsule, out, lambda archive: archive.writestr(zipfile.ZipInfo(name), b"harm")))
    out.unlink()
    assert contents(out.parent) == above


def test_a_link_is_refused(capsule: Path, out: Path) -> None:
    link = zipfile.ZipInfo("study/link")
    link.create_system, link.external_attr = 3, (stat.S_IFLNK | 0o777) << 16
    with refuses(InputRefused, "study/link", "link"):
        verify(repacked(capsule, out, lambda archive: archive.writestr(link, b"/etc/passwd")))


def test_an_encrypted_file_is_refused(capsule: Path, out: Path) -> None:
    data = bytearray(repacked(capsule, out).read_bytes())
    row = data.index(b"PK\1\2")
    data[6] |= 1
    data[row + 8] |= 1
    out.write_bytes(data)
    with refuses(InputRefused, "encrypted"):
        verify(out)


def test_another_method_of_compression_is_refused(capsule: Path, out: Path) -> None:
    with refuses(InputRefused, "compressed"):
        verify(repacked(capsule, out, compression=zipfile.ZIP_LZMA))


def test_what_is_no_archive_is_refused(tmp_path: Path) -> None:
    for number, data in enumerate((b"", b"PK", b"nothing" * 1000, bytes(10_000))):
        file = tmp_path / f"{number}.eln"
        file.write_bytes(data)
        with refuses(InputRefused, file.name, "zip"):
            verify(file)
    with refuses(UsageError, "temporary"):
        verify(tmp_path / "temporary")


def test_an_archive_without_a_crate_is_refused(tmp_path: Path, out: Path) -> None:
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("study/journal.jsonl", b"")
    with refuses(InputRefused, METADATA):
        verify(out)


_FILE = {"@id": "./a.txt", "@type": "File", "contentSize": "1", "sha256": "0" * 64}


@pytest.mark.parametrize(
    "crate",
    [
        b"",
        b"{",
        b"[]",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"@graph": 3}',
        b'{"@graph": [3]}',
        json.dumps({"@graph": [_FILE, _FILE]}).encode(),
        json.dumps({"@graph": [{**_FILE, "sha256": None}]}).encode(),
        json.dumps({"@graph": [{**_FILE, "sha256": 3}]}).encode(),
        json.dumps({"@graph": [{**_FILE, "contentSize": "-1"}]}).encode(),
        json.dumps({"@graph": [{**_FILE, "contentSize": "1e9"}]}).encode(),
        json.dumps({"@graph": [{**_FILE, "contentSize": None}]}).encode(),
    ],
)
def test_a_crate_that_cannot_be_read_is_refused(out: Path, crate: bytes) -> None:
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr(f"study/{METADATA}", crate)
        archive.writestr("study/a.txt", b"a")
    with refuses(InputRefused, METADATA):
        verify(out)


def bomb(out: Path, stated: int, n_bytes: int = 20_000_000) -> Path:
    """An archive of a file that unpacks to far more bytes than the archive has, and a crate that states so many."""
    with zipfile.ZipFile(out, "w", compression=zipfile.ZIP_DEFLATED) as archive:
        crate = {"@graph": [{**_FILE, "contentSize": str(stated)}]}
        archive.writestr(f"study/{METADATA}", json.dumps(crate))
        archive.writestr("study/a.txt", bytes(n_bytes))
    return out


def test_a_file_is_read_no_further_than_the_crate_states(out: Path) -> None:
    assert says(verify(bomb(out, 1000)).differences, "a.txt", "more than the 1000 bytes")


def test_sizes_in_the_archive_are_not_believed(out: Path) -> None:
    data = bytearray(bomb(out, 1000).read_bytes())
    row = data.rindex(b"PK\1\2")
    struct.pack_into("<L", data, row + 24, 1000)
    out.write_bytes(data)
    assert not verify(out).whole


@pytest.mark.parametrize("stated", [90_000_000, 10**14])
def test_more_bytes_than_such_an_archive_can_have_are_refused(out: Path, stated: int) -> None:
    with refuses(InputRefused, str(stated)[:5], "at most"):
        verify(bomb(out, stated, 1000))


def test_files_that_share_their_bytes_are_refused(out: Path) -> None:
    """The bomb that needs no nesting: many names for the same compressed bytes."""
    data = bytearray(bomb(out, 1000, 1000).read_bytes())
    rows = [place for place in range(len(data)) if data[place : place + 4] == b"PK\1\2"]
    struct.pack_into("<L", data, rows[0] + 42, struct.unpack_from("<L", data, rows[1] + 42)[0])
    out.write_bytes(data)
    with pytest.raises(InputRefused):
        verify(out)


def test_a_list_of_names_that_would_fill_the_memory_is_refused(capsule: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archives, "MOST_DIRECTORY", 1000)
    with refuses(InputRefused, "list of names"):
        verify(capsule)


def test_a_large_description_is_refused(capsule: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("labbook.export.verifying.MOST_METADATA", 1000)
    with refuses(InputRefused, METADATA, "more than"):
        verify(capsule)


def test_a_page_of_the_labs_own_and_word_tables_are_whole_and_an_altered_one_is_named(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    own = tmp_path / "own"
    own.mkdir()
    (own / "report.html.j2").write_text("<h1>{{ content.title }}</h1>")
    good(labbook("report", "--template", own, "--docx", at=book.folder))
    capsule = tmp_path / "study.eln"
    good(labbook("export", "--capsule", capsule, at=book.folder))
    found = verify(capsule)
    assert not found.differences
    assert found.remarks
    for name in ("report/report.html", "report/tables.docx"):

        def change(files: Files, name: str = name) -> None:
            files[name] = b"another"

        altered = forged(capsule, tmp_path / "forged.eln", change)
        assert verify(altered).differences, name
        altered.unlink()


@pytest.mark.parametrize(
    "text",
    [
        b"<svg><script>alert(1)</script></svg>",
        b"<svg:script/>",
        b'<svg onload="x()"/>',
        b"<svg/onload=x()>",
        b'<a href="https://example.org">',
        b'<a xlink:href="javascript:x()">',
        b"<svg><foreignObject/></svg>",
        b'<use href="other.svg#a"/>',
    ],
)
def test_a_drawing_that_could_do_something_is_told_from_others(text: bytes, tmp_path: Path) -> None:
    assert is_active(b"<svg>" + text)
    drawn = files_of(capsule_of_drawn_report(tmp_path / "drawn"))
    figures = {path: data for path, data in drawn.items() if path.endswith(".svg")}
    assert figures
    assert not [path for path, data in figures.items() if is_active(data)]


def test_a_figure_with_a_script_and_a_configuration_of_another_study_are_named(tmp_path: Path, out: Path) -> None:
    drawn = capsule_of_drawn_report(tmp_path / "drawn")

    def script(files: Files) -> None:
        path = next(path for path in files if path.endswith(".svg"))
        files[path] = files[path].replace(b"</svg>", b"<script>document.title = 1</script></svg>")
        restated(files)

    assert says(differences(drawn, out, script).differences, ".svg", "script")
    out.unlink()

    def other_voltage(files: Files) -> None:
        toml = files["labbook.toml"]
        files["labbook.toml"] = changed = toml.replace(b"reference_voltage_v = 15.4", b"reference_voltage_v = 16.4")
        assert changed != toml
        digest = hashlib.sha256(changed).hexdigest()

        def restate(entry: Entry) -> Entry:
            if entry.entity_kind != "config" or (entry.new or {}).get("text") != toml.decode():
                return entry
            return with_new(entry, text=changed.decode(), sha256=digest)

        rechained(files, restate)

    assert says(differences(drawn, out, other_voltage).differences, "reference_voltage_v", "16.4", "15.4")
