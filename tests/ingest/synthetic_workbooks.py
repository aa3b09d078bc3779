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


def _zipped(files: dict[str, str]) -> bytes:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content, zipfile.ZIP_STORED if name == "mimetype" else None)
    return target.getvalue()


def _relations(targets: dict[str, tuple[str, str]]) -> str:
    related = "".join(
        f'<Relationship Id="{name}" Type="{RELATIONS}/{kind}" Target="{target}"/>'
        for name, (kind, target) in targets.items()
    )
    return f'<Relationships xmlns="{PACKAGE}">{related}</Relationships>'


def workbook(sheets: dict[str, Rows], dates: bool = False, raw: str = "") -> bytes:
    names = dict(enumerate(sheets, start=1))
    listed = "".join(f'<sheet name="{name}" sheetId="{n}" r:id="rId{n}"/>' for n, name in names.items())
    own = {f"rId{n}": ("worksheet", f"worksheets/sheet{n}.xml") for n in names}
    styles = '<cellXfs count="2"><xf numFmtId="0"/><xf numFmtId="22"/></cellXfs>'
    default = '<Default Extension="xml" ContentType="application/xml"/>'
    return _zipped(
        {
            "[Content_Types].xml": f'<Types xmlns="{TYPES}">{default}</Types>',
            "_rels/.rels": _relations({"rId1": ("officeDocument", "xl/workbook.xml")}),
            "xl/workbook.xml": f'<workbook xmlns="{MAIN}" xmlns:r="{RELATIONS}"><sheets>{listed}</sheets></workbook>',
            "xl/styles.xml": f'<styleSheet xmlns="{MAIN}">{styles}</styleSheet>',
            "xl/_rels/workbook.xml.rels": _relations({**own, "rIdS": ("styles", "styles.xml")}),
            **{f"xl/worksheets/sheet{n}.xml": raw or sheet_xml(sheets[name], dates) for n, name in names.items()},
        }
    )


OFFICE = "urn:oasis:names:tc:opendocument:xmlns"
SPREADSHEET = "application/vnd.oasis.opendocument.spreadsheet"


def ods(sheets: dict[str, Rows], raw: str = "") -> bytes:
    """Return an OpenDocument spreadsheet; `raw` replaces the rows of each sheet."""
    manifest = f'xmlns:manifest="{OFFICE}:manifest:1.0"'
    entry = f'<manifest:file-entry manifest:full-path="/" manifest:media-type="{SPREADSHEET}"/>'
    tables = "".join(
        f'<table:table table:name="{name}">{raw or "".join(map(_ods_row, rows))}</table:table>'
        for name, rows in sheets.items()
    )
    spaces = "".join(f' xmlns:{space}="{OFFICE}:{space}:1.0"' for space in ("office", "table", "text"))
    body = f"<office:body><office:spreadsheet>{tables}</office:spreadsheet></office:body>"
    return _zipped(
        {
            "mimetype": SPREADSHEET,
            "META-INF/manifest.xml": f"<manifest:manifest {manifest}>{entry}</manifest:manifest>",
            "content.xml": f'<?xml version="1.0" encoding="UTF-8"?><office:document-content{spaces}>{body}'
            "</office:document-content>",
        }
    )


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
