"""Names that programs and papers rely on: the fields of tables as CSV and JSON, the words of LaTeX macros.

A name stays where the title on the page changes; titles stand with the tables. In a name `{unit}` is the stored unit
of its column ("j", "kg_s"), `{of}` what the column is of: a factor, an outcome, a test.
"""

from __future__ import annotations

import re
from enum import StrEnum
from typing import TypeAlias

Fields: TypeAlias = tuple[str, ...]
"""The names of what one column of the page holds."""

# numbers with their uncertainty
VALUE: Fields = ("value",)
VALUE_AND_UNIT: Fields = ("value", "unit")
UNIT: Fields = ("unit",)
MEAN: Fields = ("mean_{unit}",)
SD: Fields = ("sd_{unit}",)
SE: Fields = ("se_{unit}",)
SHARED_SE: Fields = ("shared_se_{unit}",)
INTERVAL: Fields = ("{of}ci_low", "{of}ci_high", "{of}ci_level")
INTERVAL_IN_UNIT: Fields = ("{of}ci_low_{unit}", "{of}ci_high_{unit}", "{of}ci_level")
P: Fields = ("p",)
STATISTIC_OF_T: Fields = ("{of}_statistic", "{of}_df")
STATISTIC_OF_F: Fields = ("{of}_statistic", "{of}_df_1", "{of}_df_2")
P_OF_TEST: Fields = ("{of}_p",)
PROVENANCE: Fields = ("provenance",)

# runs and conditions
RUN: Fields = ("run",)
DAY: Fields = ("day",)
PACK: Fields = ("pack",)
QUANTITY: Fields = ("quantity",)
LEVEL: Fields = ("{of}",)
PHYSICAL: Fields = ("{of}_{unit}",)
PHYSICAL_WITHOUT_UNIT: Fields = ("{of}_value",)
N: Fields = ("n",)
N_RUNS: Fields = ("n_runs",)
N_JUMPS: Fields = ("n_jumps",)
N_OF_SIDES: Fields = ("n_control", "n_treatment")
ROBOTS: Fields = ("robots",)
OUTCOME: Fields = ("{of}",)
JUMPS: Fields = ("jumps_analysed", "lowest_m", "highest_m")
IN_DAY: Fields = ("position", "pack", "deviation_j")
RUNS_OF_DAY: Fields = ("n_runs", "runs")
CONDITIONS: Fields = ("conditions",)
PACKS: Fields = ("packs",)
CHECKS_MADE: Fields = ("checks_made",)
CHECKS_NOT_MADE: Fields = ("checks_not_made",)
NOTE: Fields = ("note",)
ANALYSIS: Fields = ("analysis",)
STEP: Fields = ("step",)
COUNT: Fields = ("count",)
LEFT_OUT: Fields = ("left_out",)
PLAIN_MEAN: Fields = ("mean",)

# comparisons
GROUP: Fields = ("group",)
DAYS: Fields = ("days",)
COMPARISON: Fields = ("family", "group", "level")
DIFFERENCE: Fields = ("difference_{unit}",)
SAVINGS: Fields = ("savings_percent",)
APEX_DIFFERENCE: Fields = ("apex_difference_m",)
APEX_COUNTS: Fields = ("apex_days", "apex_n_control", "apex_n_treatment")
HOLM: Fields = ("holm_p", "holm_tests", "holm_provenance")
HOLM_P: Fields = ("holm_p",)
EXPLORATORY: Fields = ("exploratory",)
CHOSEN_TEST: Fields = ("test",)
TOST_P: Fields = ("tost_p",)
EQUIVALENT: Fields = ("equivalent",)
BOUNDS: Fields = ("bound_low_{unit}", "bound_high_{unit}")
CONTRAST: Fields = ("kind", "outcome", "factor", "levels", "side", "per", "at")
ESTIMATE: Fields = ("estimate", "unit")

# certainty
VARIANT: Fields = ("variant",)
COMPONENT: Fields = ("component",)
UNCERTAINTY: Fields = ("uncertainty_j",)
UNCERTAINTY_OF_MEAN: Fields = ("uncertainty_of_mean_j",)
SHARED: Fields = ("shared",)
PLAIN_SE: Fields = ("se",)
DURATION: Fields = ("duration_min",)
CHARGE: Fields = ("charge_mah",)
PARAMETER: Fields = ("parameter",)
WHY: Fields = ("why",)
ID: Fields = ("id",)
WHAT: Fields = ("what",)
N_INPUTS: Fields = ("n_inputs",)

# predictions and hypotheses
CONDITION: Fields = ("group", "level")
MEASURED: Fields = ("measured_{unit}",)
PREDICTED: Fields = ("predicted_{unit}",)
PREDICTED_SE: Fields = ("predicted_se_{unit}",)
NUMERICAL_ERROR: Fields = ("numerical_error_{unit}",)
ERROR_RATIO: Fields = ("error_ratio",)
AGREES: Fields = ("agrees",)
PUBLISHED_RESULT: Fields = ("published", "published_unit", "published_in")
INPUT: Fields = ("input",)
VARIED_BY: Fields = ("varied_by",)
CHANGE: Fields = ("{of}_{unit}",)
PLAIN_MEASURED: Fields = ("measured",)
PLAIN_PREDICTED: Fields = ("predicted",)
BIAS: Fields = ("bias", "unit")
BIAS_INTERVAL: Fields = ("ci_low", "ci_high")
INTERVAL_OF_MEASURED: Fields = ("ci_low_measured", "ci_high_measured")
VERDICT: Fields = ("verdict",)
JOINT_TEST: Fields = ("joint_p", "kendall_tau", "joint_id", "kendall_tau_id")
LIMIT: Fields = ("{of}",)
NAME: Fields = ("name",)
CLAIM_AND_SOURCE: Fields = ("claim", "source")
SIMULATED_VERDICT: Fields = ("simulated_verdict",)
PUBLISHED: Fields = ("published",)
COMPARED: Fields = ("of", "against")
TRUE_BETWEEN: Fields = ("low_percent", "high_percent")
SIMULATED: Fields = ("simulated_{unit}",)
SIMULATED_SE: Fields = ("simulated_se_{unit}",)

# claims and results of the thesis
CLAIM: Fields = ("claim",)
RESULT: Fields = ("result",)
WHERE: Fields = ("where",)
STATEMENT: Fields = ("statement",)
MEASURE: Fields = ("measure", "unit")
RANGE: Fields = ("lowest", "median", "highest")
RANGE_AND_SAVING: Fields = ("lowest", "median", "highest", "saving")
LIMITS: Fields = ("at_least", "at_most")
POINTS_WITHIN: Fields = ("n_within", "n")
SHARE_WITHIN: Fields = ("share_within",)
PUBLISHED_NUMBER: Fields = ("published", "unit", "relation")
JUDGED: Fields = ("verdict", "n_within", "n")
REMARK: Fields = ("remark",)


class MacroWords(StrEnum):
    """The words that names of LaTeX macros are joined of, beside keys of outcomes and names of factors and levels."""

    RUNS = "runs"
    RUNS_PLANNED = "runs planned"
    RUNS_WITH = "runs with"
    JUMPS_MADE = "jumps made"
    JUMPS_ANALYSED = "jumps analysed"
    DAYS_MEASURED = "days measured"
    OVERALL_SAVING = "overall saving"
    OVERALL_APEX_EQUIVALENCE = "overall apex equivalence"
    SPREAD = "spread"
    GROUPS = "groups"
    DAYS = "days"
    SAVING = "saving"
    DIFFERENCE = "difference"
    EQUIVALENCE = "equivalence"
    CONTRAST = "contrast"
    AT = "at"
    RUNS_CONTROL = "runs control"
    RUNS_TREATMENT = "runs treatment"
    HOLM = "p Holm"
    LOW = "low"
    HIGH = "high"
    INTERVAL = "interval"
    P = "p"


def named(fields: Fields, *, of: str = "", unit: str = "") -> Fields:
    """Return the names of a column's fields, of what it is `of` and in a stored `unit`."""
    return tuple(field.format(of=of, unit=unit_slug(unit)) for field in fields)


def unit_slug(unit: str) -> str:
    """Write a unit so that it can end a field's name: "kg/s" -> "kg_s"."""
    return _UNIT_SLUGS.get(unit) or re.sub(r"[^a-z0-9]+", "_", unit.lower()).strip("_")


_UNIT_SLUGS = {"%": "percent", "mAh": "mah"}
