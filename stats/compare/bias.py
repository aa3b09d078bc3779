"""Signed bias of predictions against measured means, over the levels of a group and jointly over groups.

The errors of measured means are independent of each other but for the part that they share (a calibration); inputs that
predictions assume are the same in all conditions. What is shared is added before it is squared, so no number of levels
averages it out: with k levels

    u_measured = hypot(sqrt(sum u_i^2) / k, mean of the shared parts),    u_predicted = mean of the predictions' errors.

The biases of all groups are tested jointly by Wald's chi-squared, with covariance diag(u^2) of what is independent plus
the outer product of what groups share with itself.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.exact.tails import chi2_upper

_QUANTILE = 1.959963984540054
"""Of the standard normal distribution, for intervals of 95 %."""


@dataclass(frozen=True, slots=True)
class PredictedLevel:
    """A level's measured mean and its prediction, all in one unit."""

    measured: float
    """Mean of what was measured."""
    measured_se: float
    """Its standard error, independent of those of other levels."""
    predicted: float
    """What was predicted."""
    predicted_se: float
    """Its standard uncertainty, from inputs that all predictions assume alike."""
    measured_shared_se: float = 0.0
    """What the measured mean's error has in common with all others."""


@dataclass(frozen=True, slots=True)
class GroupBias:
    """Bias of the predictions of one group, in the unit of its values; intervals are of 95 %."""

    levels: int
    """Number of levels that the means are taken over, each counting the same."""
    measured: float
    """Mean of the measured means."""
    predicted: float
    """Mean of the predictions."""
    independent_se: float
    """Standard error of the mean of the measured means, the part independent of other groups."""
    shared_se: float
    """The part in common with other groups."""
    predicted_se: float
    """Standard uncertainty of the mean of the predictions."""

    @property
    def bias(self) -> float:
        """Predicted less measured."""
        return self.predicted - self.measured

    @property
    def measured_se(self) -> float:
        """Standard error of the mean of the measured means."""
        return math.hypot(self.independent_se, self.shared_se)

    @property
    def se(self) -> float:
        """Standard error of the bias, of what was measured and of what was assumed."""
        return math.hypot(self.measured_se, self.predicted_se)

    @property
    def interval(self) -> tuple[float, float]:
        """Interval of the bias with the errors of what was measured and of what was assumed."""
        return self._about(self.se)

    @property
    def interval_of_measured(self) -> tuple[float, float]:
        """Interval of the bias as if predictions had no error."""
        return self._about(self.measured_se)

    @property
    def differs(self) -> bool:
        """Whether 0 lies outside the interval with both errors."""
        return _outside(self.interval)

    @property
    def agrees_only_by_assumed(self) -> bool:
        """Whether 0 lies inside with both errors but outside with that of the measured means alone."""
        return not self.differs and _outside(self.interval_of_measured)

    def _about(self, se: float) -> tuple[float, float]:
        return self.bias - _QUANTILE * se, self.bias + _QUANTILE * se


@dataclass(frozen=True, slots=True)
class JointBias:
    """Whether the biases of all groups are 0 together, and whether predictions put the groups in the measured order."""

    chi_squared: float | Undefined
    """Wald's statistic."""
    df: int
    """Number of groups."""
    p: float | Undefined
    """Its upper tail."""
    tau: float | None
    """Kendall's tau of measured and predicted group means, ties counting 0; None for a single group."""


def bias_of_group(levels: Sequence[PredictedLevel]) -> GroupBias:
    """Return the bias over the levels of a group; a row that pools them must not stand among them.

    Raises `InputRefused` where there is no level, or an error is negative or no finite number.
    """
    if not levels:
        raise InputRefused("a group without levels has no bias: give each level's measured mean and its prediction.")
    for each in levels:
        errors = (each.measured_se, each.measured_shared_se, each.predicted_se)
        if not all(map(math.isfinite, (each.measured, each.predicted, *errors))) or min(errors) < 0.0:
            raise InputRefused(f"{each} is no level to compare: give finite numbers, and errors of at least 0.")
    count = len(levels)
    return GroupBias(
        levels=count,
        measured=math.fsum(each.measured for each in levels) / count,
        predicted=math.fsum(each.predicted for each in levels) / count,
        independent_se=math.hypot(*(each.measured_se for each in levels)) / count,
        shared_se=math.fsum(each.measured_shared_se for each in levels) / count,
        predicted_se=math.fsum(each.predicted_se for each in levels) / count,
    )


def joint_bias(groups: Sequence[GroupBias]) -> JointBias:
    """Test jointly that no group has a bias, and compare the order of groups.

    Undefined where a measured mean has no error of its own. Raises `InputRefused` where there is no group.
    """
    if not groups:
        raise InputRefused("without groups there is no joint test: give the bias of at least one.")
    tau = _kendall_tau(groups)
    own = np.array([each.independent_se for each in groups])
    if not own.all():
        none = Undefined(Reason.MEASURED_WITHOUT_INTERVAL)
        return JointBias(none, len(groups), none, tau)
    # in units of each group's own error the covariance is the unit matrix and what is shared
    bias, shared, predicted = (
        np.array(values) / own
        for values in zip(*((each.bias, each.shared_se, each.predicted_se) for each in groups), strict=True)
    )
    covariance = np.eye(len(groups)) + np.outer(shared, shared) + np.outer(predicted, predicted)
    chi_squared = float(bias @ np.linalg.solve(covariance, bias))
    return JointBias(chi_squared, len(groups), chi2_upper(chi_squared, len(groups)).p, tau)


def _outside(interval: tuple[float, float]) -> bool:
    low, high = interval
    return low > 0.0 or high < 0.0


def _kendall_tau(groups: Sequence[GroupBias]) -> float | None:
    pairs = list(itertools.combinations(groups, 2))
    if not pairs:
        return None
    agreeing = sum(_sign(b.measured - a.measured) * _sign(b.predicted - a.predicted) for a, b in pairs)
    return agreeing / len(pairs)


def _sign(value: float) -> int:
    return (value > 0.0) - (value < 0.0)
