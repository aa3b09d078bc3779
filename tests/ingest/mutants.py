"""Random mutants of good logs: what a careless hand, another program or a bad card does to a file.

A mutation changes the bytes and, where it changes how the whole file is written, the dialect; the second parser then
says what the file tells. All files are synthetic.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from tests.ingest.second_parser import Dialect
from tests.ingest.synthetic import LOG_HEADER, robot_rows, text


@dataclass(frozen=True)
class Mutant:
    """A file, how it is written, and the mutations that made it."""

    data: bytes
    dialect: Dialect
    made_by: tuple[str, ...] = ()

    @property
    def sign(self) -> bytes:
        return self.dialect.delimiter.encode()

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


def mutated(mutant: Mutant, rng: random.Random, names: Sequence[str]) -> Mutant:
    """Return a file with one to three of these mutations."""
    for name in rng.choices(names, k=rng.choice((1, 1, 2, 3))):
        mutant = replace(MUTATIONS[name](mutant, rng), made_by=(*mutant.made_by, name))
    return mutant


def make_mutant(seed: int) -> Mutant:
    """Return the mutant of that number of a good log."""
    rng = random.Random(seed)
    mutant = mutated(base(rng), rng, list(MUTATIONS))
    if rng.random() < 0.1:
        return replace(mutant, data=b"\xef\xbb\xbf" + mutant.data, made_by=(*mutant.made_by, "byte order mark"))
    return mutant


def _row(mutant: Mutant, rng: random.Random) -> int:
    return rng.randrange(1, max(2, len(mutant.lines()) - 1))


def _in_row(mutant: Mutant, rng: random.Random, change: Callable[[bytes], bytes]) -> Mutant:
    lines, at = mutant.lines(), _row(mutant, rng)
    lines[at : at + 1] = [change(lines[at])] if at < len(lines) else []
    return mutant.with_lines(lines)


def _above(mutant: Mutant, at: int, *lines: bytes) -> Mutant:
    """Put lines above a line."""
    return mutant.with_lines([*mutant.lines()[:at], *lines, *mutant.lines()[at:]])


def _header(mutant: Mutant, change: Callable[[bytes], bytes]) -> Mutant:
    lines, at = mutant.lines(), mutant.header_at()
    return mutant.with_lines([*lines[:at], change(lines[at]), *lines[at + 1 :]])


def _cell(mutant: Mutant, rng: random.Random, change: Callable[[bytes], bytes]) -> Mutant:
    sign = mutant.sign

    def in_cells(line: bytes) -> bytes:
        cells = line.split(sign)
        at = rng.randrange(len(cells))
        cells[at] = change(cells[at])
        return sign.join(cells)

    return _in_row(mutant, rng, in_cells)


def _digit(mutant: Mutant, rng: random.Random) -> Mutant:
    at = rng.choice([found.start() for found in re.finditer(rb"\d", mutant.data)])
    return replace(mutant, data=mutant.data[:at] + str(rng.randrange(10)).encode() + mutant.data[at + 1 :])


def _any_byte(mutant: Mutant, rng: random.Random) -> Mutant:
    at = rng.randrange(len(mutant.data))
    return replace(mutant, data=mutant.data[:at] + bytes([rng.randrange(1, 128)]) + mutant.data[at + 1 :])


def _delimiter(mutant: Mutant, rng: random.Random) -> Mutant:
    other = rng.choice([sign for sign in (b",", b";", b"\t", b" ", b"") if sign != mutant.sign])
    return _in_row(mutant, rng, lambda line: line.replace(mutant.sign, other, 1))


def _decimal(mutant: Mutant, rng: random.Random) -> Mutant:
    here, other = (b".", b",") if mutant.dialect.decimal == "." else (b",", b".")
    return _in_row(mutant, rng, lambda line: line.replace(here, other, 1))


def _swap_names(mutant: Mutant, rng: random.Random) -> Mutant:
    sign = mutant.sign

    def swapped(header: bytes) -> bytes:
        names = header.split(sign)
        if len(names) > 1:
            one, other = rng.sample(range(len(names)), 2)
            names[one], names[other] = names[other], names[one]
        return sign.join(names)

    return _header(mutant, swapped)


def _swap_columns(mutant: Mutant, rng: random.Random) -> Mutant:
    sign = mutant.sign
    order = random.Random(rng.randrange(10**6)).sample(range(4), 4)
    swapped = []
    for line in mutant.lines():
        cells = line.split(sign)
        swapped.append(sign.join(cells[at] for at in order) if len(cells) == 4 else line)
    return mutant.with_lines(swapped)


def _unit(mutant: Mutant, rng: random.Random) -> Mutant:
    def changed(header: bytes) -> bytes:
        units = list(re.finditer(rb"\[[^\]]*\]", header))
        if not units:
            return header
        found = rng.choice(units)
        unit = rng.choice((b"[m]", b"[mm]", b"[cm]", b"[ms]", b"[s]", b"[us]", b"[N]", b"[]", b"", b"[furlong]"))
        return header[: found.start()] + unit + header[found.end() :]

    return _header(mutant, changed)


def _cut(mutant: Mutant, rng: random.Random) -> Mutant:
    return replace(mutant, data=mutant.data[: rng.randrange(len(mutant.data) // 2, len(mutant.data))])


def _duplicate(mutant: Mutant, rng: random.Random) -> Mutant:
    at, lines = _row(mutant, rng), mutant.lines()
    return _above(mutant, at, lines[min(at, len(lines) - 1)])


def _delete(mutant: Mutant, rng: random.Random) -> Mutant:
    lines, at = mutant.lines(), _row(mutant, rng)
    return mutant.with_lines(lines[:at] + lines[at + rng.choice((1, 1, 2, 5)) :])


def _exchange(mutant: Mutant, rng: random.Random) -> Mutant:
    lines, at = mutant.lines(), _row(mutant, rng)
    if at + 1 < len(lines):
        lines[at], lines[at + 1] = lines[at + 1], lines[at]
    return mutant.with_lines(lines)


def _header_again(mutant: Mutant, rng: random.Random) -> Mutant:
    return _above(mutant, _row(mutant, rng), mutant.lines()[mutant.header_at()])


def _header_reordered(mutant: Mutant, rng: random.Random) -> Mutant:
    lines, at = mutant.lines(), _row(mutant, rng)
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
    lines, at = mutant.lines(), _row(mutant, rng)
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
    rates = (b"# rate: 300 Hz", b"# sampling rate: 1000 Hz", b"# rate 301 Hz", b"Frequency: 300.0 Hz")
    line = rng.choice((*rates, b"# baud rate 9600", b"# filter frequency 50 Hz"))
    return _above(mutant, 0, line)


def _comment(mutant: Mutant, rng: random.Random) -> Mutant:
    at = rng.randrange(len(mutant.lines()))
    return _above(mutant, at, rng.choice((b"# foot changed", b"// 1,2,3", b"", b"   ")))


def _trailing(mutant: Mutant, rng: random.Random) -> Mutant:
    sign = mutant.sign
    if rng.random() < 0.5:
        return _in_row(mutant, rng, lambda line: line + sign)
    return mutant.with_lines([line + sign if line else line for line in mutant.lines()])


MUTATIONS: dict[str, Callable[[Mutant, random.Random], Mutant]] = {
    each.__name__.strip("_"): each
    for each in (
        *(_digit, _any_byte, _delimiter, _decimal, _swap_names, _swap_columns, _unit, _cut, _duplicate, _delete),
        *(_exchange, _header_again, _header_reordered, _nul, _line_ends, _quote, _word, _thousands, _rate_line),
        *(_comment, _trailing),
    )
}
