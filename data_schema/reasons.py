"""Why a number does not exist, and what a comparison cannot decide: codes, each with its sentence.

A computation returns the code and its parameters; the sentence is made where it is shown. The words for a group or for
the values compared are parameters, so that a page can call them runs, days, or by their own names.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

VALUE = "value"
"""The default word for one of the numbers looked at: `unit` in the sentences."""


class Code(Enum):
    """Base of codes, whose value is their sentence with parameters in braces.

    `unit` is what one of the values is called, `s` the ending of a plural where `n` is not 1.
    """

    def in_words(self, parameters: Mapping[str, str | int | float]) -> str:
        """Return the sentence of the code."""
        plural = "" if parameters.get("n") == 1 else "s"
        text: str = self.value
        return text.format(**{"unit": VALUE, "s": plural, **parameters})


class Reason(Code):
    """Why a number does not exist."""

    AS_SAID = "{said}"
    """A reason that comes with its own words."""
    TOO_FEW_AROUND_APEX = "too few valid samples around the highest point after this stance, or it is no maximum"
    NEVER_LEFT_PARABOLA = "the body left its parabola nowhere between touchdown and apex"
    RULE_WITHOUT_ERROR = "the published rule has no standard error"
    RULE_WITHOUT_CURVATURE = "the published rule fits no curvature"
    FLIGHT_ENDS_UNKNOWN = "lift-off or landing is not known"
    NO_FREE_FLIGHT = (
        "the highest point after this stance curves at {curvature_m_s2:.1f} m/s^2, which is not gravity: no free flight"
    )
    TOO_FEW_BESIDE_APEX = "there are {count} valid samples {side} the apex and at least {needed} are needed"
    NO_LEG_LENGTH = "the log has no leg length"
    LEG_LENGTH_MISSING = "the leg length is missing between touchdown and apex"
    LEG_NOT_RETURNED = "the leg did not return to its flight length"
    NO_FALL = "after this stance the body rose and did not fall again: no flight"
    LOG_BEGINS_IN_STANCE = "the log begins below the rest length"
    LOG_ENDS_IN_STANCE = "the log ends in this stance"
    LOG_ENDS_AFTER_STANCE = "the log ends right after this stance"
    APEX_BELOW_REST_LENGTH = "the apex is not above the rest length"
    SAMPLES_MISSING_HERE = "{reason} (samples are missing here)"
    TOO_FEW_GAINS = "there are {n} gains and a line over them needs at least {least}"
    TOO_FEW_FOR_T = "there are too few {unit}s for a t statistic"
    GROUPS_WITHOUT_SCATTER = "neither group has any scatter"
    GROUP_EMPTY = "{group} is empty"
    CONTROL_MEAN_NOT_POSITIVE = "the control's mean is not positive, so that nothing is a share of it"
    NOTHING_TO_SAVE = "the control's mean is not positive, so that there is nothing to save a share of"
    SINGLE_NO_VARIANCE = "{group} has a single {unit}, and its variance needs at least 2"
    TWO_NOT_POOLED = "there are 2 {unit}s and the pooled variance needs at least 3"
    NO_SCATTER_AT_BOUND = "nothing scatters at the bound"
    CONTROL_NEAR_ZERO = "the control's mean is not distinguishable from 0 at this level"
    TREATED_NEAR_ZERO = "the treated mean is not distinguishable from 0 at this level"
    TREATED_WITHOUT_LOGARITHM = "the treated mean is not positive and has no logarithm"
    ALL_COMPARED_ZERO = "all {unit}s compared with the control are 0, and a share of 0 does not scatter"
    ALL_TREATED_ZERO = "all treated runs are 0, and a share of 0 does not scatter"
    LEVEL_TOO_HIGH = "the level is too near 1 for the tails of the noncentral distribution"
    NO_LOWER_BOUND = "no lower bound was asked for"
    NO_UPPER_BOUND = "no upper bound was asked for"
    DAY_WITH_SINGLE = "a day holds a single {unit} of {group}, and its scatter needs at least 2"
    TOO_FEW_REDRAWS = "{redraws} redraws are too few for a tail of {tail:g}"
    REDRAWS_REPEAT = "there are so few {unit}s that too many redraws repeat one and have no scatter"
    DRAWS_ON_ONE_SIDE = "all draws lie on one side of the difference"
    EACH_WITHOUT_SCATTER = "the {unit}s of each {of} do not scatter"
    ALL_ARRANGEMENTS = "all arrangements were counted"
    SINGLE_RUN = "{group} has a single run and so no scatter"
    END_BEYOND_DOUBLES = "an end of the interval is too large for a double"
    NORMAL = "both errors are known as if from infinitely many {unit}s: t is normal"
    NO_WIDTH = "the interval has no width"
    NO_SCATTER = "the {unit}s do not scatter"
    NO_VALUE = "there is no {unit}"
    SINGLE_NO_SCATTER = "a single {unit} has no scatter; at least 2 are needed"
    TOO_FEW_POOLED = "there are {n_a} and {n_b} {unit}s and the pooled variance needs at least 3 in all"
    TOO_FEW_FOR_VARIANCE = "{group} has {n} {unit}{s} and its variance needs at least 2"
    TOO_FEW_FOR_SCATTER = "{group} has {n} {unit}{s} and its scatter needs at least 2"
    TOO_FEW_FOR_G = "there are too few {unit}s for a pooled standard deviation and its correction"
    TOO_SHORT_SERIES = "the series has {n} {unit}{s} and a lag of {lag} needs at least {needed}"
    SERIES_CONSTANT = "the series is constant"
    NO_RUNS_GIVEN = "no runs were given"
    NO_DAYS_GIVEN = "no days were given"
    EACH_ONE_DAY = "each group of conditions had one day of its own, so that nothing measures how days differ"
    RUN_SCATTER_UNTOLD = (
        "the scatter between runs cannot be told from that of days, {unit}s or conditions in this design"
    )
    ONE_CONDITION = "there is one condition only"
    DAYS_TOO_DIFFERENT = "days differ too much more than {unit}s for comparisons within and between them to be joined"
    NO_DF_LEFT = "no degree of freedom is left to measure the scatter of the {unit}s by"
    NO_SCATTER_WITHIN_DAYS = "the {unit}s do not scatter at all within days"
    ONE_VALUE_A_DAY = "every day holds one {unit}, whose scatter is the days' and the {unit}s' together"
    ONE_DAY = "there is one day only, which tells nothing about other days"
    ONE_DAY_EACH = (
        "{a} and {b} were measured on one day each, so that their difference cannot be told from a difference between "
        "days"
    )
    ONE_RUN_EACH = (
        "{a} and {b} had one run each, so that their difference cannot be told from a difference between runs"
    )
    NO_DF = "it has no degrees of freedom"
    TEST_WITHOUT_DF = "the test has no degrees of freedom"
    BELOW_DOUBLES_IN_UNIT = "{what} is too small for a double: give the {unit}s in a smaller unit"
    BEYOND_DOUBLES_IN_UNIT = "{what} is too large for a double: give the {unit}s in a larger unit"
    BEYOND_DOUBLES = "{what} is too large for a double"
    MEANS_LEAVE_NO_DF = "the {of}s leave no degree of freedom to measure their scatter by"
    MEANS_WITHOUT_SCATTER = "the {of}s do not scatter at all"
    RUNS_DIFFER_IN_SIZE = "runs differ in size, or conditions change within some runs only"
    DAYS_DIFFER_IN_SIZE = "days differ in size, or only some conditions share days"
    NO_DAY_HOLDS_BOTH = "no day holds both {a} and {b}"
    NO_DAY_HOLDS_BOTH_ALIKE = "no day holds both {a} and {b} with all other factors alike"
    POSITION_NOT_FREE = "no day has runs alike at several positions to estimate a drift from"
    NO_DAY_WITH_TWO = "on the {n} day{s} with both, no day has two {unit}s of {of}"
    NO_GROUP_WITH_CLAIM = "in no group can treatment and control be compared within days"
    GROUP_WITHOUT_BOUNDS = "in a group the control's mean is not distinguishable from 0"
    ONE_GROUP = "there is one group only"
    CONTRAST_WITHOUT_RUNS = "no runs have what it compares"
    ONE_DAY_HOLDS_BOTH = "one day only holds both {a} and {b}"
    SAME_ON_EVERY_DAY = "{a} and {b} differ by as much on every day"
    NO_SHARED_DAY = "no day holds {unit}s of both groups"
    QUANTILE_BEYOND_DOUBLES = "Student's quantile at this level is too large for a double"
    NO_TWO_SAMPLES = "the record has no two samples of force"
    PLATE_NEVER_EMPTY = "the plate is never empty for {shortest_ms:g} ms, so that its zero is not known"
    PLATE_UNTOUCHED = "nothing presses on the plate by more than its noise of {noise_n:.2g} N"
    TOO_FEW_JUMPS_IN_A_ROW = "fewer than {needed} jumps follow each other on the plate"
    NO_QUIET_STANDING = "{found} of {n} flight{s} came from {quiet_s:g} s of quiet standing, which a single jump needs"
    NO_TAKE_OFF = "nothing leaves the plate moving upward"
    NO_ONSET = "the force does not change before take-off as the rule of onset {rule} says"
    THRESHOLD_ABOVE_WEIGHT = (
        "the rule of take-off asks for {threshold_n:.3g} N, which is not below the weight of {weight_n:.3g} N"
    )
    NO_LANDING = "the flight does not end on the plate within the record"
    NOT_COMPUTED = "it has not been computed"
    ALL_EQUAL = "all {unit}s are equal"
    NO_BOUND_ON_SIDE = "a one-sided comparison has no bound on this side"
    CONTROL_EMPTY = "the control is empty"
    OUTSIDE_DOUBLES = "it lies outside the range of doubles"
    NO_GROUP_OF_TWO = "no group has more than one {unit}"
    NO_GROUP_OF_TWO_TO_SCATTER = "no group has more than one {unit}, so that nothing measures the scatter"
    ALL_ALONE = "every {unit} has a condition or a day of its own"
    RESIDUALS_ZERO = "all residuals are 0"
    ONE_SHAPE = "with one degree of freedom all residuals of so many {unit}s have one shape"
    TOO_MANY_DRAWS = "so many residuals would take too many draws at a level so near 1"
    BAND_BEYOND_DOUBLES = "the band is too large for a double"
    NO_GROUP_SCATTERS = "no group has any scatter"
    NO_RATIO_OF_VARIANCES = "only the F-test of two groups has a ratio of variances"
    NO_RATIO = "there is no ratio"
    GROUPS_CONSTANT = "both groups are constant"
    GROUP_CONSTANT = "{group} is constant"
    RATIO_BY_ZERO = "{group} is constant, so that the ratio divides by 0"
    RATIO_OF_ZEROS = "both groups are constant, so that the ratio divides by 0"
    FEWER_THAN_TWO_GROUPS = "at least 2 groups are needed"
    DISTANCES_EQUAL = "the distances in a group of 2 are equal, and no group has more"
    SPREADS_EQUAL = "all {unit}s of a group lie equally far from its middle"
    FIT_EXACT = "the fit is exact, so that nothing measures the scatter"
    HELD_BY_NO_DOUBLE = "{what} beyond what a double can hold"
    AS_MANY_AS_COEFFICIENTS = "there are as many {unit}s as coefficients"
    NO_OWN_COLUMNS = "this fit has no columns of their own"
    ALL_Y_EQUAL = "all {unit}s of y are equal"
    ALL_CHARGES_EQUAL = "all charges are equal"
    INTERCEPT_NO_COLUMN = "the intercept is no column"
    FIT_WITHOUT_SCATTER = "the fit has no scatter"
    NOT_IDENTIFIED = "the data do not tell the parameters apart"
    NO_QUARTILE_RANGE = "the measured {unit}s have no interquartile range"
    RESIDUAL_BEYOND_DOUBLES = "a residual is too large for a double"
    FIT_IS_EXACT = "the fit is exact"
    CRITICAL_BEYOND_DOUBLES = "the critical value at so small an alpha is too large for a double"
    TWO_EACH_FOR_VARIANCE = "each group needs at least 2 {unit}s for its variance"
    TWO_EACH = "each group needs at least 2 {unit}s"
    TOO_FEW_FOR_POOLED_VARIANCE = "there are too few {unit}s for a pooled variance"
    NO_TRUE_DIFFERENCE = "the true difference is 0"
    DIFFERENCE_ON_OTHER_SIDE = (
        "the true difference {difference:g} lies below 0 and the one-sided test asks for one above"
    )
    TRUE_MEANS_EQUAL = "the true means are equal"
    NOT_BETWEEN_BOUNDS = "the true difference {difference:g} does not lie between the bounds {bounds}"
    NOT_BETWEEN_PERCENT = "the true difference of {percent} % does not lie between the bounds {bounds} %"
    SEARCH_ENDED = "the search ended at n = {largest}"
    ALPHA_TOO_SMALL = "alpha is too small for the quadrature over estimated variances"
    TOO_FEW_IDLE_RUNS = "the drain line needs at least {needed} idle runs and there are {n}"
    ONE_DURATION = "all idle runs have one duration and a line needs at least 2"
    NO_JUMP_MADE = "no jump was made"
    NO_CHARGE = "no charge recorded"
    SEVERAL_CHARGES = "{n} charges recorded"
    PART_OF_CHARGE = "of the parts of its charge the first is not recorded"
    NO_DURATION = "no duration recorded"
    NO_DRAIN_FIT = "no passive-drain fit for robot {robot}"
    NO_DRAIN_FIT_YET = "no passive-drain fit yet"
    NO_HEIGHT_LOG = "no log with a body_height channel"
    CALIBRATION_OF_OTHER_DAY = (
        "{file} was read with a calibration that does not hold on {day}, the run's date: `labbook files reread "
        "{quoted}`"
    )
    MORE_LOGS_THAN_STARTS = "{files} log files with a body_height channel and {n} start{s}"
    NO_FORCE_RECORD = "no force-plate record"
    SEVERAL_LEG_LENGTHS = "{n} logs have a leg length, and one is expected"
    SEVERAL_FORCE_RECORDS = "{n} force-plate records, and one is expected"
    FILE_WAITS = "{role} {name} waits for a declaration: {said} Then `labbook files reread {name}` with it"
    NO_CONTACT = "no contact begins and ends within the record"
    NO_TWO_OF_A_CONDITION = "no condition has two {of}s with {quantity} ({in_unit}) yet"
    ALL_CONDITIONS_CONSTANT = "the {quantity} of each condition do not differ at all"
    MEASURED_WITHOUT_INTERVAL = "the measured value has no interval"
    BOTH_EXACT = "neither value has an uncertainty"
    VARIED_WITHOUT_JUMP = "with another {source} the simulated robot does not jump"
    SIMULATED_ENDS_OTHERWISE = "the simulated jump ends otherwise: {ends}"
    JOULES_NOT_POSITIVE = "the battery gave {joules:.3g} J a hop: check its charge"
    NOT_SIMULATED = "no scene predicts it"
    SIMULATED_CONTROL_FREE = "the simulated control is free"
    SIMULATED_ENDED = "{ended}"
    NO_OUTPUT_WITHOUT = "no {output} without it"
    NO_OUTPUT_WITH = "no {output} with it"
    FULL_SCENE_ZERO = "the full scene's {output} is 0"
    DAYS_COUNT = "the day is the unit of analysis: n counts days"
    NO_CONTROL_YET = "no control has {quantity} yet: give {option}"
    PLAN_TOO_LARGE = "the plan would be too large to be drawn"
    NO_APEX_BOUNDS = "[analysis] sets no bounds of apex height"
    BOUNDS_IN_PERCENT = "the bounds are in percent and {reason}"
    NO_GROUPS = "at least 2 groups with values are needed"
    GROUP_EMPTY_LEAVE_OUT = "{group} is empty, and F of the others would answer another question: leave it out"
    GROUP_EMPTY_OF_FAMILY = "{group} is empty, and the family without it would be another: leave it out"
    TWO_WITHOUT_SCATTER = "groups {a!r} and {b!r} have no scatter, and with two such F has no limit"
    TOO_FEW_IN_A_ROW = "fewer than {needed} samples in a row after this stance"
    NO_TREATMENT = "there is no treatment"


_APART = (
    "Conditions and days are confounded: no day joins {listed}, so that a difference between these cannot be told from "
    "a difference between their days"
)
_BUT = " but by how much days of one condition differ ({n} degree{s} of freedom{single}): "
_REML_ZERO = (
    "REML puts that at 0, so that {counted} count as independent there, and p is too small if days differ all the same."
)


class Limit(Code):
    """What a comparison over days cannot decide, or leaves out of its model."""

    ONE_VALUE_A_DAY = (
        "Every day holds one {unit}, so that days and {unit}s scatter as one: the {unit}s are compared as they are."
    )
    ONE_VALUE_A_RUN = (
        "Every run holds one {unit}, so that runs and {unit}s scatter as one: the run is left out of the model."
    )
    ONE_RUN_A_DAY = "Every day holds one run, so that days and runs scatter as one: the run is left out of the model."
    DAYS_UNMEASURED = (
        _APART + ", and with one day each nothing measures how much days differ: measure the conditions on shared days."
    )
    DAYS_COUNT = _APART + _BUT + "each day counts as one observation there, however many {unit}s it holds."
    VALUES_DEPEND = _APART + _BUT + "the {unit}s of one day do not count as independent there, however many it holds."
    RUNS_COUNT = _APART + _BUT + _REML_ZERO.replace("{counted}", "runs")
    VALUES_COUNT = _APART + _BUT + _REML_ZERO.replace("{counted}", "{unit}s")
