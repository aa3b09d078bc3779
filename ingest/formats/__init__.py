"""All formats. The registry: a new format is a new file and a line here."""

from __future__ import annotations

from ingest.formats import archive
from ingest.formats.chargers import cheali, icharger, icharger_serial, logview, logview_zero, sheet
from ingest.formats.force_plates import (
    amti,
    amti_bsf,
    bertec,
    c3d,
    cortex,
    forcedecks,
    kistler,
    opensim,
    pasco,
    qualisys,
    vicon,
)
from ingest.formats.format import Format
from ingest.formats.loggers import debug_lines, delimited, excel, matlab, minitaur
from ingest.formats.recognised import RECOGNISED

FORMATS: tuple[Format, ...] = (
    *RECOGNISED,
    archive.ZIP,
    archive.GZIP,
    excel.XLSX,
    excel.XLS,
    matlab.FORMAT,
    icharger.FORMAT,
    icharger_serial.FORMAT,
    cheali.FORMAT,
    logview.FORMAT,
    logview_zero.FORMAT,
    minitaur.FORMAT,
    debug_lines.FORMAT,
    amti.FORMAT,
    amti_bsf.FORMAT,
    bertec.FORMAT,
    cortex.FORMAT,
    forcedecks.FORMAT,
    kistler.FORMAT,
    kistler.CHANNELS_FORMAT,
    opensim.FORMAT,
    pasco.FORMAT,
    qualisys.FORMAT,
    vicon.FORMAT,
    c3d.FORMAT,
    sheet.FORMAT,
    delimited.FORMAT,
)
