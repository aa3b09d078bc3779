"""Random mutants of good logs: what a careless hand, another program or a bad card does to a file.

A mutation changes the bytes and, where it changes how the whole file is written, the dialect; the second parser then
says what the file tells. All files are synthetic.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from dataclasses import dataclass, replace

from tests.ingest.second_parser import Dialect
from tests.ingest.synthetic import LOG_HEADER, robot_rows, text


@dataclass(frozen=True)
class Mutant:
    """A file, how it is written, and the mutations that made it."""

    data: bytes
    dialect: Dialect
    made_by: tuple[str, ...] = ()

    def lines(self) -> list[bytes]:
        return self.data.split(b"\n")

    def header_at(self) -> int:
        return next((at for at, line in enumerate(self.lines()) if b"time" in line), 0)

    def with_lines(self, lines: list[bytes]) -> Mutant:
        return replace(self, data=b"\n".join(lines))


def base(rng: random.Random) -> Mutant:
    """Return a good log of one of the usual dialects."""
    rows = robot_rows(rng.choice((60, 120, 300)), seed=rng.randrange(1000))
    dialect = rng.choice((Dialect(), Dialect(), Dialect(";"), Dialect("\t"), Dialect(";", ",")))
    data = text(LOG_HEADER, rows).decode()
    if dialect.delimiter != ",":
        data = data.replace(",", dialect.delimiter)
    if dialect.decimal == ",":
        data = data.replace(".", ",")
    return Mutant(data.encode(), dialect)


def make_mutant(seed: int) -> Mutant:
    """Return the mutant of that number: one to three mutations of a good log."""
    rng = random.Random(seed)
    mutant = base(rng)
    for name in rng.choices(list(MUTATIONS), k=rng.choice((1, 1, 2, 3))):
        mutant = MUTATIONS[name](mutant, rng)
        mutant = replace(mutant, made_by=(*mutant.made_by, name))
    if rng.random() < 0.1:
        return replace(mutant, data=b"\xef\xbb\xbf" + mutant.data, made_by=(*mutant.made_by, "byte order mark"))
    return mutant


def _row(mutant: Mutant, rng: random.Random) -> int:
    return rng.randrange(1, max(2, len(mutant.lines()) - 1))


def _in_row(mutant: Mutant, rng: random.Random, change: Callable[[bytes], bytes]) -> Mutant:
    lines = mutant.lines()
    at = _row(mutant, rng)
    lines[at : at + 1] = [change(lines[at])] if at < len(lines) else []
    return mutant.with_lines(lines)


def _cell(mutant: Mutant, rng: random.Random, change: Callable[[bytes], bytes]) -> Mutant:
    sign = mutant.dialect.delimiter.encode()

    def in_cells(line: bytes) -> bytes:
        cells = line.split(sign)
        at = rng.randrange(len(cells))
        cells[at] = change(cells[at])
        return sign.join(cells)

    return _in_row(mutant, rng, in_cells)


def _digit(mutant: Mutant, rng: random.Random) -> Mutant:
    places = [found.start() for found in re.finditer(rb"\d", mutant.data)]
    at = rng.choice(places)
    return replace(mutant, data=mutant.data[:at] + str(rng.randrange(10)).encode() + mutant.data[at + 1 :])


def _any_byte(mutant: Mutant, rng: random.Random) -> Mutant:
    at = rng.randrange(len(mutant.data))
    return replace(mutant, data=mutant.data[:at] + bytes([rng.randrange(1, 128)]) + mutant.data[at + 1 :])


def _delimiter(mutant: Mutant, rng: random.Random) -> Mutant:
    other = rng.choice([sign for sign in (b",", b";", b"\t", b" ", b"") if sign != mutant.dialect.delimiter.encode()])
    return _in_row(mutant, rng, lambda line: line.replace(mutant.dialect.delimiter.encode(), other, 1))


def _decimal(mutant: Mutant, rng: random.Random) -> Mutant:
    here, other = (b".", b",") if mutant.dialect.decimal == "." else (b",", b".")
    return _in_row(mutant, rng, lambda line: line.replace(here, other, 1))


def _swap_names(mutant: Mutant, rng: random.Random) -> Mutant:
    lines = mutant.lines()
    sign = mutant.dialect.delimiter.encode()
    at = mutant.header_at()
    names = lines[at].split(sign)
    if len(names) > 1:
        one, other = rng.sample(range(len(names)), 2)
        names[one], names[other] = names[other], names[one]
    return mutant.with_lines([*lines[:at], sign.join(names), *lines[at + 1 :]])


def _swap_columns(mutant: Mutant, rng: random.Random) -> Mutant:
    sign = mutant.dialect.delimiter.encode()
    order = random.Random(rng.randrange(10**6)).sample(range(4), 4)
    swapped = []
    for line in mutant.lines():
        cells = line.split(sign)
        swapped.append(sign.join(cells[at] for at in order) if len(cells) == 4 else line)
    return mutant.with_lines(swapped)


def _unit(mutant: Mutant, rng: random.Random) -> Mutant:
    lines = mutant.lines()
    at = mutant.header_at()
    units = list(re.finditer(rb"\[[^\]]*\]", lines[at]))
    if not units:
        return mutant
    found = rng.choice(units)
    unit = rng.choice((b"[m]", b"[mm]", b"[cm]", b"[ms]", b"[s]", b"[us]", b"[N]", b"[]", b"", b"[furlong]"))
    changed = lines[at][: found.start()] + unit + lines[at][found.end() :]
    return mutant.with_lines([*lines[:at], changed, *lines[at + 1 :]])


def _cut(mutant: Mutant, rng: random.Random) -> Mutant:
    return replace(mutant, data=mutant.data[: rng.randrange(len(mutant.data) // 2, len(mutant.data))])


def _duplicate(mutant: Mutant, rng: random.Random) -> Mutant:
    lines = mutant.lines()
    at = _row(mutant, rng)
    return mutant.with_lines([*lines[:at], lines[min(at, len(lines) - 1)], *lines[at:]])


def _delete(mutant: Mutant, rng: random.Random) -> Mutant:
    lines = mutant.lines()
    at = _row(mutant, rng)
    return mutant.with_lines(lines[:at] + lines[at + rng.choice((1, 1, 2, 5)) :])


def _exchange(mutant: Mutant, rng: random.Random) -> Mutant:
    lines = mutant.lines()
    at = _row(mutant, rng)
    if at + 1 < len(lines):
        lines[at], lines[at + 1] = lines[at + 1], lines[at]
    return mutant.with_lines(lines)


def _header_again(mutant: Mutant, rng: random.Random) -> Mutant:
    lines = mutant.lines()
    at = _row(mutant, rng)
    return mutant.with_lines([*lines[:at], lines[mutant.header_at()], *lines[at:]])


def _header_reordered(mutant: Mutant, rng: random.Random) -> Mutant:
    lines = mutant.lines()
    at = _row(mutant, rng)
    tail = _swap_columns(mutant.with_lines([lines[mutant.header_at()], *lines[at:]]), rng)
    return replace(mutant, data=b"\n".join(lines[:at]) + b"\n" + tail.data)


def _nul(mutant: Mutant, rng: random.Random) -> Mutant:
    at, count = rng.randrange(len(mutant.data)), rng.choice((1, 3, 64, 512))
    if rng.random() < 0.5:  # lost sectors replace what was there
        return replace(mutant, data=mutant.data[:at] + bytes(count) + mutant.data[at + count :])
    return replace(mutant, data=mutant.data[:at] + bytes(count) + mutant.data[at:])


def _line_ends(mutant: Mutant, rng: random.Random) -> Mutant:
    end = rng.choice((b"\r\n", b"\r", b"\n\n"))
    if rng.random() < 0.5:
        return replace(mutant, data=mutant.data.replace(b"\n", end))
    lines = mutant.lines()
    at = _row(mutant, rng)
    return replace(mutant, data=b"\n".join(lines[:at]) + end + b"\n".join(lines[at:]))


def _quote(mutant: Mutant, rng: random.Random) -> Mutant:
    form = rng.choice((b'"%s"', b'"%s"', b'"%s', b'%s"', b'""%s'))
    return _cell(mutant, rng, lambda cell: form % cell)


def _word(mutant: Mutant, rng: random.Random) -> Mutant:
    words = (b"", b"nan", b"-", b"N/A", b"inf", b"-1.#INF", b"ERROR", b"0x10", b"1_0", b"1e5", b"+.5", b"5.", b"1e999")
    return _cell(mutant, rng, lambda _: rng.choice(words))


def _thousands(mutant: Mutant, rng: random.Random) -> Mutant:
    return _cell(mutant, rng, lambda cell: rng.choice((b"1'234.5", b"1 234", b"12,345.6", b"1.234,5")) + cell[:0])


def _rate_line(mutant: Mutant, rng: random.Random) -> Mutant:
    lines = (
        b"# rate: 300 Hz",
        b"# sampling rate: 1000 Hz",
        b"# rate 301 Hz",
        b"Frequency: 300.0 Hz",
        b"# baud rate 9600",
        b"# filter frequency 50 Hz",
    )
    return replace(mutant, data=rng.choice(lines) + b"\n" + mutant.data)


def _comment(mutant: Mutant, rng: random.Random) -> Mutant:
    lines = mutant.lines()
    at = rng.randrange(len(lines))
    return mutant.with_lines([*lines[:at], rng.choice((b"# foot changed", b"// 1,2,3", b"", b"   ")), *lines[at:]])


def _trailing(mutant: Mutant, rng: random.Random) -> Mutant:
    sign = mutant.dialect.delimiter.encode()
    if rng.random() < 0.5:
        return _in_row(mutant, rng, lambda line: line + sign)
    return mutant.with_lines([line + sign if line else line for line in mutant.lines()])


MUTATIONS: dict[str, Callable[[Mutant, random.Random], Mutant]] = {
    "digit": _digit,
    "any byte": _any_byte,
    "delimiter": _delimiter,
    "decimal sign": _decimal,
    "names swapped": _swap_names,
    "columns swapped": _swap_columns,
    "unit": _unit,
    "cut": _cut,
    "line twice": _duplicate,
    "lines deleted": _delete,
    "lines exchanged": _exchange,
    "header again": _header_again,
    "header reordered": _header_reordered,
    "NUL": _nul,
    "line ends": _line_ends,
    "quote": _quote,
    "word": _word,
    "thousands": _thousands,
    "rate line": _rate_line,
    "comment": _comment,
    "trailing delimiter": _trailing,
}
