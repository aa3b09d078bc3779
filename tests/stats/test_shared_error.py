"""The interval of a mean that carries a shared error."""

from __future__ import annotations

import numpy as np
import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats import describe, describe_shared


def test_without_a_shared_error_it_is_the_plain_interval() -> None:
    values = [40.1, 41.7, 39.2, 42.0]
    plain, shared = describe(values), describe_shared(values, shared_se=0.0)
    assert (shared.ci_low, shared.ci_high) == pytest.approx((plain.ci_low, plain.ci_high), rel=1e-14)
    assert shared.df == pytest.approx(3.0)


def test_the_shared_error_stays_with_any_number_of_values() -> None:
    rng = np.random.default_rng(5)
    few, many = (describe_shared(rng.normal(40, 1, n), shared_se=0.5) for n in (10, 100_000))
    width = [float(s.ci_high) - float(s.ci_low) for s in (few, many)]  # type: ignore[arg-type]
    assert width[1] == pytest.approx(2 * 1.959964 * 0.5, rel=1e-3)
    assert width[0] > width[1]


def test_it_covers_at_its_level_when_all_values_share_one_error() -> None:
    rng = np.random.default_rng(11)
    covered = 0
    for _ in range(4000):
        shared_se, shared_df = 0.6, 4
        estimate_of_se = shared_se * np.sqrt(rng.chisquare(shared_df) / shared_df)
        values = rng.normal(40, 1.5, 10) + rng.normal(0, shared_se)
        interval = describe_shared(values, shared_se=float(estimate_of_se), shared_df=shared_df)
        assert not isinstance(interval.ci_low, Undefined)
        assert not isinstance(interval.ci_high, Undefined)
        covered += interval.ci_low <= 40 <= interval.ci_high
    assert 0.94 <= covered / 4000 <= 0.965


def test_one_value_has_a_reason_and_a_negative_error_is_refused() -> None:
    assert isinstance(describe_shared([40.0], shared_se=0.5).ci_low, Undefined)
    with pytest.raises(InputRefused, match="shared_se"):
        describe_shared([40.0, 41.0], shared_se=-1.0)
