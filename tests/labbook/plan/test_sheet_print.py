"""The sheet on paper holds every run once, one page a day, and nothing that is not the plan's."""

from __future__ import annotations

import datetime
from html.parser import HTMLParser

from data_schema.vocabulary import PlanMethod
from labbook.plan.drawing import PlanFactor, draw_plan
from labbook.plan.sheet import BLANKS, format_run_sheet_for_print, run_names
from tests.helpers.wording import says

FACTORS = (PlanFactor("foot", ("<small>", "large & wide")), PlanFactor("b_ad_gain", ("0", "50"), control="0"))
DATES = [datetime.date(2021, 6, day) for day in range(1, 20)]


class Pages(HTMLParser):
    """Collects the rows of each page as texts, and every tag that would load something."""

    def __init__(self) -> None:
        super().__init__()
        self.pages: list[list[list[str]]] = []
        self.outside: list[str] = []
        self._in_cell = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.outside += [name for name, _ in attrs if name in ("src", "href")]
        if tag == "section":
            self.pages.append([])
        elif tag == "tr":
            self.pages[-1].append([])
        elif tag in ("td", "th"):
            self.pages[-1][-1].append("")
        self._in_cell = tag in ("td", "th")

    def handle_endtag(self, tag: str) -> None:
        self._in_cell = self._in_cell and tag not in ("td", "th")

    def handle_data(self, data: str) -> None:
        if self._in_cell:
            self.pages[-1][-1][-1] += data


def test_every_run_is_on_the_page_of_its_day() -> None:
    plan = draw_plan(FACTORS, 4, 6, PlanMethod.BLOCKED, seed=2, idle_minutes=(20.0,), run_duration_s=720.0)
    names = run_names(plan)
    text = format_run_sheet_for_print(plan, names, DATES, study="sand & <gravel>", robot="hopper", jumps_nominal=25)
    parser = Pages()
    parser.feed(text)
    assert parser.outside == []
    assert len(parser.pages) == len(plan.days)
    for page, day in zip(parser.pages, plan.days, strict=True):
        header, *rows = page
        assert header == ["run", "", "kind", "foot", "b_ad_gain", "min", "battery", "robot", *BLANKS]
        for row, run in zip(rows, day, strict=True):
            levels = ["", ""] if run.condition is None else [level for _, level in run.condition]
            minutes = "20" if run.condition is None else "12"
            assert row[:3] == [names[run.position - 1], str(run.position_in_day), run.kind.value]
            assert row[3:8] == [*levels, minutes, "", "hopper"]
            assert row[8:] == [""] * len(BLANKS)
    says(text, "sand &amp", "1")
    assert text == format_run_sheet_for_print(
        plan, names, DATES, study="sand & <gravel>", robot="hopper", jumps_nominal=25
    )
