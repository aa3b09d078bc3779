import io

import numpy as np
import pytest

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.apexes.cleaning import CleaningParameters, clean_signal
from stats.apexes.detectors import find_jumps
from stats.apexes.jumps import Hop, StanceParameters, find_hops, landing, liftoff_from_leg, touches_gap
from tests.helpers.hopping_log import FLIGHT_S, REST_LENGTH_M, STANCE_S, apex_s, hopping_log, landing_s


def signal_of(log, leg=True):
    return clean_signal(log.time_s, log.height_m, log.leg_m if leg else None, np.empty((0, 2)), CleaningParameters())


def test_every_drop_is_a_stance_and_no_hand_motion_is(bed_log):
    log = bed_log(12, misfires=(3, 7))
    hops = find_hops(signal_of(log), 0.27, StanceParameters())
    assert [hop.touchdown_s for hop in hops] == pytest.approx(list(log.touchdown_s), abs=0.001)
    assert [number for number, hop in enumerate(hops, 1) if isinstance(hop.apex, Undefined)] == [3, 7]


def test_touchdown_without_a_leg_length_is_the_body_at_rest_length(bed_log):
    log = bed_log(6)
    hops = find_hops(signal_of(log, leg=False), 0.27, StanceParameters())
    assert [hop.touchdown_s for hop in hops] == pytest.approx(list(log.touchdown_s), abs=0.001)


def test_liftoff_is_where_the_leg_has_its_flight_length_again(bed_log):
    log = bed_log(8, misfires=(2,))
    signal, parameters = signal_of(log), StanceParameters()
    found = [liftoff_from_leg(signal, hop, 0.27, parameters) for hop in find_hops(signal, 0.27, parameters)]
    assert isinstance(found.pop(1), Undefined)
    assert found == pytest.approx(list(np.delete(log.liftoff_s, 1)), abs=0.004)


def test_a_leg_that_flies_shorter_than_its_rest_length_still_lifts_off(bed_log):
    log = bed_log(4)
    signal, parameters = signal_of(log), StanceParameters()
    short = clean_signal(log.time_s, log.height_m, log.leg_m - 0.004, np.empty((0, 2)), CleaningParameters())
    for hop, shifted in zip(find_hops(signal, 0.27, parameters), find_hops(short, 0.27, parameters), strict=True):
        expected = liftoff_from_leg(signal, hop, 0.27, parameters)
        assert liftoff_from_leg(short, shifted, 0.27, parameters) == pytest.approx(expected, abs=0.005)


def test_a_leg_that_was_not_measured_has_no_liftoff(bed_log):
    log = bed_log(2)
    nothing = clean_signal(
        log.time_s, log.height_m, np.full(log.time_s.size, np.nan), np.empty((0, 2)), CleaningParameters()
    )
    for hop in find_hops(nothing, 0.27, StanceParameters()):
        assert isinstance(hop.touchdown_s, float)
        assert isinstance(liftoff_from_leg(nothing, hop, 0.27, StanceParameters()), Undefined)


def test_a_log_that_ends_in_stance_says_so(bed_log):
    log = bed_log(2)
    n = int(np.searchsorted(log.time_s, log.touchdown_s[1] + 0.1))
    cut = clean_signal(log.time_s[:n], log.height_m[:n], None, np.empty((0, 2)), CleaningParameters())
    last = find_hops(cut, 0.27, StanceParameters())[-1]
    assert last.apex == Undefined(Reason.LOG_ENDS_IN_STANCE)


def test_a_landing_is_seen_or_read_off_the_parabola():
    at_s, extrapolated = landing(1.0, 0.37, 9.8, None, 0.27, StanceParameters())
    assert at_s == pytest.approx(1.0 + (0.2 / 9.8) ** 0.5)
    assert extrapolated
    assert isinstance(landing(1.0, 0.2, 9.8, None, 0.27, StanceParameters())[0], Undefined)


@pytest.mark.parametrize(("after_s", "seen"), [(0.45, True), (0.9, False)])
def test_a_high_hop_lands_later(after_s, seen):
    following = Hop(0, 1, 2, Undefined(Reason.AS_SAID, said="not looked for"), 2, 1.0 + after_s)
    at_s, extrapolated = landing(1.0, 1.27, 9.8, following, 0.27, StanceParameters())
    assert extrapolated != seen
    assert at_s == (1.0 + after_s if seen else pytest.approx(1.0 + (2.0 / 9.8) ** 0.5))


def test_gaps_touch_what_they_overlap():
    gaps = np.array([[1.0, 0.5]])
    assert touches_gap(gaps, 1.4, 2.0)
    assert touches_gap(gaps, 0.0, 1.1)
    assert not touches_gap(gaps, 1.5, 2.0)
    assert not touches_gap(np.empty((0, 2)), 0.0, 9.0)


@pytest.mark.parametrize("detector", ["published", "robust"])
@pytest.mark.parametrize(
    ("lost_s", "first_s"),
    [
        ((landing_s(4) - 0.01, landing_s(4) + STANCE_S + 0.01), 0.0),
        ((landing_s(4) - 0.06, landing_s(4) + STANCE_S + 0.01), 0.0),
        ((0.0, 0.0), landing_s(1) + STANCE_S / 2),
    ],
    ids=["a stance is lost", "a stance and the fall before it are lost", "the log begins in a stance"],
)
def test_a_flight_is_found_though_its_stance_was_not_seen(
    detector: str, lost_s: tuple[float, float], first_s: float
) -> None:
    """Its samples were all there, and it was passed over without a word."""
    rows = np.loadtxt(io.BytesIO(hopping_log(6, lost_s=[lost_s])), delimiter=",", skiprows=1)
    time_s, height_m = rows[:, 0] / 1000, rows[:, 1]
    seen = time_s >= first_s
    found = find_jumps(time_s[seen], height_m[seen], rest_length_m=REST_LENGTH_M, detector=detector)
    assert found.apex_times_s == pytest.approx([apex_s(number) for number in range(1, 7)], abs=0.005)
    if detector == "robust":
        times_s = [jump.flight_time_s for jump in found.with_apex if not isinstance(jump.flight_time_s, Undefined)]
        assert times_s == pytest.approx([FLIGHT_S] * len(times_s), abs=0.02)
        assert len(times_s) >= 5


@pytest.mark.parametrize("detector", ["published", "robust"])
def test_samples_lost_in_flight_or_in_stance_alone_make_no_jump_more(detector: str) -> None:
    for middle_s in (apex_s(3) - 0.1, apex_s(3), apex_s(3) + 0.1, landing_s(3) + STANCE_S / 2):
        lost_s = (middle_s - 0.015, middle_s + 0.015)
        rows = np.loadtxt(io.BytesIO(hopping_log(6, lost_s=[lost_s])), delimiter=",", skiprows=1)
        found = find_jumps(rows[:, 0] / 1000, rows[:, 1], rest_length_m=REST_LENGTH_M, detector=detector)
        assert len(found.jumps) == 7
