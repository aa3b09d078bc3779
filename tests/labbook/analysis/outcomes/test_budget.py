import math

import numpy as np
import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.budget import energy_budget
from labbook.analysis.outcomes.run_energy import joules_per_jump, joules_per_mah


def test_one_mah_is_worth_what_the_thesis_setting_says():
    assert joules_per_mah(15.4, 25) == pytest.approx(2.2176)
    assert joules_per_jump(105.183, 86.183, 15.4, 25) == pytest.approx(19.0 * 2.2176)


def test_jumps_made_decide():
    """Chapter 4: 16.8 V and 100 jumps."""
    assert joules_per_jump(600.0, 0.0, 16.8, 100) == pytest.approx(362.88)
    assert isinstance(joules_per_jump(100.0, 86.0, 15.4, 0), Undefined)
    assert joules_per_jump(80.0, 86.0, 15.4, 25) < 0.0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((float("nan"), 86.0, 15.4, 25), "the charge"),
        ((100.0, 86.0, 0.0, 25), "the reference voltage"),
        ((100.0, 86.0, 15.4, -1), "jumps made"),
    ],
)
def test_wrong_input_is_refused(arguments, sentence):
    with pytest.raises(InputRefused, match=sentence):
        joules_per_jump(*arguments)


def budget(joules, **changes):
    settings = {
        "reference_voltage_v": 15.4,
        "drain_se_run_j": 0.5,
        "drain_se_mean_j": 0.4,
        "resolution_mah": 1.0,
    } | changes
    return energy_budget(joules, np.full(len(joules), 25), **settings)


def test_every_term_by_hand():
    found = budget([40.0, 42.0, 44.0, 46.0], voltage_relative_se=0.01)
    terms = {term.name: term for term in found.terms}
    sd = math.sqrt(20.0 / 3.0)
    assert terms["scatter between runs"].one_run_j == pytest.approx(sd)
    assert terms["scatter between runs"].mean_j == pytest.approx(sd / 2.0)
    assert (terms["drain fit"].one_run_j, terms["drain fit"].mean_j) == (0.5, 0.4)
    assert terms["charger resolution"].one_run_j == pytest.approx(2.2176 / math.sqrt(12.0))
    assert terms["charger resolution"].mean_j == pytest.approx(2.2176 / math.sqrt(12.0) / 2.0)
    assert terms["reference voltage"].mean_j == pytest.approx(0.43)
    assert [term.shared for term in found.terms] == [False, True, False, True]
    assert found.total_mean_j == pytest.approx(math.hypot(sd / 2.0, 0.4, 0.43))
    assert found.total_one_run_j == pytest.approx(math.hypot(sd, 0.5, 0.43))


def test_what_a_mah_is_worth_is_the_mean_of_what_it_is_worth_in_each_run():
    """Runs of 20, 25 and 50 jumps: 2.772, 2.2176 and 1.1088 J a mAh, not what the mean number of jumps would make."""
    found = energy_budget(
        [40.0, 42.0, 44.0],
        [20, 25, 50],
        reference_voltage_v=15.4,
        drain_se_run_j=0.5,
        drain_se_mean_j=0.4,
        resolution_mah=2.0,
    )
    worth = 3.6 * 15.4 * (1.0 / 20.0 + 1.0 / 25.0 + 1.0 / 50.0) / 3.0
    assert worth == pytest.approx((2.772 + 2.2176 + 1.1088) / 3.0)
    assert found.joules_per_mah == pytest.approx(worth, rel=1e-14)
    (resolution,) = (term for term in found.terms if term.name == "charger resolution")
    assert resolution.one_run_j == pytest.approx(worth * 2.0 / math.sqrt(12.0))
    assert resolution.mean_j == pytest.approx(worth * 2.0 / math.sqrt(12.0) / math.sqrt(3.0))


def test_the_resolution_is_within_the_scatter_and_not_added_twice():
    fine, coarse = budget([40.0, 42.0, 44.0], resolution_mah=0.0), budget([40.0, 42.0, 44.0], resolution_mah=10.0)
    assert fine.total_mean_j == coarse.total_mean_j
    assert [term.in_scatter for term in coarse.terms] == [False, False, True, False]


def test_a_single_run_leaves_the_scatter_undefined():
    single = budget([40.0])
    assert isinstance(single.terms[0].mean_j, Undefined)
    assert isinstance(single.total_mean_j, Undefined)
    assert single.mean_j == 40.0


@pytest.mark.parametrize(
    ("joules", "jumps_made", "sentence"),
    [([], [], "no run"), ([1.0], [0], "without jumps"), ([1.0, 2.0], [25], "2 joules and 1 counts")],
)
def test_budgets_of_nothing_are_refused(joules, jumps_made, sentence):
    settings = {"reference_voltage_v": 15.4, "drain_se_run_j": 0.1, "drain_se_mean_j": 0.1, "resolution_mah": 1.0}
    with pytest.raises(InputRefused, match=sentence):
        energy_budget(joules, jumps_made, **settings)
