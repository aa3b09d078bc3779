"""Bad bytes: marks, encodings, line ends, lost sectors, archives, truncation; all files are synthetic."""

from __future__ import annotations

import gzip
import io
import zipfile

import pytest

from tests.ingest.bad_input import LOG, ROWS, Case, check, with_row, with_times
from tests.ingest.synthetic import LOG_HEADER


def zipped(members: dict[str, bytes]) -> bytes:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return target.getvalue()


BYTES = [
    Case("0 bytes", b"", True, "file_empty"),
    Case("only a byte order mark", b"\xef\xbb\xbf", True, "file_empty"),
    Case("only a UTF-16 mark", b"\xff\xfe", True, "file_empty"),
    Case("only blank lines", b"\n\n\r\n", True, "file_empty"),
    Case("only NULs", b"\0" * 2048, True, "file_empty nul_padding"),
    Case("only the header", f"{LOG_HEADER}\n".encode(), True, "no_data_rows"),
    Case("header without line end", LOG_HEADER.encode(), True, "no_data_rows"),
    Case("UTF-8 with mark", b"\xef\xbb\xbf" + LOG, False, "", 600),
    Case("UTF-16 LE", b"\xff\xfe" + LOG.decode().encode("utf-16-le"), False, "encoding_utf16", 600),
    Case("UTF-16 BE", b"\xfe\xff" + LOG.decode().encode("utf-16-be"), False, "encoding_utf16", 600),
    Case("UTF-16 without mark", LOG.decode().encode("utf-16-le"), True, "format_unknown"),
    Case("cp1252 degree sign", LOG.replace(b"k_gain", b"temp [\xb0C]"), False, "encoding_declared", 600),
    Case(
        "cp1252 mu in the time's unit",
        with_times(lambda _, t: 1000 * t, "time [\u00b5s]").decode().encode("cp1252"),
        False,
        "encoding_declared",
        600,
    ),
    Case("NUL in the header", LOG.replace(b"k_gain", b"k_gain\0", 1), False, "", 600),
    Case("NUL run of a lost sector", LOG[:9000] + b"\0" * 512 + LOG[9512:], False, "nul_bytes packets_dropped", 580),
    Case("NULs at the end", LOG + b"\0" * 4096, False, "nul_padding", 600),
    Case("Ctrl-Z at the end", LOG + b"\x1a", False, "ctrl_z", 600),
    Case("Ctrl-Z line inside", with_row(ROWS[50] + "\n\x1a"), False, "ctrl_z", 600),
    Case("CRLF", LOG.replace(b"\n", b"\r\n"), False, "", 600),
    Case("CR alone", LOG.replace(b"\n", b"\r"), False, "line_ends_cr", 600),
    Case("mixed line ends", LOG.replace(b"\n", b"\r\n", 5), False, "", 600),
    Case("no final newline", LOG[:-1], False, "no_final_newline", 600),
    Case("last line cut in a cell", LOG[:-3], False, "last_line_cut", 599),
    Case("last line cut between cells", LOG[:-15], False, "last_line_cut", 599),
    Case("gzip", gzip.compress(LOG), False, "", 600),
    Case("gzip with a bad checksum", gzip.compress(LOG)[:-8] + bytes(8), True, "archive_refused", 0),
    Case("gzip bomb", gzip.compress(bytes(10_000_000)), True, "archive_refused", 0),
    Case("zip with a path upwards", zipped({"../../log.csv": LOG}), True, "archive_refused", 0),
    Case("zip in a zip", zipped({"inner.zip": zipped({"log.csv": LOG})}), False, "member_read", 600),
    Case("one line of 50 MB", b"1," * 25_000_000, True, "line_too_long", 0),
    Case("a line of 2 MB inside", with_row("1," * 1_000_000), False, "line_too_long", 599),
    Case("100 000 columns", (",".join(map(str, range(100_000))) + "\n").encode() * 3, True, "too_many_columns"),
    Case("a name of 100 kB of brackets", LOG.replace(b"k_gain", b"[(" * 50_000), False, "", 600),
]


@pytest.mark.parametrize("case", BYTES, ids=lambda case: case.name)
def test_bad_bytes_have_their_outcome(case: Case) -> None:
    check(case)
