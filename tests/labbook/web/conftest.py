"""A browser for the page, and what every test of it asks of its pages."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, copy_of, small_book

_BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
NARROW = {"width": 400, "height": 800}
WIDE = {"width": 1280, "height": 860}


@pytest.fixture
def reported(tmp_path: Path) -> SmallBook:
    """The finished book with its report, written."""

    def made(above: Path) -> SmallBook:
        book = small_book(above)
        good(labbook("report", at=book.folder))
        return book

    return copy_of("small-book-report-written", made, tmp_path)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium, or the test is skipped."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: the page is not driven")
    if _BROWSER is None:
        pytest.skip("Chromium is not installed: the page is not driven")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=_BROWSER, args=["--no-sandbox"])
        yield started
        started.close()


@pytest.fixture
def page(browser: Any) -> Iterator[Any]:
    """A page that fails the test for an error of its scripts, or a request to elsewhere."""
    context = browser.new_context(viewport=WIDE)
    made = context.new_page()
    wrong: list[str] = []
    made.on("pageerror", lambda error: wrong.append(str(error)))
    made.on("request", lambda request: wrong.append(request.url) if "127.0.0.1" not in request.url else None)
    made.on("console", lambda message: wrong.append(message.text) if "Content Security" in message.text else None)
    yield made
    context.close()
    assert wrong == []
