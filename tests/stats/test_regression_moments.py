"""Moments of any kind are fitted as numpy's, and a data frame as its columns."""

from datetime import UTC, date, datetime, timedelta

import numpy as np
import pandas as pd
import pytest

from data_schema.errors import InputRefused
from stats.lines.regression import fit_linear

Y = [1.0, 2.5, 2.0, 4.0]
DAYS = np.array(["2026-01-01", "2026-01-02", "2026-01-05", "2026-02-01"], dtype="datetime64[us]")


@pytest.mark.parametrize(
    "moments",
    [
        DAYS.tolist(),
        [moment.date() for moment in DAYS.tolist()],
        [pd.Timestamp(moment) for moment in DAYS],
        [moment.replace(tzinfo=UTC) for moment in DAYS.tolist()],
        pd.Series(pd.DatetimeIndex(DAYS)).dt.tz_localize("UTC").dt.tz_convert("Europe/Berlin"),
        pd.DatetimeIndex(DAYS, tz="UTC"),
        pd.PeriodIndex(DAYS, freq="D"),
    ],
)
def test_moments_of_any_kind(moments):
    known, found = fit_linear(Y, {"t": DAYS}), fit_linear(Y, {"t": moments})
    assert found.coefficients == known.coefficients
    assert found.ci == known.ci


def test_microseconds_are_kept():
    given = [DAYS[0].item() + timedelta(microseconds=step) for step in (0, 1, 2, 3)]
    assert fit_linear([0.0, 1.0, 2.0, 3.0], {"t": given}).coefficients[1] == 1e6
    finer = [pd.Timestamp("2026-01-01") + pd.Timedelta(step, "ns") for step in (0, 1, 2, 3)]
    assert fit_linear([0.0, 1.0, 2.0, 3.0], {"t": finer}).coefficients[1] == 1e9


def test_moments_of_two_kinds_are_refused():
    mixed = [DAYS[0].item(), datetime(2026, 1, 2, tzinfo=UTC), *([date(2026, 1, 3)] * 2)]
    with pytest.raises(InputRefused, match="datetime64"):
        fit_linear(Y, {"t": mixed})


def test_a_data_frame_is_its_columns():
    columns = {"t": [1.0, 2.0, 4.0, 3.0], "u": [2.0, 2.0, 1.0, 7.0]}
    assert fit_linear(Y, pd.DataFrame(columns)).coefficients == fit_linear(Y, columns).coefficients
    for unnamed in ([columns["t"]], np.array([columns["t"]])):
        with pytest.raises(InputRefused, match="by name"):
            fit_linear(Y, unnamed)
