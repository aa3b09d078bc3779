"""The power of an equivalence test whose bounds are shares of the control's mean, which the study has to estimate too.

`stats.equivalence` tests a bound of delta as mean(a) - (1 + delta) mean(b), with Var(a) + (1 + delta)^2 Var(b). Given
both estimated variances it rejects where both means lie between two lines that cross: a chance in closed form, smooth
in the pooled variance, over which it is integrated, and over the share that a has in it. Right to 1e-9, and checked
against the test itself on drawn values.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.checks import as_count, as_level, as_number
from stats.distributions import t_upper_quantile
from stats.estimated_scatter import mean_over_scale, mean_over_share
from stats.finite import to_double
from stats.normal_wedge import between_lines
from stats.power import Power
from stats.quadrature import Floats, Rows
from stats.welch_planned import t_upper_quantiles
from stats.welch_satterthwaite import df_of_arrays
from stats.wording import number_text
