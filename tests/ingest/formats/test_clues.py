"""Clues save work and decide nothing: whatever a format recognises holds its clue."""

from __future__ import annotations

import random

import pytest

from ingest.formats.format import sniff
from ingest.formats.registry import FORMATS, recognition
from ingest.model import Declarations, FindingCollector
from ingest.read import read_file
from tests.ingest.good_files import GOOD_FILES
from tests.ingest.maker_files import MAKERS

FILES = {**GOOD_FILES, **{f"{name} of a maker": maker.write for name, maker in MAKERS.items()}}


def hidden(data: bytes, declared: Declarations) -> list[str]:
    """Name the formats that recognise a file which lacks their clue."""
    head = sniff(data, declared, FindingCollector(), read_file)
    unseen = [each for each in FORMATS if not each.may_be(head)]
    return [each.name for each in unseen if recognition(each, head, FindingCollector()) is not None]


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
