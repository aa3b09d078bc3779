"""What is undefined is never taken for a number, nor for yes or no."""

from __future__ import annotations

import pytest

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.groups.variances import f_test
from tests.helpers.wording import refuses


def test_what_is_undefined_is_neither_true_nor_false() -> None:
    with pytest.raises(TypeError, match="a single value"):
        bool(Undefined(Reason.AS_SAID, said="a single value has no scatter"))


def test_a_test_that_could_not_be_made_shows_nothing() -> None:
    with refuses(TypeError, "neither true nor"):
        bool(f_test([1.0], [2.0, 3.0]).p)
