"""Every view in a browser: nothing runs off the window, everybody can read it, and its script has no error."""

from __future__ import annotations

from typing import Any

import pytest

from tests.cli.shell import labbook
from tests.helpers.books import ADA, SmallBook
from tests.helpers.web import served, until
from tests.labbook.web.conftest import NARROW, WIDE

VIEWS = ("/", "/attention", "/runs/r003", "/diff?first=r001&second=r003", "/review", "/live", "/files", "/reports",
         "/journal")  # fmt: skip


@pytest.mark.parametrize("path", VIEWS)
def test_nothing_runs_off_the_window_and_everybody_can_read_it(browser: Any, reported: SmallBook, path: str) -> None:
    from axe_core_python.sync_playwright import Axe

    context = browser.new_context(bypass_csp=True)  # for what looks at the page, which is no script of its own
    page = context.new_page()
    with served(reported.folder, "--as", ADA) as server:
        for size, scheme in ((WIDE, "light"), (NARROW, "dark")):
            page.set_viewport_size(size)
            page.emulate_media(color_scheme=scheme)
            page.goto(server.url)
            page.goto(server.base + path)
            page.wait_for_timeout(500)
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
            found = Axe().run(page, options={"resultTypes": ["violations"]})
            assert [one["id"] for one in found["violations"] if one["impact"] in ("serious", "critical")] == []
    context.close()


def test_a_report_opens_as_it_was_written_and_its_script_runs(page: Any, reported: SmallBook) -> None:
    with served(reported.folder, "--as", ADA) as server:
        page.goto(server.url)
        page.goto(server.base + "/reports")
        page.get_by_role("link", name="report 1").click()
        page.wait_for_url("**/report.html")
        shown, opened = "details[open]", page.locator("details").count()
        assert opened
        assert page.locator("svg").count()
        page.locator("details summary").first.click()
        page.wait_for_selector(shown)


def test_two_runs_are_drawn_over_each_other(page: Any, reported: SmallBook) -> None:
    with served(reported.folder, "--as", ADA) as server:
        page.goto(server.url)
        page.goto(server.base + "/runs/r002")
        page.get_by_role("link", name="Beside r001").click()
        page.wait_for_selector("tbody tr")
        until(lambda: page.evaluate("() => document.getElementById('both').width > 300"))
        colours = page.evaluate(
            """() => {
              const { width, height } = document.getElementById("both");
              const { data } = document.getElementById("both").getContext("2d").getImageData(0, 0, width, height);
              const seen = new Set();
              for (let at = 0; at < data.length; at += 4) {
                if (data[at + 3] > 200) seen.add(`${data[at]},${data[at + 1]},${data[at + 2]}`);
              }
              return [...seen];
            }"""
        )
        assert {"0,82,138", "184,92,0"} <= set(colours)
        assert page.locator("tbody tr").count()


def test_the_line_sounds_when_asked_and_follows_what_is_refused(page: Any, reported: SmallBook) -> None:
    with served(reported.folder, "--as", ADA) as server:
        page.goto(server.url)
        page.goto(server.base + "/live")
        page.wait_for_selector("#files tbody tr")
        page.get_by_role("button", name="Sound").click()
        assert page.get_attribute("#sound", "aria-pressed") == "true"
        (reported.folder.parent / "words.csv").write_text("no numbers\nat all\n")
        assert labbook("ingest", reported.folder.parent / "words.csv", at=reported.folder).code == 2
        page.wait_for_selector("#line .reject", timeout=10_000)
        assert page.text_content("#line").startswith("words.csv: ")


def test_a_log_that_is_another_run_s_is_red_on_the_line(page: Any, reported: SmallBook) -> None:
    with served(reported.folder, "--as", ADA) as server:
        page.goto(server.url)
        page.goto(server.base + "/live")
        page.wait_for_selector("#files tbody tr")
        copy = reported.folder.parent / "r005 again.csv"
        copy.write_bytes(reported.log("r005").read_bytes() + b"\n")
        assert labbook("ingest", copy, "--run", "r006", at=reported.folder).code == 0
        page.wait_for_selector("#line .reject", timeout=10_000)
