"""Robot and string-potentiometer logs: any delimited text with a header, or with columns named by a declaration.

Units and time come from the header, a profile or the command line (formats: known channels by name, others kept).
"""

from __future__ import annotations

from ingest.findings import FindingCollector
from ingest.formats.format import Format
from ingest.model import Reading
from ingest.signals import Instrument, read_signals
from ingest.sniff import Head
from ingest.text import HEAD_BYTES

_LOG = Instrument()


def _recognise(head: Head) -> bool:
    source = head.source
    return source is not None and bool(source.data[source.start : source.start + HEAD_BYTES].strip(b"\0\r\n\x1a \t"))


def _read(head: Head, findings: FindingCollector) -> Reading:
    return Reading() if head.source is None else read_signals(head.source, head.declared, findings, _LOG)


FORMAT = Format("delimited_log", 4, _recognise, _read)
