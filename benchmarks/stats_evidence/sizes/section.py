"""The chapter of docs/statistics.md on size and coverage, made from what is recorded."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.stats_evidence.sizes import lines, planes, several_columns, with_shared
from benchmarks.stats_evidence.sizes.method import standard_error
from benchmarks.stats_evidence.sizes.record import design_of
from benchmarks.stats_evidence.sizes.registry import METHODS
from benchmarks.stats_evidence.sizes.section_tables import (
    NAMES,
    by_sizes,
    distribution,
    idle_runs,
    name,
    of_methods,
    over_days,
    ratio,
    share,
    sizes,
    table,
    times,
    where,
)
from stats.planning.recorded import ERRORS, FILE, LEAST_COVERAGE, MOST_SIZE, Recorded, recorded

SHOWN_TIMES, SHOWN_POOLED_TIMES, SHOWN_ELSE_TIMES = ("3", "6", "10", "3, 10"), ("5", "10"), ("5",)
"""Values a day of the designs over days that are printed; the rest stands in the record."""
VARIANCE_TESTS = ("f_test", "bartlett", "levene", "brown_forsythe")
TWO_MEANS = (
    *("f_then_t", "student", "welch", "permutation"),
    *("equivalence", "equivalence_student", "equivalence_percent", "equivalence_percent_student"),
)
MANY_MEANS = ("one_way_anova", "welch_anova", "tukey", "games_howell", "dunnett", "dunnett_greater", "holm")
INTERVALS = (
    *("difference_ci_f_then_t", "difference_ci_student", "difference_ci_welch", "bootstrap", "bootstrap_bca"),
    *("bootstrap_percentile", "hedges_g_ci", "eta_squared_ci", "welch_eta_squared_ci"),
    *("equivalence_percent_ci", "equivalence_percent_student_ci", "fieller", "delta", "log_ratio"),
    *("fit_linear_ci", "fit_linear_intercept_ci", "fit_linear_at_ci", "fit_polynomial_ci", "fit_polynomial_at_ci"),
)
BY_DISTRIBUTION = ("mean_ci", "f_ratio_ci")
LINES = tuple(method.name for method in lines.METHODS)
PLANES = tuple(method.name for method in planes.METHODS)
COLUMNS = tuple(method.name for method in several_columns.METHODS)
WITH_LINE = tuple(method.name for method in with_shared.METHODS)
MODELS = (
    *("blocked_by_day", "blocked_by_day_exact", "blocked_by_day_ci", "blocked_by_day_mean_ci"),
    *("permutation", "bootstrap", "bootstrap_bca", "bootstrap_percentile"),
    *("blocked_by_day_exact_ci", "blocked_by_day_exact_ci_six_idle_runs", "blocked_by_day_ci_six_idle_runs"),
    "blocked_by_day_lmertest",
)
POOLED = (
    *("f_then_t", "student", "welch", "one_way_anova", "equivalence", "equivalence_percent"),
    *("difference_ci_f_then_t", "difference_ci_welch", "fieller"),
)
"""What reports use; of the other methods that know no days fewer designs are printed."""
POOLED_ELSE = (
    *(*VARIANCE_TESTS, "f_ratio_ci", "equivalence_student", "difference_ci_student", "hedges_g_ci"),
    *("delta", "log_ratio", *MANY_MEANS[1:], "eta_squared_ci", "welch_eta_squared_ci"),
    *("equivalence_percent_student", "equivalence_percent_ci", "equivalence_percent_student_ci", "mean_ci"),
)


def section() -> list[str]:
    """Return the chapter in lines of Markdown."""
    rows = recorded()
    plain = [row for row in rows if row.days is None]
    two = [row for row in plain if len(row.n) == 2]
    return [
        "## Size of every test, coverage of every interval",
        "",
        *_introduction(rows),
        "",
        *_worst(rows),
        "",
        "### Tests of equal variances (size)",
        "",
        "Two groups of the sizes above each column, without any difference of scatter. F and Bartlett are tests of "
        "normality as much as of variance. Brown and Forsythe's test errs too often only where two values stand "
        "against three or four, or all groups have four (0.06 to 0.14), and at three and at five hardly ever finds "
        "anything.",
        "",
        *by_sizes(of_methods(two, VARIANCE_TESTS), {"test": name, "values": distribution}),
        "",
        "### Tests of two means (size)",
        "",
        "The SD ratio is that of the first group to the second. Student's test and the route through the F-test err "
        "where the smaller group scatters more, the more so the smaller it is; Welch's errs where two or three values "
        "stand against more. The tests of equivalence are taken with the truth on a bound.",
        "",
        *by_sizes(of_methods(two, TWO_MEANS), {"test": name, "SD ratio": ratio}),
        "",
        "### Tests of several means (size)",
        "",
        "Three groups, four for Dunnett (the first is the control) and for Holm (three treatments against one control, "
        "Welch's tests); the SDs lie on equal ratios from the first group to the last. Counted is any rejection in the "
        "family.",
        "",
        *by_sizes(of_methods(plain, MANY_MEANS), {"test": name, "SD ratio": ratio}),
        "",
        "### Intervals (coverage)",
        "",
        "Hedges's g at a true 0.8, eta squared of three means 0.5 SD apart each (omega squared has the same interval, "
        "as it estimates the same share), savings of 30 % where the larger coefficient of variation is 0.2. The SD "
        "ratio of a line or a parabola is that of the scatter at its end to that at its start: the interval of the "
        "fitted response at the end takes the scatter there for that of all values, and covers less the more values "
        "say so. BCa and plain percentiles of the bootstrap cover too rarely for ten values a group and fewer, "
        "the more so for groups of unequal size; the studentised interval hardly does.",
        "",
        *by_sizes(of_methods(plain, INTERVALS), {"interval": name, "SD ratio": ratio}),
        "",
        *table(of_methods(plain, BY_DISTRIBUTION), {"interval": name, "values": distribution}, sizes),
        "",
        *_lines(plain),
        "",
        *_conditions_over_days(rows),
    ]


def _lines(plain: Sequence[Recorded]) -> list[str]:
    return [
        "### Lines and planes (coverage, and size of F-tests)",
        "",
        "Passive drain over durations, stiffness over gain, the packing of beads over the container's size: the SD "
        "ratio is that of the scatter at the line's end to that at its start. A drain told in steps is that of idle "
        "runs that scatter by 0.3 of the charger's steps, wherever on them the line lies: the rounding is scatter to "
        "the interval, which counts on at least the root of 1 / 12 of a step and so covers too often where runs are "
        "few. Fits of several columns have true coefficients of 0; the interval is that of the last one, the test "
        "that of all but the intercept.",
        "",
        *table(of_methods(plain, (*LINES, *COLUMNS)), {"interval or test": name, "SD ratio": ratio}, sizes),
        "",
        "A plane of stiffness and damping takes neighbouring points for independent. Where their scatter has a "
        "correlation of 0.5 (lag1) its intervals cover 0.74, as standard errors that are too small by the root of "
        "(1 + r) / (1 - r) make them; `residual_lag1` is there to tell.",
        "",
        *table(of_methods(plain, PLANES), {"interval": name, "values": distribution, "SD ratio": ratio}, sizes),
        "",
        "### With the error of the drain line (coverage, and size of the tests)",
        "",
        "All runs are corrected with one line through idle runs that scatter as the treated runs do; the treated ones "
        "last longer than the control's, so that the error of the slope does not cancel. Up to five idle runs leave so "
        "few degrees of freedom that intervals are made to cover more than they state. With six they cover up to a "
        "point too little where many runs leave the line's error the larger part; with twelve they are those of the "
        "same method without a line, nearly.",
        "",
        *table(of_methods(plain, WITH_LINE), {"method": name, "SD ratio": ratio, "idle runs": idle_runs}, sizes),
    ]


def _conditions_over_days(rows: Sequence[Recorded]) -> list[str]:
    days = [row for row in rows if row.days is not None]
    few = [row for row in days if times(row) in SHOWN_TIMES]
    pooled = [row for row in days if row.method in POOLED and times(row) in SHOWN_POOLED_TIMES]
    others = [row for row in days if times(row) in SHOWN_ELSE_TIMES]
    return [
        "### Conditions over days",
        "",
        "Two or three conditions, each measured so often on each of its days. The permutation test and the bootstrap "
        "shuffle and redraw within days. Days differ with the SD given, runs of a day with 1. The exact test has "
        "its size whatever days do. The mixed model is the same test where it finds that days differ; where it puts "
        "their variance at 0 it takes days and values together, which on days of each condition's own makes it err too "
        "rarely if days do not differ, and too often if they do and are two (0.06; 0.09 with 3 values a day against "
        "10). Both take all conditions to scatter alike: where SDs of three are as 2 : 1.4 : 1, intervals of its "
        "differences cover 0.91 to 0.92, with values missing 0.89 to 0.92; where of two on shared days one has twice "
        "the SD hardly anything is lost if both have as many values, while one with 3 values a day against 10 errs in "
        "some 0.17 of studies if it is the one that scatters more (intervals cover 0.83), and in 0.01 if it is the "
        "other. The mixed model's interval of one condition's mean is for days drawn at random: on shared days that "
        "differ as values do it covers 0.87 to 0.90 where they are two, 0.91 to 0.95 from three on, and down to 0.89 "
        "where values are missing. Two "
        "conditions that share one day of several, or all but one, stand for designs between shared days and own ones: "
        "there the mixed model errs too often, the more so the fewer days there are and are shared.",
        "",
        *over_days(of_methods(few, MODELS)),
        "",
        "The same days ignored: all values compared as if each told something new. With days of their own a test finds "
        "the days and an interval misses the truth; one day in common of several mends the smaller part of it, and one "
        "day that is not in common still tells with ten values a day. On shared days a test errs too rarely and so "
        "overlooks effects.",
        "",
        *over_days(pooled),
        "",
        "The other methods that know no days, with five values a day. Families of comparisons, intervals and Welch's "
        "analysis of variance take days for groups as the tests above do. One day, whosever it is, leaves tests of "
        "equal variances as they are without days; on several days of its own a group scatters as these few days do, "
        "and F, Bartlett, Levene and Brown and Forsythe's test find unequal variances that are those of days. The "
        "effects of Hedges's g and eta squared are in standard deviations that values of so many days have together; "
        "on shared days these are in the scatter and not in the differences, and with 25 values a day the intervals "
        "cover 0.90 to 0.93 and 0.84 to 0.89. "
        "The mean is that of one group, for days drawn at random.",
        "",
        *over_days(of_methods(others, POOLED_ELSE)),
    ]


def _introduction(rows: Sequence[Recorded]) -> list[str]:
    exact = {(one.name, one.kind, design) for one in METHODS for design in one.designs if one.exact(design)}
    errors = [
        abs(row.value - row.nominal) / standard_error(row.nominal, row.runs)
        for row in rows
        if (row.method, row.kind, design_of(row)) in exact
    ]
    least, most = min(row.runs for row in rows), max(row.runs for row in rows)
    return [
        f"`{FILE.name}` in the package `stats` holds {len(rows)} rows, one for each method on each design: the share "
        "of studies without an effect that a test of level 0.05 rejects, or the share in which an interval of level "
        f"0.95 holds the truth, of {least} to {most} studies a row, drawn with a seed of its own. A share near 0.05 or "
        f"0.95 has a Monte-Carlo error of {standard_error(0.05, most):.4f} where {most} studies were drawn, "
        f"{standard_error(0.05, least):.4f} where {least}. Where a method is exact for what was drawn "
        f"({len(errors)} rows) its share lies within {max(errors):.1f} such errors of the stated one; elsewhere the "
        f"share here is what the method does. Bold is a size above {MOST_SIZE:g} or a coverage below "
        f"{LEAST_COVERAGE:g} by more than {ERRORS:g} errors of the share: a report that uses the method on a design "
        "like this one says so in a sentence, with the number.",
        "",
        "The bootstrap, shuffles within several days or of more than 200 000 arrangements, and the mixed model where "
        "values are missing or lie in runs, or conditions share some of their days only or have days of their own and "
        "are measured unequally often, are the library's own calls, study by study; all else is computed over arrays "
        "of studies, by formulas that the tests hold to the library's functions to 1e-12. "
        "`python benchmarks/stats_evidence/sizes/record.py` makes rows that are missing.",
        "",
        "Three things decide more than all the rest: days that differ and are not in the analysis, a smaller group "
        "that scatters more, and an F-test of variances on values that are not normal. Hence reports show Welch's test "
        "beside any other and Brown and Forsythe's beside the F-test. Where each condition had one day of its own the "
        "comparison by day gives no p; t-tests and tests of equivalence give theirs and savings their interval all the "
        "same, with a sentence that they cannot tell the conditions from their days, and the report says how far they "
        "are off on such days. The worst of every method that needs a sentence at all:",
    ]


def _worst(rows: Sequence[Recorded]) -> list[str]:
    lines = ["| method | size or coverage at its worst | where |", "|---|---|---|"]
    for method in dict.fromkeys(row.method for row in rows):
        weak = [row for row in rows if row.method == method and row.weak]
        for among in ([row for row in weak if row.days is None], [row for row in weak if row.days is not None]):
            if among:
                row = max(among, key=lambda row: abs(row.value - row.nominal))
                lines.append(f"| {NAMES[method]} | {row.kind} {share(row)} | {where(row)} |")
    return lines
