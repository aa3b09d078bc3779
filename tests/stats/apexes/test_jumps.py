import numpy as np

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.apexes.jumps import Jump, Jumps, defined


def jump(number, height):
    apex = height if isinstance(height, Undefined) else float(number)
    return Jump(number, 0.0, 0.1, apex, height, height, 0.3, 0, 9.8, False, ())


def test_only_jumps_with_an_apex_have_a_height():
    reason = Undefined(Reason.AS_SAID, said="no flight")
    jumps = Jumps("robust", 1, None, 0.0, 0.0, (jump(1, 0.3), jump(2, reason), jump(3, 0.31)))
    assert [one.undefined_reason for one in jumps.jumps] == [None, "no flight", None]
    assert [one.number for one in jumps.with_apex] == [1, 3]
    assert np.array_equal(jumps.apex_heights_m, [0.3, 0.31])
    assert np.array_equal(jumps.apex_times_s, [1.0, 3.0])


def test_nothing_defined_is_an_empty_array():
    assert defined([Undefined(Reason.AS_SAID, said="why")]).shape == (0,)
