"""Clock times and instants: zones, summer time, epochs, midnight."""

from __future__ import annotations

import pytest

from data_schema.errors import UsageError
from ingest.findings import FindingCollector
from ingest.timebase.clock import epoch_time, to_utc

NEW_YORK = "America/New_York"


@pytest.mark.parametrize(
    ("text", "zone", "instant"),
    [
        ("2021-06-05 14:30", NEW_YORK, "2021-06-05T18:30:00.000000Z"),
        ("2021-01-05T14:30:00.25", NEW_YORK, "2021-01-05T19:30:00.250000Z"),
        ("2021-06-05T14:30:00+02:00", None, "2021-06-05T12:30:00.000000Z"),
        ("2021-06-05T14:30:00Z", NEW_YORK, "2021-06-05T14:30:00.000000Z"),
    ],
)
def test_a_time_with_a_zone_is_an_instant(text: str, zone: str | None, instant: str) -> None:
    findings = FindingCollector()
    assert to_utc(text, zone, findings) == instant
    assert findings.findings() == ()


@pytest.mark.parametrize(
    ("text", "zone", "rule"),
    [
        ("2021-11-07 01:30", NEW_YORK, "instant_unclear"),  # summer time ends: twice
        ("2021-03-14 02:30", NEW_YORK, "instant_unclear"),  # summer time begins: never
        ("2021-06-05 14:30", None, "instant_unknown"),
        ("03/04/2019 14:30", NEW_YORK, "instant_unknown"),
        ("yesterday", NEW_YORK, "instant_unknown"),
    ],
)
def test_a_time_that_tells_no_instant_is_kept_as_text(text: str, zone: str | None, rule: str) -> None:
    findings = FindingCollector()
    assert to_utc(text, zone, findings) is None
    assert [finding.rule for finding in findings.findings()] == [rule]


def test_an_unknown_zone_is_a_usage_error() -> None:
    with pytest.raises(UsageError, match="America/New_York"):
        to_utc("2021-06-05 14:30", "Pennsylvania", FindingCollector())


def test_only_dates_of_2000_to_2100_are_instants() -> None:
    assert epoch_time(1607954342.0, "s", 1.0) == "2020-12-14T13:59:02.000000Z"
    assert epoch_time(1607954342123456999, "ns", 1e9) == "2020-12-14T13:59:02.123457Z"
    assert epoch_time(133_500_000_000_000_000, "filetime", 1e7) == "2024-01-17T21:20:00.000000Z"
    assert epoch_time(44348.375, "d", 1 / 86_400) == "2021-06-01T09:00:00.000000"
    for ticks, unit, per_second in ((39.625, "s", 1.0), (1607954342000.0, "s", 1.0), (5e9, "filetime", 1e7)):
        assert epoch_time(ticks, unit, per_second) is None
