"""A file that a plug-in's format read stays in its book, whatever becomes of the plug-in."""

from __future__ import annotations

import functools
import importlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from data_schema.vocabulary import IngestStatus
from ingest.formats.registry import plugins
from tests.helpers.databases import all_rows_by_name
from tests.helpers.desk import desk_at
from tests.helpers.upkeep import rebuilt
from tests.helpers.wording import says

READS = """
import numpy as np
from data_schema.errors import BookDamaged, LabbookError
from data_schema.vocabulary import ChargeMode, FileRole
from ingest.formats.format import Format
from ingest.model import ChannelData, ChargeRow, Reading, SignalPart

def recognise(head):
    return "its first line" if head.data.startswith(b"odd meter") else None

def read(head, findings):
    BODY

FORMAT = Format("odd_meter", 1, recognise, read)
"""
WORKS = """charge = ChargeRow(1, "r001", None, AMOUNT, 1.0, None, None, ChargeMode.CHARGE, None, None)
    time_s = np.arange(3.0)
    channel = ChannelData(NAME, UNIT, "h", "m", 1.0, 0.0, 1, (), np.ones(3))
    part = SignalPart("log", time_s, 1.0, None, None, (channel,), ())
    return Reading((part,), (charge,), ROWS, 0, FileRole.LOG)"""

Install = Callable[[str, str], None]


def works(amount: str = "150.0", name: str = '"height"', unit: str = '"m"', rows: str = "3") -> str:
    said = {"AMOUNT": amount, "NAME": name, "UNIT": unit, "ROWS": rows}
    return functools.reduce(lambda text, word: text.replace(word, said[word]), said, WORKS)


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Install the plug-in `labbook-odd` in a version, with what its reader does."""
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(site)

    def put(version: str, body: str) -> None:
        for old in site.glob("*.dist-info"):
            old.rename(tmp_path / f"{old.name}.old")
        about = site / f"labbook_odd-{version}.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: labbook-odd\nVersion: {version}\n")
        (about / "entry_points.txt").write_text(f"[labbook.formats]\nodd = labbook_odd_{version}:FORMAT\n")
        (site / f"labbook_odd_{version}.py").write_text(READS.replace("BODY", body))
        importlib.invalidate_caches()
        plugins.cache_clear()

    yield put
    plugins.cache_clear()
    for name in [name for name in sys.modules if name.startswith("labbook_odd_")]:
        del sys.modules[name]


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ('raise KeyError("volts")', "KeyError"),
        ('raise LabbookError("no such meter")', "no such meter"),
        ('raise BookDamaged("what it calls damaged")', "what it calls damaged"),
        (works(amount="-1.0"), "charge 1"),
        (works(name="None"), "ValueError"),
        (works(unit=repr("\ud800")), "UnicodeEncodeError"),
        ("return None", "ValueError"),
    ],
)
def test_a_rebuild_does_not_stop_for_a_plugin(tmp_path: Path, install: Install, body: str, said: str) -> None:
    install("1", works())
    with desk_at(tmp_path) as desk:
        assert desk.take("odd.txt", "odd meter\n").status is IngestStatus.IMPORTED
        before = all_rows_by_name(desk.book.engine)
    install("2", body)
    (waits,) = rebuilt(desk.small).differences.files_waiting
    says(waits, said, "plug-in labbook-odd")
    install("3", works())
    with desk.small.open() as book:
        replace(desk, book=book).read_again("odd.txt", {})
        after = all_rows_by_name(book.engine)
    assert (after["charge"], after["run_file"]) == (before["charge"], before["run_file"])
