"""Workbooks as Excel and LibreOffice write them, as small as they can be."""

from __future__ import annotations

import datetime
import io
import zipfile
from xml.sax.saxutils import escape

MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
RELATIONS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
TYPES = "http://schemas.openxmlformats.org/package/2006/content-types"
PACKAGE = "http://schemas.openxmlformats.org/package/2006/relationships"

Rows = list[list[object]]


def column(number: int) -> str:
    letters = ""
    while number:
        number, rest = divmod(number - 1, 26)
        letters = chr(65 + rest) + letters
    return letters


def sheet_xml(rows: Rows, dates: bool = False) -> str:
    lines = []
    for number, row in enumerate(rows, start=1):
        cells = []
        for at, cell in enumerate(row, start=1):
            place = f'r="{column(at)}{number}"'
            if isinstance(cell, str) and cell:
                cells.append(f'<c {place} t="inlineStr"><is><t>{escape(cell)}</t></is></c>')
            elif isinstance(cell, datetime.datetime):
                serial = (cell - datetime.datetime(1899, 12, 30, tzinfo=cell.tzinfo)) / datetime.timedelta(days=1)
                cells.append(f'<c {place} s="1"><v>{serial!r}</v></c>')
            elif cell != "":
                style = ' s="1"' if dates and at == 1 else ""
                cells.append(f"<c {place}{style}><v>{cell!r}</v></c>")
        lines.append(f'<row r="{number}">{"".join(cells)}</row>')
    return f'<worksheet xmlns="{MAIN}"><sheetData>{"".join(lines)}</sheetData></worksheet>'


def workbook(sheets: dict[str, Rows], dates: bool = False, raw: str = "") -> bytes:
    target = io.BytesIO()
    names = list(sheets)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(
            "[Content_Types].xml",
            f'<Types xmlns="{TYPES}"><Default Extension="xml" ContentType="application/xml"/></Types>',
        )
        archive.writestr(
            "_rels/.rels",
            f'<Relationships xmlns="{PACKAGE}"><Relationship Id="rId1" Type="{RELATIONS}/officeDocument" '
            'Target="xl/workbook.xml"/></Relationships>',
        )
        listed = "".join(f'<sheet name="{name}" sheetId="{n}" r:id="rId{n}"/>' for n, name in enumerate(names, 1))
        archive.writestr(
            "xl/workbook.xml",
            f'<workbook xmlns="{MAIN}" xmlns:r="{RELATIONS}"><sheets>{listed}</sheets></workbook>',
        )
        related = "".join(
            f'<Relationship Id="rId{n}" Type="{RELATIONS}/worksheet" Target="worksheets/sheet{n}.xml"/>'
            for n in range(1, len(names) + 1)
        )
        archive.writestr(
            "xl/styles.xml",
            f'<styleSheet xmlns="{MAIN}"><cellXfs count="2"><xf numFmtId="0"/><xf numFmtId="22"/></cellXfs>'
            "</styleSheet>",
        )
        related += f'<Relationship Id="rIdS" Type="{RELATIONS}/styles" Target="styles.xml"/>'
        archive.writestr("xl/_rels/workbook.xml.rels", f'<Relationships xmlns="{PACKAGE}">{related}</Relationships>')
        for n, name in enumerate(names, start=1):
            archive.writestr(f"xl/worksheets/sheet{n}.xml", raw or sheet_xml(sheets[name], dates))
    return target.getvalue()


OFFICE = "urn:oasis:names:tc:opendocument:xmlns"


def ods(sheets: dict[str, Rows], raw: str = "") -> bytes:
    """Return an OpenDocument spreadsheet; `raw` replaces the rows of each sheet."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet", zipfile.ZIP_STORED)
        archive.writestr(
            "META-INF/manifest.xml",
            f'<manifest:manifest xmlns:manifest="{OFFICE}:manifest:1.0"><manifest:file-entry manifest:full-path="/" '
            'manifest:media-type="application/vnd.oasis.opendocument.spreadsheet"/></manifest:manifest>',
        )
        tables = "".join(
            f'<table:table table:name="{name}">{raw or "".join(map(_ods_row, rows))}</table:table>'
            for name, rows in sheets.items()
        )
        spaces = "".join(f' xmlns:{space}="{OFFICE}:{space}:1.0"' for space in ("office", "table", "text"))
        archive.writestr(
            "content.xml",
            f'<?xml version="1.0" encoding="UTF-8"?><office:document-content{spaces}><office:body><office:spreadsheet>'
            f"{tables}</office:spreadsheet></office:body></office:document-content>",
        )
    return target.getvalue()


def _ods_row(row: list[object]) -> str:
    return f"<table:table-row>{''.join(map(_ods_cell, row))}</table:table-row>"


def _ods_cell(cell: object) -> str:
    if cell == "":
        return "<table:table-cell/>"
    if isinstance(cell, str):
        lines = "".join(f"<text:p>{escape(line)}</text:p>" for line in cell.splitlines())
        return f'<table:table-cell office:value-type="string">{lines}</table:table-cell>'
    if isinstance(cell, datetime.datetime):
        written = f'date" office:date-value="{cell.date().isoformat()}'
        return f'<table:table-cell office:value-type="{written}"><text:p>{cell}</text:p></table:table-cell>'
    value = f'<table:table-cell office:value-type="float" office:value="{cell}"><text:p>{cell}</text:p>'
    return f"{value}</table:table-cell>"
