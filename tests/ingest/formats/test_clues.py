"""Clues save work and decide nothing: whatever a format recognises holds its clue."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ingest.formats.chargers.sheet import ROLES
from ingest.formats.format import sniff
from ingest.formats.registry import FORMATS, recognition
from ingest.model import ColumnDeclaration, Declarations, FindingCollector
from ingest.read import read_file
from tests.ingest.good_files import GOOD_FILES
from tests.ingest.maker_files import MAKERS

FILES = {**GOOD_FILES, **{f"{name} of a maker": maker.write for name, maker in MAKERS.items()}}


def hidden(data: bytes, declared: Declarations) -> list[str]:
    """Name the formats that recognise a file which lacks their clue."""
    head = sniff(data, declared, FindingCollector(), read_file)
    unseen = [each for each in FORMATS if not each.may_be(head)]
    return [each.name for each in unseen if recognition(each, head, FindingCollector()) is not None]


def shown(data: bytes, declared: Declarations | None = None) -> list[str]:
    """Name the formats that recognise a file and are shown it."""
    head = sniff(data, declared or Declarations(), FindingCollector(), read_file)
    return [each.name for each in FORMATS if each.may_be(head) and recognition(each, head, FindingCollector())]


def respelt(data: bytes, rng: random.Random) -> bytes:
    """Return a file whose names are written otherwise: `fZ`, `Chan nel`, `C_a_p`, `mA\u00b7h`."""
    letters = bytearray()
    for letter in data[:6000]:
        letters.append(letter)
        if bytes([letter]).isalpha() and not rng.randrange(9):
            letters += rng.choice((b" ", b"_", b"-", b".", b"*", b"\xc2\xb7", b"\xb7"))
        elif not rng.randrange(9):
            letters[-1:] = letters[-1:].swapcase()
    return bytes(letters) + data[6000:]


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
    for _ in range(5):
        assert hidden(respelt(data, rng), Declarations()) == []
    assert hidden(data.upper(), Declarations()) == []
    assert hidden(data.decode("latin-1").encode("utf-16-le"), Declarations(encoding="utf-16-le")) == []


def test_rows_without_names_are_those_of_the_instrument_that_is_declared() -> None:
    rows = b"".join(b"%d,2,3,4,5,6\n" % row for row in range(30))
    assert hidden(rows, Declarations(instrument="amti")) == []


NAMES_OF_CHARGES = (
    "mA\u00b7h",
    "mA h",
    "mA-h",
    "mA*h",
    "A h",
    "A\u00b7h",
    "CHARGE",
    "Char ge",
    "c_h_a_r_g_e",
    "Capa-city",
    "CAPAC\u0130TY",
)


@pytest.mark.parametrize("page", ["utf-8", "utf-8-sig", "utf-16", "cp1254"])
@pytest.mark.parametrize("name", NAMES_OF_CHARGES)
def test_a_sheet_is_shown_by_a_charge_in_any_spelling(name: str, page: str) -> None:
    sheet = f"run,{name},minutes,pack\n" + "".join(f"r{row:03d},{800 + row},50,A\n" for row in range(9))
    declared = Declarations(encoding="cp1254") if page == "cp1254" else Declarations()
    assert "charger_sheet" in shown(sheet.encode(page), declared)


SPELLING = st.sampled_from(["", "", "", " ", "_", "-", ".", "*", "\u00b7", "\u00a0", "\n", " [] ", " (min) ", " [s] "])
CHARGES = sorted(word.strip() for word in ROLES["charge"].split(","))


@st.composite
def spelt(draw: st.DrawFn, words: list[str]) -> str:
    return "".join(
        draw(st.sampled_from([letter, letter.upper()])) + draw(SPELLING) for letter in draw(st.sampled_from(words))
    )


@given(
    spelt(CHARGES),
    st.sampled_from(["", "[mAh]", "(Ah)", "[mA\u00b7h]"]),
    st.sampled_from(["utf-8", "utf-16", "latin-1"]),
    st.sampled_from(",;\t"),
    st.booleans(),
)
def test_no_clue_hides_a_header_of_charges(name: str, unit: str, page: str, sign: str, late: bool) -> None:
    title = "".join(f"{'-' * 4000}\n" for _ in range(20)) if late else ""
    rows = "".join(f"r{row:03d}{sign}{row}\n" for row in range(9))
    sheet = f'{title}run{sign}"{name} {unit}"\n{rows}'
    assert hidden(sheet.encode(page), Declarations()) == []
    assert hidden(sheet.encode(page), Declarations(header_row=21 if late else 1)) == []
    for said in (ColumnDeclaration("charge"), ColumnDeclaration(unit="mAh")):
        assert hidden(sheet.encode(page), Declarations(columns={"2": said})) == []


def test_a_header_far_down_that_is_declared_is_seen() -> None:
    title = "".join(f"{'-' * 400}\n" for _ in range(200))
    sheet = title + "run,mAh,pack\n" + "".join(f"r{row:03d},{800 + row},A\n" for row in range(9))
    assert "charger_sheet" in shown(sheet.encode(), Declarations(header_row=201))


def channels(names: list[str]) -> str:
    return "\t".join(["time", *names]).replace("\n", " ") + "\n" + ("\t".join("123456789") + "\n") * 9


@pytest.mark.parametrize(
    "name", ["Channel %d", "CHAN NEL-%d", "c\u00b7h_annel%d", "Cha (V) nnel %d", "C [V] hannel %d"]
)
@pytest.mark.parametrize("page", ["utf-8", "utf-16", "latin-1"])
def test_eight_channels_are_shown_in_any_spelling(name: str, page: str) -> None:
    assert "kistler_channels" in shown(channels([name % place for place in range(8)]).encode(page))


@given(st.tuples(*(spelt([f"channel {place}"]) for place in range(8))), st.sampled_from(["utf-8", "utf-16", "latin-1"]))
def test_no_clue_hides_eight_channels(names: tuple[str, ...], page: str) -> None:
    assert hidden(channels(list(names)).encode(page), Declarations()) == []


LABELS = (
    "Channel 100",
    "ch1000",
    "id1024",
    "m_1000",
    "joint.1234",
    "x[12]",
    "a(99)",
    "_1",
    "force-12",
    "b%100",
    "v" + 90 * "1",
)


@pytest.mark.parametrize("sign", [":", "=", " : ", "\t= ", "\f:"])
@pytest.mark.parametrize("label", LABELS)
def test_labels_that_end_in_digits_are_shown(label: str, sign: str) -> None:
    other = label + "1" if label[-1].isdigit() else "w" + label
    values = [(10 + row % 80, 11 + row % 70) for row in range(40)]
    beside = "".join(f"{label}{sign}{one} {other}{sign}{two}\n" for one, two in values).encode()
    below = "".join(f"{label}{sign}{one}\n{other}{sign}{two}\n" for one, two in values).encode()
    assert hidden(beside, Declarations()) == hidden(below, Declarations()) == []
    assert {"debug_lines", "labelled_values"} & {*shown(beside), *shown(below)}


@given(
    st.lists(st.text('aZ_09 ./%()[]-\u00e9\u00b5\t"', min_size=1, max_size=12), min_size=1, max_size=3),
    st.sampled_from([":", "=", " :", ": "]),
    st.sampled_from(["utf-8", "utf-16", "latin-1"]),
)
def test_no_clue_hides_labels(labels: list[str], sign: str, page: str) -> None:
    for between in ("\n", " ", ", ", ";"):
        lines = "".join(between.join(f"{label}{sign}{10 + row}" for label in labels) + "\n" for row in range(20))
        assert hidden(lines.encode(page), Declarations()) == []


@pytest.mark.parametrize("names", [("1", "2"), ("\u9ad8", "\u4f4e"), ("", "a"), ("12", "3\\n")])
@pytest.mark.parametrize("between", [":", " : ", ":\t"])
def test_objects_of_json_are_shown(names: tuple[str, str], between: str) -> None:
    one, two = names
    lines = "".join(f'{{"{one}"{between}{10 + row}, "{two}"{between}{row}}}\n' for row in range(20))
    assert "labelled_values" in shown(lines.encode())
