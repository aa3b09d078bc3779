"""A sample in numbers: by hand, and what of it does not exist."""

import pytest
import scipy.stats

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

    found = describe([0.1] * 7)
    assert (found.mean, found.sd, found.se) == (0.1, 0.0, 0.0)
    assert found.ci_low == found.ci_high == Undefined(Reason.NO_SCATTER)
