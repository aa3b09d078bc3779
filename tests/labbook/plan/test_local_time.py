"""Local times to instants: one reading, or a question that names both; never one of two in silence."""

from __future__ import annotations

import datetime
import re
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from labbook.plan.local_time import parse_clock, to_utc
from tests.helpers.wording import refuses

BERLIN = ZoneInfo("Europe/Berlin")
BACK, FORWARD = datetime.date(2021, 10, 31), datetime.date(2021, 3, 28)
HALF_PAST_TWO = datetime.time(2, 30)


@pytest.mark.parametrize(
    ("date", "how", "first", "second"),
    [
        (BACK, "show twice", "2021-10-31T00:30:00Z", "2021-10-31T01:30:00Z"),
        (FORWARD, "skip", "2021-03-28T01:30:00Z", "2021-03-28T00:30:00Z"),
    ],
)
def test_a_time_that_clocks_repeat_or_skip_is_wanted_with_its_offset(
    date: datetime.date, how: str, first: str, second: str
) -> None:
    """The first of the two, and a time that never was, were stored without a word."""
    with refuses(InputRefused, how, "r7", "started at", "02:30") as asked:
        to_utc(date, HALF_PAST_TWO, BERLIN, "run r7")
    written = re.findall(r"02:30[+-][0-9:]{5}", str(asked.value))  # as they may be written into the cell
    assert [to_utc(date, parse_clock(each), BERLIN) for each in written] == [first, second]


@given(
    st.integers(631_152_000, 2_051_222_400),
    st.sampled_from(["Europe/Berlin", "Africa/Johannesburg", "America/New_York", "Australia/Lord_Howe", "UTC"]),
)
def test_every_instant_comes_back_from_its_local_time(epoch_s: int, name: str) -> None:
    moment = datetime.datetime.fromtimestamp(epoch_s, datetime.UTC)
    local = moment.astimezone(ZoneInfo(name))
    expected = moment.isoformat().replace("+00:00", "Z")
    try:
        assert to_utc(local.date(), local.time(), ZoneInfo(name)) == expected
    except InputRefused:
        offset = datetime.timezone(local.utcoffset() or datetime.timedelta())
        assert to_utc(local.date(), local.time().replace(tzinfo=offset), ZoneInfo(name)) == expected
