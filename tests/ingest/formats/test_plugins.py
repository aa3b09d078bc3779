"""Plug-ins that fail, each an installed distribution: a sentence names it, and all other formats read on."""

from __future__ import annotations

import gzip
import importlib
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from data_schema.vocabulary import Severity
from ingest.formats.registry import FORMATS, Plugins, all_formats, described_formats, plugins
from ingest.model import Declarations
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.reading import finding, read, refusal, rules
from tests.ingest.synthetic import bertec_acquire, robot_log

USUAL = """
import numpy as np
from data_schema.vocabulary import ChargeMode, FileRole
from ingest.model import FILE
from ingest.formats.format import Format
from ingest.instruments import Instrument
from ingest.model import ChannelData, ChargeRow, Reading, SignalPart

TIMES = np.arange(50) / 100

def recognise(head):
    return "it begins with HOP1" if head.data[:4] == b"HOP1" else None

def channel(name="leg_length", sign=1, values=TIMES):
    return ChannelData(name, "m", "leg", "m", 1.0, 0.0, sign, (), values)

def part(name="log", times=TIMES, rate=100.0, start=None, channels=None):
    return SignalPart(name, times, rate, start, None, (channel(),) if channels is None else channels, ())

def reading(*parts, read=50, rejected=0, role=FileRole.LOG):
    return Reading(parts or (part(),), (), read, rejected, role)

def charge(number=1, mah=150.0, step=1.0, seconds=720.0, volts=16.8, line=2):
    return ChargeRow(number, "r001", None, mah, step, seconds, volts, ChargeMode.CHARGE, None, None, line)

def charges(*rows):
    return Reading((), rows, len(rows), 0, FileRole.CHARGE)

def read(head, findings):
    return reading()

FORMAT = Format("hop", 1, recognise, read)
"""
HOP = b"HOP1\x00\x01"
LOG = robot_log(60)

Install = Callable[..., Plugins]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Install distributions, each a name and the code of its module, and load their plug-ins."""
    made: list[str] = []

    def installed(entry_points: str | None = None, metadata: str | None = None, **modules: str) -> Plugins:
        for name, code in modules.items():
            (tmp_path / f"{name}.py").write_text(textwrap.dedent(code))
            info = tmp_path / f"{name}-1.5.dist-info"
            info.mkdir()
            usual = f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.5\n"
            (info / "METADATA").write_text(usual if metadata is None else metadata)
            (info / "entry_points.txt").write_text(entry_points or f"[labbook.formats]\nhop = {name}:FORMAT\n")
            made.append(name)
        importlib.invalidate_caches()
        plugins.cache_clear()
        return plugins()

    monkeypatch.syspath_prepend(str(tmp_path))
    yield installed
    monkeypatch.undo()
    plugins.cache_clear()
    for name in made:
        sys.modules.pop(name, None)


def assert_others_read_on() -> None:
    assert all_formats()[: len(FORMATS)] == FORMATS
    result = read(LOG)
    assert (result.format, result.refused, result.rows_kept) == ("delimited_log", False, 60)
    assert len(described_formats()) == len(all_formats())


def test_a_plugin_reads_its_files_and_is_named(install: Install) -> None:
    assert install(hopper=USUAL).faults == ()
    result = read(HOP)
    assert (result.refused, result.format, result.plugin, len(result.parts)) == (False, "hop", "hopper 1.5", 1)
    assert_others_read_on()


NOT_LOADED = {
    "raises at import": "raise RuntimeError('no licence\\nserver')",
    "leaves at import": "import sys\nsys.exit(3)",
    "no format": "FORMAT = 3",
    "a function that raises": "def FORMAT():\n    raise KeyError('hop')",
    "an error without words": "class Odd(Exception):\n    def __str__(self):\n        raise ValueError\nraise Odd",
    **{
        what: f"{USUAL}\nFORMAT = {made}"
        for what, made in {
            "version no int": "Format('hop', '1.5', recognise, read)",
            "name no text": "Format(7, 1, recognise, read)",
            "score above all": "Format('hop', 1, recognise, read, score=10**6)",
            "clue in capitals": "Format('hop', 1, recognise, read, clues=(b'HOP1',))",
            "clue of nothing": "Format('hop', 1, recognise, read, clues=(b'',))",
            "clue that any file holds": "Format('hop', 1, recognise, read, clues=(b'$',))",
            "clue in capitals behind an escape": "Format('hop', 1, recognise, read, clues=(rb'\\dHOP',))",
            "clue whose brackets group nothing": "Format('hop', 1, recognise, read, clues=(b'run (1)',))",
            "clue that is no pattern": "Format('hop', 1, recognise, read, clues=(b'(',))",
            "clue of text": "Format('hop', 1, recognise, read, clues=('hop',))",
            "clues that are one": "Format('hop', 1, recognise, read, clues=b'hop')",
            "beginning of text": "Format('hop', 1, recognise, read, begins='HOP')",
            "beginning of any file": "Format('hop', 1, recognise, read, begins=b'^')",
            "beginning whose brackets group nothing": "Format('hop', 1, recognise, read, begins=b'RUN (1)')",
            "recognise no function": "Format('hop', 1, 'HOP1', read)",
        }.items()
    },
}


@pytest.mark.parametrize("code", NOT_LOADED.values(), ids=NOT_LOADED)
def test_a_plugin_that_cannot_be_loaded_is_named_and_the_next_one_is(code: str, install: Install) -> None:
    found = install(broken=code, hopper=USUAL.replace('"hop"', '"hop2"'))
    (fault,) = found.faults
    says(fault, "broken 1.5")
    assert "\n" not in fault
    assert [format_.name for format_ in found.formats] == ["hop2"]
    assert_others_read_on()


@pytest.mark.parametrize(
    "more",
    [
        r"clues=(rb'\S\W\D',)",
        r"clues=(rb'run \(1\)', b'hop')",
        r"clues=(rb'h(o|0)p', rb'(?P<digit>\d)(?P=digit)', rb'(ab)+', rb'[(]1[)]', rb'(.)\1')",
        "begins=b'HOP1'",
    ],
)
def test_a_plugin_may_have_patterns(more: str, install: Install) -> None:
    assert install(hopper=f"{USUAL}\nFORMAT = Format('hop', 1, recognise, read, {more})").faults == ()


def test_a_plugin_without_recognise_reads_where_it_is_declared(install: Install) -> None:
    assert install(hopper=f"{USUAL}\nFORMAT = Format('hop', 1, None, read)").faults == ()
    assert read(HOP).refused
    assert read_file(HOP, Declarations(format="hop")).format == "hop"
    assert_others_read_on()


def test_axes_that_a_plugin_gives_wrongly_are_named_beside_those_there_are(install: Install) -> None:
    body = "read_signals(array_table(['time', 'force_z'], ['s', 'N'], [TIMES, TIMES]), head.declared, findings, "
    body = f"return {body}Instrument(frame='sideways'))"
    code = f"from ingest.signals import read_signals\nfrom ingest.tables.table import array_table\n{USUAL}"
    code += f"\ndef odd(head, findings):\n    {body}\n"
    install(hopper=f"{code}FORMAT = Format('hop', 1, recognise, odd)")
    says(finding(read(HOP), "plugin_failed").message, "hopper 1.5", "'sideways'", "'z up'")
    assert not read_file(HOP, Declarations(format="hop", axes="z up")).refused


@pytest.mark.parametrize(
    ("entry_points", "metadata"),
    [
        ("[labbook.formats]\nhop broken:FORMAT\n", None),
        ("[labbook.formats]\nhop = broken FORMAT here\n", None),
        (None, ""),
    ],
    ids=["entry point without =", "entry point of no module", "no metadata"],
)
def test_a_damaged_installation_concerns_itself_only(
    entry_points: str | None, metadata: str | None, install: Install
) -> None:
    install(hopper=USUAL)
    found = install(entry_points, metadata, broken=USUAL.replace('"hop"', '"hop2"'))
    (fault,) = found.faults
    assert "broken" in fault
    assert [format_.name for format_ in found.formats] == ["hop"]
    assert_others_read_on()


@pytest.mark.parametrize("taken", ["delimited_log", "zip", "unknown"])
def test_a_name_of_labbook_stays_labbooks(taken: str, install: Install) -> None:
    found = install(hopper=USUAL.replace('"hop"', f'"{taken}"'))
    (fault,) = found.faults
    says(fault, "hopper 1.5", repr(taken))
    assert found.formats == ()
    assert_others_read_on()


def test_of_two_plugins_with_one_name_both_are_named(install: Install) -> None:
    found = install(hopper=USUAL, walker=USUAL)
    (fault,) = found.faults
    says(fault, "hopper 1.5", "walker 1.5")
    assert len(found.formats) == 1
    assert_others_read_on()


@pytest.mark.parametrize("body", ["raise ValueError('odd')", "return True"])
def test_a_plugin_that_fails_to_recognise_is_noted_and_left_out(body: str, install: Install) -> None:
    code = f"{USUAL}\ndef odd(head):\n    {body}\nFORMAT = Format('hop', 1, odd, read)"
    assert install(hopper=code).faults == ()
    assert_others_read_on()
    failed = finding(read(LOG), "plugin_failed")
    assert failed.severity is Severity.NOTE
    says(failed.message, "hopper 1.5")


def test_a_plugin_that_claims_every_file_as_a_container_does_not_take_it(install: Install) -> None:
    code = f"{USUAL}\nFORMAT = Format('hop', 1, lambda head: 'any', read, container=True, score=1)"
    assert install(hopper=code).faults == ()
    for data, expected in ((bertec_acquire(), "bertec_text"), (gzip.compress(bertec_acquire()), "gzip")):
        result = read(data)
        assert (result.refused, result.format) == (False, expected)
    assert refusal(read(LOG)).rule == "format_ambiguous"
    says(refusal(read(LOG)).message, "hop")


NOT_READ = {
    "raises": "raise OSError('odd')",
    "nothing": "return None",
    "no role": "return reading(role=None)",
    "two parts of one name": "return reading(part(), part())",
    "two channels of one name": "return reading(part(channels=(channel(), channel())))",
    "fewer values than times": "return reading(part(channels=(channel(values=TIMES[1:]),)))",
    "infinite value": "return reading(part(channels=(channel(values=np.where(TIMES > 0.1, np.inf, 0.0)),)))",
    "sign 0": "return reading(part(channels=(channel(sign=0),)))",
    "times backwards": "return reading(part(times=TIMES[::-1]))",
    "no sample": "return reading(part(times=TIMES[:0], channels=()))",
    "rate of NaN": "return reading(part(rate=float('nan')))",
    "start in no time": "return reading(part(start='noon'))",
    "more rows rejected than read": "return reading(read=5, rejected=6)",
    "recharges numbered from 0": "return charges(charge(0), charge(1))",
    "a recharge that no pack takes": "return charges(charge(mah=1e9))",
    "a recharge without step": "return charges(charge(step=0.0))",
    "a recharge of no time": "return charges(charge(seconds=0.0))",
}


@pytest.mark.parametrize("body", NOT_READ.values(), ids=NOT_READ)
def test_a_plugin_that_fails_to_read_refuses_its_file_by_name(body: str, install: Install) -> None:
    code = f"{USUAL}\ndef odd(head, findings):\n    {body}\nFORMAT = Format('hop', 1, recognise, odd)"
    assert install(hopper=code).faults == ()
    result = read(HOP)
    assert "plugin_failed" in rules(result)
    assert result.findings[0].severity is Severity.FILE
    says(result.findings[0].message, "hopper 1.5")
    assert "\n" not in result.findings[0].message
    assert result.parts == ()
    assert_others_read_on()


def test_recharges_of_a_plugin_may_share_a_line_and_lack_what_was_not_measured(install: Install) -> None:
    body = "return charges(charge(), charge(2, seconds=None, volts=None), charge(3, line=None))"
    install(hopper=f"{USUAL}\ndef odd(head, findings):\n    {body}\nFORMAT = Format('hop', 1, recognise, odd)")
    result = read(HOP)
    assert not result.refused
    assert [charge.row_number for charge in result.charges] == [1, 2, 3]


def test_a_refusal_of_the_plugins_own_is_kept(install: Install) -> None:
    code = f"{USUAL}\ndef odd(head, findings):\n    findings.add(FILE, 'hop_cut', 'Cut.')\n    return Reading()\n"
    install(hopper=f"{code}FORMAT = Format('hop', 1, recognise, odd)")
    assert [finding.rule for finding in read(HOP).findings] == ["hop_cut"]
