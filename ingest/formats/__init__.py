"""All formats, in the order in which they are tried: signatures first, any delimited text last."""

from __future__ import annotations

from ingest.formats import bertec_text, charger_sheet, delimited_log, icharger_log
from ingest.formats.format import Format
from ingest.formats.recognised import RECOGNISED

FORMATS: tuple[Format, ...] = (
    *RECOGNISED,
    icharger_log.FORMAT,
    bertec_text.FORMAT,
    charger_sheet.FORMAT,
    delimited_log.FORMAT,
)
"""The registry: a new format is a new file and a line here."""
