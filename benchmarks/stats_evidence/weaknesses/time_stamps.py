"""W16 and W17: lines and parabolas over time stamps, whose distance from 1970 is large against their range."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.stats_evidence.weaknesses.case import Number, Peer, Question, Weakness
from benchmarks.stats_evidence.weaknesses.peers import module, numpy, pg, pingouin, statsmodels, xarray
from stats.lines.regression import fit_linear, fit_polynomial
from tests.helpers.exact_fit import ExactFit, exact_fit, root

EPOCH_S = 1_700_000_000
SAMPLES = 1000
STANDARD_ERROR = 1e-12
"""Relative error that a standard error may have."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Log:
    """A battery's voltage over time stamps."""

    unit: str
    stamps: NDArray[Any]
    volts: Floats

    @property
    def design(self) -> Floats:
        """Columns of ones and of stamps as doubles, shape (n, 2)."""
        return np.column_stack([np.ones(SAMPLES), self.stamps.astype(np.float64)])


def _log(unit: str, ticks_per_s: int, rate_hz: int) -> Log:
    """Return 12.6 V falling by 0.3 mV a second, logged with a standard deviation of 10 mV."""
    number = np.arange(SAMPLES)
    volts = 12.6 - 3.0e-4 * number / rate_hz + np.random.default_rng(16).normal(0.0, 0.01, SAMPLES)
    if ticks_per_s < rate_hz:
        return Log(unit, EPOCH_S + number / rate_hz, volts)
    return Log(unit, ticks_per_s * EPOCH_S + number * (ticks_per_s // rate_hz), volts)


SECONDS = _log("s", 1, 1)
MILLISECONDS = _log("ms", 1000, 1)
NANOSECONDS = _log("ns", 10**9, 1)
AT_100_HZ = _log("s at 100 Hz", 1, 100)
AT_1_KHZ = _log("ns at 1 kHz", 10**9, 1000)


@cache
def _line(unit: str) -> ExactFit:
    (log,) = (each for each in (SECONDS, MILLISECONDS, NANOSECONDS, AT_100_HZ, AT_1_KHZ) if each.unit == unit)
    return exact_fit(log.volts, [log.stamps.tolist()])


def _ols(log: Log, method: str, what: str) -> float:
    fit = module("statsmodels.api").OLS(log.volts, log.design).fit(method=method)
    return float(getattr(fit, what)[1])


def _pingouin(log: Log) -> float:
    fit = pingouin().linear_regression(module("pandas").DataFrame({"time": log.design[:, 1]}), log.volts)
    return float(fit["coef"].iloc[1])


def _slope(log: Log, recorded: float) -> Question:
    return Question(
        f"slope, {log.unit}",
        Number(lambda: float(_line(log.unit).coefficients[1]), "exact arithmetic"),
        lambda: fit_linear(log.volts, {"time": log.stamps}).coefficients[1],
        (
            numpy("lstsq", lambda: np.linalg.lstsq(log.design, log.volts)[0][1], recorded),
            statsmodels("OLS", lambda: _ols(log, "pinv", "params"), recorded),
            pg("linear_regression", lambda: _pingouin(log), recorded),
        ),
        digits=5,
    )


def _standard_error(log: Log, *others: Peer) -> Question:
    return Question(
        f"standard error of the slope, {log.unit}",
        Number(lambda: root(_line(log.unit).variances[1]), "exact arithmetic", STANDARD_ERROR),
        lambda: fit_linear(log.volts, {"time": log.stamps}).standard_errors[1],  # type: ignore[index]
        others,
    )


def _polyfit_error(log: Log) -> float:
    return float(np.sqrt(np.polyfit(log.design[:, 1], log.volts, 1, cov=True)[1][0, 0]))


PARABOLA_S = np.arange(40) * 30
PARABOLA = 12.6 - 3.0e-4 * PARABOLA_S + 2e-8 * PARABOLA_S**2 + np.random.default_rng(17).normal(0.0, 1e-3, 40)
PARABOLA_NS = 10**9 * (EPOCH_S + PARABOLA_S)


def _polynomial(degree: int) -> Question:
    stamps = PARABOLA_NS.astype("datetime64[ns]")

    def of_xarray() -> float:
        log = module("xarray").DataArray(PARABOLA, dims="time", coords={"time": stamps})
        return float(log.polyfit("time", degree)["polyfit_coefficients"].sel(degree=1))

    return Question(
        f"linear term per second, degree {degree}",
        Number(
            lambda: float(
                exact_fit(
                    PARABOLA, [[int(s) ** power for s in EPOCH_S + PARABOLA_S] for power in range(1, degree + 1)]
                ).coefficients[1]
            ),
            "exact arithmetic",
        ),
        lambda: fit_polynomial(stamps, PARABOLA, degree).coefficients[1],
        (xarray("polyfit", of_xarray, {1: -2.76e-13, 2: 2.4e-18}[degree]),),
    )


CASES = (
    Weakness(
        "W16",
        "a battery's drain over time stamps",
        f"{SAMPLES} voltages at 1 Hz unless named, 12.6 V - 0.3 mV/s, standard deviation 10 mV, from second "
        f"{EPOCH_S} of Unix time on, drawn at random for this table",
        (
            _slope(SECONDS, 7.4e-9),
            _slope(MILLISECONDS, 7.4e-12),
            _slope(NANOSECONDS, 7.4e-18),
            _standard_error(
                AT_100_HZ,
                numpy("polyfit", lambda: _polyfit_error(AT_100_HZ), 5.44e-6),
                statsmodels('OLS, "qr"', lambda: _ols(AT_100_HZ, "qr", "bse"), 1.51e-5),
            ),
            _standard_error(
                AT_1_KHZ,
                numpy("polyfit", lambda: _polyfit_error(AT_1_KHZ), 6.08e-15),
                statsmodels('OLS, "qr"', lambda: _ols(AT_1_KHZ, "qr", "bse"), 1.46e-14),
            ),
        ),
    ),
    Weakness(
        "W17",
        "polynomials of datetime64",
        "40 values at 30 s, 12.6 - 3e-4 s + 2e-8 s^2, standard deviation 1e-3, drawn at random for this table",
        (_polynomial(1), _polynomial(2)),
    ),
)
