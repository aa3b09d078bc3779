"""Formats that are known and not read: told by content, refused with what to do instead."""

from __future__ import annotations

import pytest

from ingest.formats.registry import RECOGNISED
from tests.ingest.reading import read, rules

BEGINNINGS = {
    "pdf": b"%PDF-1.7\n",
    "image": b"\x89PNG\r\n\x1a\n" + bytes(range(60)),
    "video": b"\0\0\0\x18ftypmp42" + bytes(range(60)),
    "hdf5": b"\x89HDF\r\n\x1a\n" + bytes(range(60)),
    "run_sheet": b"run,date,position,kind,foot,battery,robot,started,duration_s,jumps_made,starts,note\n",
}


def test_every_signature_has_a_beginning_here() -> None:
    assert BEGINNINGS.keys() == {known.name for known in RECOGNISED}


@pytest.mark.parametrize("name", BEGINNINGS)
def test_it_is_recognised_and_refused_with_what_to_do(name: str) -> None:
    result = read(BEGINNINGS[name])
    assert (result.format, result.refused) == (name, True)
    assert rules(result) == {"format_not_read"}
