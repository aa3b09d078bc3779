"""The page as PDF: what a browser on this machine prints, on A4, folds open."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from data_schema.disk import write_whole

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge")
"""Names under which Chromium and its kin are looked for."""

NO_BROWSER = (
    f"no PDF was made, for none of {', '.join(BROWSERS[:3])} is on this machine: install one, or print the page."
)

_PAPER = "@page { size: A4; @bottom-right { content: counter(page); font: 7pt sans-serif; color: #595959; }"
_SMALLER = "@media print {{ body {{ zoom: {}; }} .beside svg {{ max-height: 78mm; }} footer {{ margin: 0; }} }} "
_ZOOMS = ("", *map(_SMALLER.format, (0.9, 0.8, 0.7)))
_SHEET = re.compile(rb"/Type\s*/Page\b")
_SECONDS = 120.0
_QUIET = ("--headless", "--disable-gpu", "--disable-background-networking", "--disable-sync", "--no-first-run")


def browser() -> str | None:
    """Return the path of a browser that prints, None where there is none."""
    return next((path for name in BROWSERS if (path := shutil.which(name))), None)


def print_pdf(page: Path, pdf: Path, *, one_sheet: bool = False) -> str:
    """Print a page of a report to a PDF on A4; what it was before is replaced in one step.

    With `one_sheet` it is set smaller, down to seven tenths, where it needs more than one sheet otherwise.

    Returns "" where that was done, else the sentence that says why it was not.
    """
    path = browser()
    if path is None:
        return NO_BROWSER
    text, data = page.read_text(encoding="utf-8"), b""
    with tempfile.TemporaryDirectory(prefix="labbook-print-") as folder:
        for zoom in _ZOOMS if one_sheet else _ZOOMS[:1]:
            data, ended = _printed(path, Path(folder), text.replace("@page {", f"{zoom}{_PAPER}", 1))
            if not data.startswith(b"%PDF"):
                return f"no PDF was made, for {path} did not print the page ({ended}): print it from a browser."
            if len(_SHEET.findall(data)) == 1:
                break
    write_whole(pdf, data)
    return ""


def _printed(path: str, folder: Path, text: str) -> tuple[bytes, str]:
    """Return the PDF of a page's text, b"" where there is none, and how the browser ended."""
    page, printed = folder / "page.html", folder / "page.pdf"
    page.write_text(text, encoding="utf-8")
    rights = ["--no-sandbox"] if os.geteuid() == 0 else []  # Chromium refuses to run as root without it
    command = [path, *_QUIET, *rights, f"--user-data-dir={folder}/profile", "--no-pdf-header-footer"]
    try:
        done = subprocess.run(
            [*command, f"--print-to-pdf={printed}", page.as_uri()], capture_output=True, timeout=_SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return b"", f"it did not end within {_SECONDS:g} s"
    except OSError as error:
        return b"", str(error)
    return printed.read_bytes() if printed.is_file() else b"", f"it ended with {done.returncode}"
