"""Joules a jump from the charge, the drain and the jumps made."""

import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.run_energy import joules_per_jump, joules_per_mah


def test_joules_are_those_of_the_thesis_and_jumps_made_decide():
    assert joules_per_mah(15.4, 25) == pytest.approx(2.2176)
    assert joules_per_jump(105.183, 86.183, 15.4, 25) == pytest.approx(19.0 * 2.2176)
    assert joules_per_jump(600.0, 0.0, 16.8, 100) == pytest.approx(362.88)  # chapter 4
    assert joules_per_jump(80.0, 86.0, 15.4, 25) < 0.0
    assert isinstance(joules_per_jump(100.0, 86.0, 15.4, 0), Undefined)
    for arguments, what in (
        ((float("nan"), 86.0, 15.4, 25), "the charge"),
        ((100.0, 86.0, 0.0, 25), "the reference voltage"),
        ((100.0, 86.0, 15.4, -1), "jumps made"),
    ):
        with pytest.raises(InputRefused, match=what):
            joules_per_jump(*arguments)
