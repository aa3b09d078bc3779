"""Robot and string-potentiometer logs: any delimited text with a header, or with columns named by a declaration.

Units and time come from the header, a profile or the command line (formats: known channels by name, others kept).
"""

from __future__ import annotations

from ingest.findings import FindingCollector
from ingest.formats.format import ANY_TEXT, Format, Recognition
from ingest.formats.head import Head
from ingest.instruments import Instrument
from ingest.model import Reading
from ingest.stacked import read_stacked
from ingest.text.source import HEAD_BYTES

_LOG = Instrument()


def _recognise(head: Head) -> Recognition | None:
    """Text of no other format."""
    source = head.source
    if source is None or not source.data[source.start : source.start + HEAD_BYTES].strip(b"\0\r\n\x1a \t"):
        return None
    return Recognition(ANY_TEXT, "text of no maker known here")


def _read(head: Head, findings: FindingCollector) -> Reading:
    return Reading() if head.source is None else read_stacked(head.source, head.declared, findings, _LOG)


FORMAT = Format("delimited_log", 6, _recognise, _read)
