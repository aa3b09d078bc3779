"""The line through idle runs: exact arithmetic, statsmodels, and what it says of an extrapolation."""

from fractions import Fraction

import numpy as np
import pytest
import statsmodels.api as sm
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.lines.passive_drain import fit_passive_drain
from tests.helpers.wording import says

MINUTES = np.array([20.0, 24.0, 30.0, 40.0, 50.0, 60.0])
CHARGE_MAH = np.array([143.0, 171.0, 213.0, 284.0, 355.0, 425.0])


def test_the_line_agrees_with_exact_arithmetic():
    x, y = [Fraction(60 * m) for m in MINUTES], [Fraction(c) for c in CHARGE_MAH]
    n, mean_x, mean_y = len(x), sum(x) / len(x), sum(y) / len(y)
    squares = sum((one - mean_x) ** 2 for one in x)
    slope = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True)) / squares
    residuals = [b - mean_y - slope * (a - mean_x) for a, b in zip(x, y, strict=True)]
    variance = sum(r * r for r in residuals) / (n - 2)
    drain = fit_passive_drain(60.0 * MINUTES, CHARGE_MAH)
    assert drain.slope_mah_s == pytest.approx(float(slope), rel=1e-14)
    assert drain.intercept_mah == pytest.approx(float(mean_y - slope * mean_x), rel=1e-12)
    assert drain.residual_sd_mah == pytest.approx(float(variance) ** 0.5, rel=1e-12)
    at_720 = drain.at(720.0)
    assert at_720.charge_mah == pytest.approx(float(mean_y + slope * (720 - mean_x)), rel=1e-14)
    of_720 = variance * (Fraction(1, n) + (720 - mean_x) ** 2 / squares)
    assert at_720.se == pytest.approx(float(of_720) ** 0.5, rel=1e-12)


def test_agrees_with_statsmodels():
    drain = fit_passive_drain(60.0 * MINUTES, CHARGE_MAH)
    model = sm.OLS(CHARGE_MAH, sm.add_constant(60.0 * MINUTES)).fit()
    assert (drain.intercept_mah, drain.slope_mah_s) == pytest.approx(tuple(model.params), rel=1e-9)
    assert np.array(drain.covariance) == pytest.approx(model.cov_params(), rel=1e-8)
    assert drain.r_squared == pytest.approx(model.rsquared, rel=1e-12)
    assert (drain.intercept_se_mah, drain.slope_se_mah_s) == pytest.approx(tuple(model.bse), rel=1e-8)
    prediction = model.get_prediction([[1.0, 720.0]])
    estimate = drain.at(720.0)
    assert estimate.se == pytest.approx(prediction.se_mean[0], rel=1e-8)
    assert (estimate.ci_low, estimate.ci_high) == pytest.approx(tuple(prediction.conf_int()[0]), rel=1e-8)


def test_twelve_minutes_lie_outside_what_was_measured():
    drain = fit_passive_drain(60.0 * MINUTES, CHARGE_MAH)
    assert drain.at(720.0).extrapolated
    assert not drain.at(1200.0).extrapolated
    says(drain.sentence(720.0), "12 min", "lies outside the", "20", "60 min")
    assert "outside" not in drain.sentence(1800.0)
    at = drain.at(720.0)
    assert f"{at.charge_mah:.2f} mAh in 12 min (95 % CI {at.ci_low:.2f} to {at.ci_high:.2f}" in drain.sentence(720.0)


def test_a_line_that_is_exact_has_no_interval():
    """Where the charger's steps are not told: that three runs scatter by nothing is not what they show."""
    exact = fit_passive_drain([60.0, 120.0, 180.0], [1.0, 2.0, 3.0])
    none = Undefined(Reason.FIT_EXACT)
    assert exact.slope_ci_mah_s() == exact.intercept_ci_mah() == exact.at(90.0).ci_low == exact.at(90.0).ci_high == none
    assert (exact.at(90.0).charge_mah, exact.at(90.0).df) == (pytest.approx(1.5), 1)
    stepped = fit_passive_drain([60.0, 120.0, 180.0], [1.0, 2.0, 3.0], resolution_mah=1.0)
    assert stepped.at(90.0).ci_low < 0.0 < stepped.at(90.0).ci_high


def test_a_line_that_falls_with_time_is_told():
    says(fit_passive_drain(60.0 * MINUTES, CHARGE_MAH[::-1]).sentence(), "no drain does")
    assert "falls" not in fit_passive_drain(60.0 * MINUTES, CHARGE_MAH).sentence()
    of_noise = fit_passive_drain([600.0, 1200.0, 1800.0, 2400.0], [70.0, 71.0, 70.0, 70.0], 1.0)
    assert of_noise.slope_mah_s < 0.0
    assert "falls" not in of_noise.sentence()


def test_the_published_value_follows_from_its_line():
    """Thesis 5.1.4: 86.183 mAh in 12 minutes from idle runs of 20 to 60 minutes with R squared of 1."""
    slope, intercept = 0.1176, 86.183 - 720 * 0.1176
    drain = fit_passive_drain(60.0 * MINUTES, intercept + slope * 60.0 * MINUTES)
    assert drain.at(720.0).charge_mah == pytest.approx(86.183, abs=1e-9)
    assert drain.r_squared == pytest.approx(1.0, abs=1e-12)
    assert isinstance(fit_passive_drain([60.0, 120.0, 180.0], [5.0, 5.0, 5.0]).r_squared, Undefined)


@given(st.integers(0, 2**40))
def test_time_stamps_instead_of_durations_cost_no_digit(epoch_s):
    """W16: against seconds since 1970 a plain least-squares solver returns a slope of 7e-9 for -3.0e-4."""
    near = fit_passive_drain(60.0 * MINUTES, CHARGE_MAH)
    far = fit_passive_drain(epoch_s + 60.0 * MINUTES, CHARGE_MAH)
    assert far.slope_mah_s == pytest.approx(near.slope_mah_s, rel=1e-12)
    assert far.slope_se_mah_s == pytest.approx(near.slope_se_mah_s, rel=1e-10)


@pytest.mark.parametrize(
    ("durations", "charges", "reason"),
    [
        ([1200.0, 2400.0], [140.0, 280.0], "at least 3 idle runs and there are 2: give more"),
        ([1200.0] * 4, [140.0] * 4, "one duration"),
        ([], [], "there are 0"),
        ([1.0, 2.0, 3.0], [1.0, 2.0], "3 durations .*2 charges"),
        ([1.0, 2.0, 3.0], [1.0, 2.0, np.nan], "the charges"),
        ([-1.0, 2.0, 3.0], [1.0, 2.0, 3.0], "durations are"),
    ],
)
def test_what_makes_no_line_is_refused(durations, charges, reason):
    with pytest.raises(InputRefused, match=reason):
        fit_passive_drain(durations, charges)
    with pytest.raises(InputRefused, match="the duration"):
        fit_passive_drain([1.0, 2.0, 3.0], [1.0, 2.0, 4.0]).at(float("nan"))


def test_idle_runs_on_one_line_are_known_no_better_than_the_charger_counts():
    minutes = np.array([20.0, 40.0, 60.0])
    counted = fit_passive_drain(60.0 * minutes, 7.0 * minutes, resolution_mah=1.0)
    assert counted.residual_sd_mah == pytest.approx(1.0 / 12.0**0.5)
    assert counted.at(2400.0).se == pytest.approx((1.0 / 36.0) ** 0.5)
    noisy = fit_passive_drain(60.0 * MINUTES, CHARGE_MAH + np.tile([5.0, -5.0], 3), resolution_mah=1.0)
    assert noisy.residual_sd_mah > 1.0


def test_the_terms_of_the_error_make_up_the_error():
    drain = fit_passive_drain(60.0 * MINUTES, CHARGE_MAH)
    for duration_s in (0.0, 720.0, drain.duration_mean_s, 5000.0):
        terms = drain.error_terms_mah(duration_s)
        assert drain.at(duration_s).se == pytest.approx(np.hypot(*terms.values()), rel=1e-14)
    assert drain.error_terms_mah(720.0)["slope"] < 0.0 < drain.error_terms_mah(5000.0)["slope"]
