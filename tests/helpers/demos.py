"""Demonstrations that several tests look at, made once a test run; nobody may change them."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from labbook.book import write_session as session
from labbook.demo.campaign import Campaign, make_campaign
from labbook.demo.files import campaign_files
from labbook.demo.running import DemoDone, run_demo
from tests.helpers.once import made_once
from tests.helpers.stated_campaign import STATED

CAMPAIGNS: Mapping[str, Callable[[], Campaign]] = {
    "two_runs_a_condition": lambda: make_campaign(
        1, truth=STATED, runs_per_condition=2, extra_controls=4, jumps_per_run=3
    ),
    "demonstration": lambda: make_campaign(1, truth=STATED),
    "simulated": lambda: make_campaign(1),
}


def made_demo(name: str) -> DemoDone:
    """The demonstration of a campaign, with its report; its ids are drawn from a seed, and so are those of numbers."""

    def make(folder: Path) -> DemoDone:
        drawn = random.Random(1)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(session, "new_uid", lambda: drawn.randbytes(6).hex())
            return run_demo(folder / "demo", campaign_files(CAMPAIGNS[name]()), lambda _step: None, lambda _line: None)

    return made_once(f"demo-{name}", make)
