"""Clues save work and decide nothing: whatever a format recognises holds its clue."""

from __future__ import annotations

import random

import pytest

from ingest.findings import FindingCollector
from ingest.formats.format import Clue, sniff
from ingest.formats.registry import FORMATS
from ingest.model import Declarations
from ingest.read import read_file
from tests.ingest.good_files import GOOD_FILES
from tests.ingest.maker_files import MAKERS
from tests.ingest.synthetic import robot_log

FILES = {**GOOD_FILES, **{f"{name} of a maker": maker.write for name, maker in MAKERS.items()}}


def hidden(data: bytes, declared: Declarations) -> list[str]:
    """Name the formats that recognise a file which lacks their clue."""
    head = sniff(data, declared, FindingCollector(), read_file)
    return [
        each.name
        for each in FORMATS
        if each.clue is not None and not each.clue.is_in(head) and each.recognise(head) is not None
    ]


@pytest.mark.parametrize("name", FILES)
def test_no_clue_hides_a_file(name: str) -> None:
    data = FILES[name]()
    rng = random.Random(name)
    for _ in range(15):
        damaged = bytearray(data)
        for _ in range(rng.randrange(4)):
            damaged[rng.randrange(len(damaged))] = rng.choice(b"\0 \n\r;,\t\xff$A")
        assert hidden(bytes(damaged), Declarations()) == []
    for written in (data.decode("latin-1").encode("utf-16"), b"\xef\xbb\xbf" + data, data.replace(b"\n", b"\r")):
        assert hidden(written, Declarations()) == []


def test_rows_without_names_are_those_of_the_instrument_that_is_declared() -> None:
    rows = b"".join(b"%d,2,3,4,5,6\n" % row for row in range(30))
    assert hidden(rows, Declarations(instrument="amti")) == []


def test_a_plain_log_is_shown_to_few_formats() -> None:
    head = sniff(robot_log(), Declarations(), FindingCollector(), read_file)
    shown = {each.name for each in FORMATS if each.clue is None or each.clue.is_in(head)}
    assert shown == {"charger_sheet", "delimited_log"}


def test_clues_are_found_whatever_the_case_and_between_nuls() -> None:
    head = sniff(b"BIO\0Ware\t1\n" + b"1\t2\n" * 20, Declarations(), FindingCollector(), read_file)
    assert Clue(says=(b"bioware",)).is_in(head)
    assert not Clue(says=(b"BioWare",)).is_in(head)
    assert not Clue(binary=True).is_in(head)
