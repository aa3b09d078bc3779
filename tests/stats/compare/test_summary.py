import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.compare.summary import describe
from tests.helpers.wording import says


def test_small_sample_by_hand():
    found = describe([2.0, 4.0, 6.0])
    assert (found.n, found.mean, found.sd) == (3, 4.0, 2.0)
    assert found.se == pytest.approx(2.0 / 3.0**0.5, rel=1e-15)
    low, high = scipy.stats.t.interval(0.95, 2, loc=4.0, scale=found.se)
    assert (found.ci_low, found.ci_high) == pytest.approx((low, high), rel=1e-12)
    says(found.sentence("joules", "J"), "joules", "4.0 J", "2", "95 %")


def test_what_does_not_exist_is_undefined_field_by_field():
    one, none = describe([5.0]), describe([])
    assert one.mean == 5.0
    assert isinstance(one.sd, Undefined)
    assert isinstance(one.ci_low, Undefined)
    assert isinstance(none.mean, Undefined)
    assert none.n == 0
    assert "undefined" in none.sentence()
    assert "CI undefined" in one.sentence()


def test_a_constant_sample_has_no_scatter_and_no_interval():
    """As the difference of two has none: an interval of no width would be certainty from values that show none."""
    found = describe([0.1] * 7)
    assert (found.mean, found.sd, found.se) == (0.1, 0.0, 0.0)
    assert found.ci_low == found.ci_high == Undefined(Reason.NO_SCATTER)
    says(found.sentence(), "95 %", "CI undefined")


def test_nan_is_refused():
    with pytest.raises(InputRefused, match="NaN"):
        describe([1.0, float("nan")])


@given(st.lists(st.integers(-1000, 1000), min_size=2, max_size=20), st.integers(-(10**6), 10**6))
def test_shifting_moves_the_mean_and_nothing_else(numbers, shift):
    found, moved = describe(numbers), describe(np.array(numbers) + shift)
    assert moved.mean - shift == pytest.approx(found.mean, abs=1e-9)
    assert moved.sd == pytest.approx(found.sd, rel=1e-12, abs=1e-15)


def test_the_interval_covers_the_mean_as_often_as_it_says():
    rng = np.random.default_rng(11)
    samples = rng.normal(50.0, 4.0, (3000, 4))
    covered = [found.ci_low <= 50.0 <= found.ci_high for found in map(describe, samples)]
    # 99 % binomial band of 3000 trials at 0.95.
    assert abs(np.mean(covered) - 0.95) < 2.58 * (0.95 * 0.05 / 3000) ** 0.5
