"""Labelled values, one sample a line: `h:0.32,v:15.4,t:0`, `body_height=0.447 m t=0 ms`, or a JSON object.

A column is a label, its unit the one behind the numbers; a line without a label has a missing value there, and
lines that follow each other with other labels at the same time are one row. A time of day before the first label is the
column `time`, a number there the column `1`, words there `prefix`, if `trials` names it.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from ingest.channels.names import is_unit
from ingest.formats.fixed_table import FixedHeader, fixed_table
from ingest.formats.format import LAYOUT, Format, Head
from ingest.instruments import Instrument
from ingest.model import FILE, NOTE, Declarations, FindingCollector, Reading
from ingest.signals import read_signals
from ingest.spool import LARGE_BYTES, mapped
from ingest.tables.table import read_preamble
from ingest.text import CLOCK_PATTERN, NUMBER_PATTERN, Line, TextSource, refuse_long_line

_LABEL = rb"[A-Za-z_][\w./%()\[\]-]*"
_VALUE = (
    rb'"[^"\r\n]*"|' + CLOCK_PATTERN + rb"|[+-]?\d+,\d+(?=[^\s,;|:=\"\d]*(?:[\s;|]|$|,\D))|[^\s,;|:=\"]+"  # 0,32;15,4
)
_PAIR = re.compile(
    rb"(?<![\w.])(" + _LABEL + rb"(?: +" + _LABEL + rb")*)\s*[:=]\s*(" + _VALUE + rb")(?=[\s,;|]|$)", re.ASCII
)
_QUANTITY = re.compile(rb"(" + NUMBER_PATTERN + rb"|[+-]?\d+,\d+)[ \t]*(\S*)")
_CLOCK = re.compile(CLOCK_PATTERN)
_NUMBER = re.compile(rb"(?<![\w.])" + NUMBER_PATTERN + rb"(?![\w.])")
_BETWEEN = b" \t\r,;|"
_DELIMITER = b"\t"
_PREFIX, _STAMP, _FIRST = b"prefix", b"time", b"1"
_FEWEST_LINES = 2


class _Pair(NamedTuple):
    """A label, the text of its value and the unit behind it."""

    label: bytes
    value: bytes
    unit: bytes = b""


def _recognise(head: Head) -> str | None:
    """Lines of several `label: value` or `label=value`, or of JSON objects."""
    lines = _sample(head.text)
    rows = [row for row in map(_pairs, lines) if _is_sample(row)]
    labels = Counter(pair.label for row in rows for pair in row)
    if len(rows) < _FEWEST_LINES or 2 * len(rows) <= len(lines) or 2 * max(labels.values()) < len(rows):
        return None
    return f"{len(rows)} of {len(lines)} lines seen are labelled values"


def _sample(source: TextSource) -> list[bytes]:
    found = [*source.head_lines(60), *source.sample_lines(0.5)]
    return list({line.start: line.content for line in found if line.content.strip()}.values())


def _is_sample(row: Sequence[_Pair]) -> bool:
    values = [pair for pair in row if pair.label != _PREFIX]
    return len(values) > 1 and any(_QUANTITY.fullmatch(pair.value) for pair in values)


def _pairs(content: bytes) -> list[_Pair]:
    """Return the labelled values of a line; none where it holds anything else beside them."""
    if content.lstrip(b" \t[")[:1] == b"{":
        return _of_json(content)
    found = list(_PAIR.finditer(content))
    if not found:
        return []
    pairs = _before(content[: found[0].start()])
    for pair, following in zip(found, [*found[1:], None], strict=True):
        label = pair[1]
        behind = content[pair.end() : following.start() if following else len(content)].strip(_BETWEEN)
        words = label.split()
        if (
            len(words) > 1
            and pairs
            and not pairs[-1].unit
            and _is_unit(words[0])
            and _QUANTITY.fullmatch(pairs[-1].value)
        ):
            pairs[-1] = pairs[-1]._replace(unit=words[0])
            label = label[len(words[0]) :].strip()
        quantity = _QUANTITY.fullmatch(b" ".join(filter(None, (pair[2], behind))))
        if quantity is not None and (not quantity[2] or _is_unit(quantity[2])):
            pairs.append(_Pair(label, quantity[1], quantity[2]))
        elif not behind:
            pairs.append(_Pair(label, pair[2].strip(b'"')))
        else:
            return []
    return pairs


def _before(prefix: bytes) -> list[_Pair]:
    """Return what stands before the first label: a time of day or a number, and words."""
    clock, number = _CLOCK.search(prefix), _NUMBER.search(prefix)
    pairs = [_Pair(_STAMP, clock[0])] if clock else [_Pair(_FIRST, number[0])] if number else []
    words = b" ".join(re.findall(rb"[^\W\d]+", prefix if clock is None else prefix.replace(clock[0], b"")))
    return [*pairs, _Pair(_PREFIX, words)] if words else pairs


@functools.lru_cache(maxsize=1000)
def _is_unit(text: bytes) -> bool:
    return is_unit(text.decode("utf-8", errors="replace"))


def _of_json(content: bytes) -> list[_Pair]:
    try:
        found = json.loads(content.strip(b" \t\r,[]"), parse_float=str, parse_int=str, parse_constant=str)
    except (ValueError, RecursionError):
        return []
    return list(_flat("", found)) if isinstance(found, dict) else []


def _flat(path: str, value: Any) -> Iterator[_Pair]:
    """Yield the values in an object of JSON, the labels of what is nested in it joined by points."""
    if isinstance(value, dict | list):
        members = value.items() if isinstance(value, dict) else enumerate(value, start=1)
        for name, member in members:
            yield from _flat(f"{path}.{name}" if path else str(name), member)
    else:
        text = "" if value is None else str(int(value)) if isinstance(value, bool) else str(value)
        yield _Pair(path.encode(), " ".join(text.replace('"', "'").split()).encode())


def _read(head: Head, findings: FindingCollector) -> Reading:
    source = head.text
    if refuse_long_line(source, findings):
        return Reading()
    if mapped(source.data) is not None:
        message = f"Labelled values are read in files of at most {LARGE_BYTES >> 20} MiB: split the file."
        findings.add(FILE, "labelled_too_large", message)
        return Reading()
    rows = [row for row in map(_pairs, _sample(source)) if _is_sample(row)]
    units = _units(rows)
    if head.declared.trials != _PREFIX.decode():
        units.pop(_PREFIX, None)
        _refuse_prefixes(rows, findings)
    table_source, first = _as_table(source, units, findings)
    if first is None:
        return Reading()
    above = [source.decode(line.content) for line in source.head_lines() if line.number < first.number]
    names = [label.decode("utf-8", errors="replace") for label in units]
    header = FixedHeader(
        names,
        _DELIMITER,
        first,
        [unit.decode("utf-8", errors="replace") or None for unit in units.values()],
        preamble=read_preamble((*source.comments, *above)),
    )
    table = fixed_table(table_source, header, _whole(rows, source, head.declared), findings)
    if table is None or table.text is None:
        return Reading()
    table = dataclasses.replace(table, text=dataclasses.replace(table.text, delimiter=""))
    return read_signals(table, head.declared, findings, Instrument())


def _units(rows: Sequence[Sequence[_Pair]]) -> dict[bytes, bytes]:
    """Return the unit that most values of each label bear, by label in the order of the lines."""
    found: dict[bytes, Counter[bytes]] = {}
    for row in rows:
        for pair in row:
            found.setdefault(pair.label, Counter())[pair.unit] += 1
    if 2 * found.get(_FIRST, Counter()).total() <= len(rows):
        found.pop(_FIRST, None)  # the end of a number that a line end has cut
    return {label: units.most_common(1)[0][0] for label, units in found.items()}


def _refuse_prefixes(rows: Iterable[Sequence[_Pair]], findings: FindingCollector) -> None:
    """Refuse a file where different words stand before equal labels: they may be those of two things."""
    prefixes: dict[bytes, set[bytes]] = {}
    for row in rows:
        words = next((pair.value for pair in row if pair.label == _PREFIX), b"")
        for pair in row:
            if pair.label not in (_PREFIX, _STAMP, _FIRST):
                prefixes.setdefault(pair.label, set()).add(words)
    most = max(prefixes.values(), key=len)
    if len(most) > 1:
        listed = " and ".join(repr(each.decode("utf-8", errors="replace")) for each in sorted(most)[:3])
        message = (
            f'Lines with the same labels begin with different words, {listed}: say `trials = "prefix"` in a '
            "[profiles.NAME] table of labbook.toml, and those of each become a part of their own."
        )
        findings.add(FILE, "prefixes_differ", message)


def _as_table(
    source: TextSource, units: dict[bytes, bytes], findings: FindingCollector
) -> tuple[TextSource, Line | None]:
    """Return the text with a cell for each label instead of its lines, which keep their numbers, and its first row.

    A line that holds a label and cannot be read is one of too many cells. So is the one before a line that begins as a
    number which no other line has there: a line end inside a number has cut it.
    """
    data = bytes(source.data[source.start :])
    done: list[bytes] = []
    rows: list[int] = []
    before: dict[bytes, bytes] = {}
    for number, content in enumerate(data.splitlines(), start=source.first_line):
        pairs = _pairs(content)
        begins = pairs[0].label if pairs else _FIRST if _NUMBER.match(content.lstrip()) else b""
        if begins == _FIRST and _FIRST not in units and rows:
            done[rows[-1]], before = _broken(done[rows[-1]], len(units)), {}
        values = _values(pairs, units)
        known = any(pair[1] in units for pair in _PAIR.finditer(content)) or content.lstrip()[:1] == b"{"
        if values is None and not known:
            if content.strip(b" \t\r\0\x1a[]"):
                message = "Lines without labelled values are skipped and stay in the raw copy only."
                findings.add(NOTE, "debug_line", message, lines=[number])
            done.append(b"")
            continue
        if values is not None and _complete(before, values):
            before |= values
            done[rows[-1]] = _row(before, units)
            done.append(b"")
        else:
            rows.append(len(done))
            done.append(_broken(content, len(units)) if values is None else _row(values, units))
            before = values or {}
        further = [pair.label for pair in pairs if pair.label not in units and pair.label != _PREFIX]
        if further:
            message = (
                "Labels that none of the lines looked at first has are left out: their values stay in the raw copy."
            )
            findings.add(NOTE, "label_unknown", message, lines=[number], value=source.decode(further[0]))
    text = b"\n".join(done) + (b"\n" if data[-1:] in (b"\r", b"\n") else b"")
    table = dataclasses.replace(source, data=text, start=0)
    if not rows:
        return table, None
    start = sum(len(line) + 1 for line in done[: rows[0]])
    return table, Line(source.first_line + rows[0], start, done[rows[0]], len(done) > rows[0] + 1)


def _values(pairs: Sequence[_Pair], units: dict[bytes, bytes]) -> dict[bytes, bytes] | None:
    """Return the values by label; None where a line has none of the labels, one twice, or a number in another unit."""
    values = {pair.label: b" ".join(pair.value.split()) for pair in pairs}
    if len(values) < len(pairs) or not values.keys() - {_PREFIX, _STAMP, _FIRST} & units.keys():
        return None
    if any(pair.unit != units.get(pair.label, pair.unit) and _QUANTITY.fullmatch(pair.value) for pair in pairs):
        return None
    return {label: value for label, value in values.items() if label in units}


def _complete(before: dict[bytes, bytes], values: dict[bytes, bytes]) -> bool:
    """Whether two lines have labels of their own and agree in those that both have."""
    shared = before.keys() & values.keys()
    own = before.keys() - shared and values.keys() - shared
    return bool(shared and own) and all(before[label] == values[label] for label in shared)


def _row(values: dict[bytes, bytes], units: dict[bytes, bytes]) -> bytes:
    return _DELIMITER.join(values.get(label, b"") for label in units)


def _broken(content: bytes, width: int) -> bytes:
    """Return a line as one that no row of the table looks like."""
    return b"? " + b" ".join(content.split()) + _DELIMITER * (width + 1)


def _whole(rows: Sequence[Sequence[_Pair]], source: TextSource, declared: Declarations) -> Declarations:
    """Return the declarations, a last line declared whole where a brace or a unit ends each."""
    ends = all(row[-1].unit for row in rows) or source.data.rstrip().endswith((b"}", b"]"))
    return dataclasses.replace(declared, complete=True) if ends else declared


FORMAT = Format("labelled_values", 3, _recognise, _read, clues=(b":", b"="), score=LAYOUT)
