"""Take the pictures of docs/web.md: python scripts/web_pictures.py BOOK serves the book and looks at it.

The demonstration's book is the one to take (`make demo`); needs playwright and Chromium.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

DOCUMENTS = Path(__file__).resolve().parents[1] / "docs" / "web"
VIEWS = {"runs": "/", "attention": "/attention", "run": "/runs/r002", "review": "/review?run=r006", "live": "/live",
         "diff": "/diff?first=r002&second=r003",
         "files": "/files", "reports": "/reports", "journal": "/journal"}  # fmt: skip
SIZES = {"": (1280, 800, "light"), "_narrow_dark": (400, 800, "dark")}


def main(book: str) -> None:
    """Take every view in both sizes."""
    command = [
        Path(sys.executable).with_name("labbook"),
        "web",
        "--json",
        "--no-browser",
        "--book",
        book,
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server, sync_playwright() as playwright:
        assert server.stdout is not None  # noqa: S101
        url = json.loads(server.stdout.readline())["url"]
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        for ending, (width, height, scheme) in SIZES.items():
            context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
            page = context.new_page()
            page.goto(url)
            for name, path in VIEWS.items():
                page.goto(url.partition("/?")[0] + path)
                page.wait_for_timeout(1500)
                page.screenshot(path=DOCUMENTS / f"{name}{ending}.png")
            context.close()
        browser.close()
        server.terminate()


if __name__ == "__main__":
    main(sys.argv[1])
