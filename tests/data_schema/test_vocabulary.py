"""What is undefined is never taken for a number, nor for yes or no."""

from __future__ import annotations

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from tests.helpers.wording import refuses


def test_what_is_undefined_is_neither_true_nor_false() -> None:
    with refuses(TypeError, "a single value", "neither true nor"):
        bool(Undefined(Reason.AS_SAID, said="a single value has no scatter"))
