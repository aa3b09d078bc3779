"""The journal: every statement comes back as it was made, and no change of what was written goes unseen."""

from __future__ import annotations

import hashlib
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
import sqlalchemy as sa
from hypothesis import given
from hypothesis import strategies as st

from data_schema import journal
from data_schema.engine import reading, writing
from data_schema.errors import BookDamaged, BookVersion
from data_schema.journal import GENESIS, JOURNAL_SCHEMA, Entry, canonical, chain_entries, commands, verified_chain
from data_schema.journal_file import NOTHING, JournalFile, LeftOut
from data_schema.tables.journal import journal as table
from data_schema.vocabulary import Action
from tests.cli.shell import no_file_above
from tests.helpers.journals import chain, entry, write_all
from tests.helpers.wording import refuses

TEXT = st.text(st.characters(exclude_categories=["Cs"]))
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | TEXT,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXT, inner, max_size=3),
    max_leaves=6,
)
SAID = st.fixed_dictionaries(
    {
        "at_utc": TEXT,
        "person": st.sampled_from(["Ada Nwosu", "Ben Ode", "Zoë Ł"]),
        "action": st.sampled_from(Action),
        "entity_kind": TEXT,
        "entity_uid": TEXT,
        "old": st.none() | st.dictionaries(TEXT, PLAIN, max_size=3),
        "new": st.none() | st.dictionaries(TEXT, PLAIN, max_size=3),
        "reason": st.none() | TEXT,
        "origin": st.none() | st.fixed_dictionaries({"seq": st.integers(1, 99), "hash": TEXT}),
    }
)
CHAINS = st.lists(SAID, min_size=2, max_size=6).map(chain)


@pytest.fixture(scope="module")
def mirror(tmp_path_factory: pytest.TempPathFactory) -> JournalFile:
    return JournalFile(tmp_path_factory.mktemp("journal") / "journal.jsonl")


def written(mirror: JournalFile, entries: list[Entry]) -> bytes:
    mirror.path.write_bytes(b"")
    mirror.append(entries)
    return mirror.path.read_bytes()


# --- lines


@given(SAID, st.integers(1, 2**62))
def test_an_entry_comes_back_from_its_line(said: dict[str, Any], seq: int) -> None:
    one = entry(seq, GENESIS, **said)
    back = Entry.from_line(one.line)
    assert back == one
    assert back.line == one.line
    assert "\n" not in one.line


@pytest.mark.parametrize(
    ("new", "written_as", "forged_as"),
    [
        ({"a": 1}, '"new":{', '"new": {'),
        ({"a": 1e-5}, '"a":1e-05', '"a":0.00001'),
        ({"a": 1e16}, '"a":1e+16', '"a":1e16'),
        ({"a": "x"}, '"a":"x"', '"a":"\\u0078"'),
        ({"a": "x"}, '"a":"x"', '"a":"y","a":"x"'),
        ({"a": "x"}, '"old":null', '"old":null,"origin":null'),
    ],
)
def test_a_line_is_written_in_one_way_alone(new: dict[str, Any], written_as: str, forged_as: str) -> None:
    refuse_written_otherwise(new, written_as, forged_as)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_is_written_in_one_way_alone(number: float) -> None:
    written_as, forged_as = canonical(number), msgspec.json.encode(number).decode()
    if written_as != forged_as:
        refuse_written_otherwise({"a": number}, f'"a":{written_as}}}', f'"a":{forged_as}}}')


def refuse_written_otherwise(new: dict[str, Any], written_as: str, forged_as: str) -> None:
    one = entry(2, GENESIS, new=new)
    unhashed = one.line.replace(f'"hash":"{one.hash}",', "")
    assert Entry.from_line(one.line) == one
    assert written_as in unhashed
    forged = unhashed.replace(written_as, forged_as)
    hashed = f'"hash":"{hashlib.sha256(forged.encode()).hexdigest()}","new":'
    with pytest.raises(BookDamaged):
        Entry.from_line(forged.replace('"new":', hashed, 1))


@pytest.mark.parametrize("schema", [None, JOURNAL_SCHEMA + 1])
def test_a_journal_of_another_schema_is_refused(mirror: JournalFile, schema: int | None) -> None:
    written(mirror, [entry(1, GENESIS, schema=schema)])
    for read in (lambda: list(mirror.entries()), mirror.last, mirror.damage):
        with refuses(BookVersion, "schema", str(schema or "none"), str(JOURNAL_SCHEMA)):
            read()


@given(CHAINS)
def test_entries_come_back_from_the_file(mirror: JournalFile, entries: list[Entry]) -> None:
    written(mirror, entries[:1])
    mirror.append(entries[1:])
    assert list(mirror.entries()) == entries
    assert mirror.last() == entries[-1]
    assert all(mirror.tail(seq) == entries[seq:] for seq in range(len(entries) + 1))


def test_entries_come_back_from_the_database(engine: sa.Engine) -> None:
    said: list[dict[str, Any]] = [
        {"old": {"foot": "small"}, "new": {"foot": "large"}, "reason": 'typed "wrong"; DROP TABLE'},
        {"new": None, "person": "Zoë Ł", "action": Action.EXCLUDE},
        {"new": {"a": 0.1 + 0.2, "b": [1, None, True, 2**53 + 1], "c": {"d": "ünïcode \u2028\n\\"}}, "old": {}},
        {"origin": {"seq": 7, "hash": "ab" * 32}},
    ]
    entries = chain(said)
    with writing(engine) as connection:
        assert journal.head(connection) == (0, GENESIS)
        write_all(connection, entries)
    with reading(engine) as connection:
        assert list(verified_chain(journal.stored(connection))) == entries
        assert journal.head(connection) == (4, entries[-1].hash)


def test_canonical_text_knows_no_nan() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        canonical({"height": float("nan")})


# --- the chain


def flip_a_byte(content: bytes, data: st.DataObject) -> bytes:
    place = data.draw(st.integers(0, len(content) - 2), "place")  # without the last newline that is a cut-off line
    return content[:place] + bytes([content[place] ^ data.draw(st.integers(1, 255), "bits")]) + content[place + 1 :]


def remove_a_line(content: bytes, data: st.DataObject) -> bytes:
    lines = content.splitlines(keepends=True)
    del lines[data.draw(st.integers(0, len(lines) - 2), "line")]
    return b"".join(lines)


def swap_lines(content: bytes, data: st.DataObject) -> bytes:
    lines = content.splitlines(keepends=True)
    first, second = data.draw(st.lists(st.integers(0, len(lines) - 1), min_size=2, max_size=2, unique=True))
    lines[first], lines[second] = lines[second], lines[first]
    return b"".join(lines)


@pytest.mark.parametrize("change", [flip_a_byte, remove_a_line, swap_lines])
@given(entries=CHAINS, data=st.data())
def test_a_change_is_seen(
    change: Callable[[bytes, st.DataObject], bytes], mirror: JournalFile, entries: list[Entry], data: st.DataObject
) -> None:
    mirror.path.write_bytes(change(written(mirror, entries), data))
    with pytest.raises(BookDamaged):
        list(mirror.entries())


@given(CHAINS, st.data())
def test_a_line_forged_with_its_own_hash_is_seen_by_the_next(entries: list[Entry], data: st.DataObject) -> None:
    place = data.draw(st.integers(0, len(entries) - 2), "line")
    forged = list(entries)
    forged[place] = entry(place + 1, entries[place].prev_hash, reason="forged", at_utc="never")
    with pytest.raises(BookDamaged, match=f"entry {place + 2} does not follow entry {place + 1}"):
        list(verified_chain(iter(forged)))


def test_a_row_changed_in_the_database_is_seen_though_it_is_the_last(engine: sa.Engine) -> None:
    entries = chain([{}, {}])
    forged = entry(2, entries[0].hash, reason="forged")
    with writing(engine) as connection:
        write_all(connection, entries[:1])
        journal.insert(connection, [forged])
        row = connection.execute(sa.select(table).where(table.c.seq == 2)).mappings().one()
        assert row["hash"] == forged.hash
    with writing(engine) as connection:
        # what a foreign program would leave: other words under the hash of the first
        connection.execute(table.insert().values({**row, "id": 3, "seq": 3, "hash": entries[1].hash}))
    with reading(engine) as connection, refuses(BookDamaged, "3", "database was changed"):
        list(journal.stored(connection))


# --- commands


def test_held_entries_are_those_of_the_file_in_the_memory_of_its_lines(mirror: JournalFile) -> None:
    values = {"settings": {f"column {n}": {"unit": "m", "scale": n / 7} for n in range(20)}}
    entries = chain([{"new": {**values, "text": f"{n}"}} for n in range(2000)])
    n_bytes = len(written(mirror, entries))
    tracemalloc.start()
    held = mirror.held()
    assert [one.hash for one in verified_chain(held)] == [one.hash for one in entries]
    _now, most_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most_bytes < 3 * n_bytes
    assert (len(held), held[-1], [*held[5:7]]) == (2000, entries[-1], entries[5:7])


COMMANDS = st.lists(st.lists(SAID, min_size=1, max_size=4), min_size=2, max_size=4)


def in_commands(said: list[list[dict[str, Any]]]) -> list[list[Entry]]:
    """Commands of several entries each, one after another."""
    made: list[list[Entry]] = []
    for words in said:
        after = (made[-1][-1].seq, made[-1][-1].hash) if made else (0, GENESIS)
        made.append(chain_entries([entry(0, GENESIS, **one) for one in words], after))
    return made


@given(COMMANDS)
def test_chained_entries_follow_each_other_and_part_into_their_commands(said: list[list[dict[str, Any]]]) -> None:
    made = in_commands(said)
    entries = [one for command in made for one in command]
    assert list(verified_chain(entries)) == entries
    assert list(commands(entries)) == made
    assert [one.following for one in made[0]] == list(range(len(made[0])))[::-1]


@given(COMMANDS, st.data())
def test_of_a_command_that_was_cut_off_anywhere_nothing_counts(
    mirror: JournalFile, said: list[list[dict[str, Any]]], data: st.DataObject
) -> None:
    *before, last = in_commands(said)
    kept = [one for command in before for one in command]
    whole = written(mirror, kept + last)
    start = len(written(mirror, kept))
    left = data.draw(st.integers(start, len(whole) - 2), "bytes left")  # without its newline alone it is whole
    mirror.path.write_bytes(whole[:left])
    assert list(mirror.entries()) == kept
    assert mirror.last() == kept[-1]
    assert mirror.tail(0) == kept
    assert mirror.tail(kept[-1].seq) == []
    mirror.append(last)
    assert mirror.path.read_bytes() == whole


@given(COMMANDS)
def test_a_journal_that_lacks_only_its_last_newline_lacks_nothing(
    mirror: JournalFile, said: list[list[dict[str, Any]]]
) -> None:
    *before, last = in_commands(said)
    kept = [one for command in before for one in command]
    whole = written(mirror, kept)
    mirror.path.write_bytes(whole[:-1])
    assert list(mirror.entries()) == mirror.tail(0) == kept
    assert mirror.last() == kept[-1]
    assert mirror.left_out() == NOTHING
    assert mirror.keep_cut_off() is None
    mirror.append(last)
    assert mirror.path.read_bytes() == whole + "".join(one.line + "\n" for one in last).encode()


def test_what_was_cut_off_is_kept_beside_the_journal_before_it_is_removed(tmp_path: Path) -> None:
    mirror = JournalFile(tmp_path / "journal.jsonl")
    first, last = in_commands([[{}], [{"reason": "ä"}] * 3])
    whole = written(mirror, first + last)
    start = len(written(mirror, first))
    expected: dict[bytes, None] = {}
    for left in range(start, len(whole)):
        mirror.path.write_bytes(whole[:left])
        rest = whole[start:left] if left < len(whole) - 1 else b""
        lines = rest.splitlines()
        assert mirror.left_out() == LeftOut(len(lines), len(rest))
        assert (mirror.left_out().sentence is None) == (not rest)
        assert mirror.path.read_bytes() == whole[:left]
        mirror.append([])
        if rest:
            expected[rest] = None
    kept = sorted(tmp_path.glob("journal.jsonl.cut-off.*"))
    assert [path.read_bytes() for path in kept] == list(expected)


def test_a_last_line_without_newline_that_was_changed_is_set_aside(tmp_path: Path) -> None:
    """Its hash does not fit: it is no statement, and no byte of it is lost."""
    mirror = JournalFile(tmp_path / "journal.jsonl")
    first, last = in_commands([[{}], [{}]])
    whole = written(mirror, first + last)
    changed = whole[:-1].replace(b"remark", b"remork")
    mirror.path.write_bytes(whole[: len(first[0].line) + 1] + changed[len(first[0].line) + 1 :])
    assert mirror.last() == first[0]
    mirror.append(last)
    assert mirror.path.read_bytes() == whole
    (kept,) = tmp_path.glob("journal.jsonl.cut-off.*")
    assert kept.read_bytes() == changed[len(first[0].line) + 1 :]


@pytest.mark.parametrize("size", [40, 30_000])
def test_a_long_command_that_was_cut_off_is_found_from_the_end(mirror: JournalFile, size: int) -> None:
    """Longer than what is read of the end at first, and than what is read then."""
    first, last = in_commands([[{}], [{"new": {"text": "x" * size}}] * 100])
    whole = written(mirror, first + last)
    mirror.path.write_bytes(whole[:-10])
    assert mirror.last() == first[0]
    assert mirror.tail(1) == []
    mirror.append(last)
    assert mirror.path.read_bytes() == whole
    assert mirror.tail(1) == last
    assert mirror.tail(50) == last[49:]


# --- the file


def test_entries_that_do_not_fit_on_the_disk_leave_none_of_them(tmp_path: Path) -> None:
    mirror, entries = JournalFile(tmp_path / "journal.jsonl"), chain([{}] * 5)
    before = len(written(mirror, entries[:2]))
    with no_file_above(before + len(entries[2].line) + 10), pytest.raises(OSError, match="File too large"):
        mirror.append(entries[2:])
    assert list(mirror.entries()) == entries[:2]
    mirror.append(entries[2:])
    assert list(mirror.entries()) == entries
