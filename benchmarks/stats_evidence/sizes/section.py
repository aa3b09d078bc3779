"""The chapter of docs/statistics.md on size and coverage, made from what is recorded."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from benchmarks.stats_evidence.sizes.method import standard_error
from benchmarks.stats_evidence.sizes.record import design_of
from benchmarks.stats_evidence.sizes.registry import METHODS
from stats.recorded import ERRORS, FILE, LEAST_COVERAGE, MOST_SIZE, Recorded, recorded

NAMES = {
    "f_test": "F-test",
    "bartlett": "Bartlett",
    "levene": "Levene",
    "brown_forsythe": "Brown-Forsythe",
    "f_ratio_ci": "ratio of variances (F)",
    "f_then_t": "F-test, then Student or Welch",
    "student": "Student",
    "welch": "Welch",
    "permutation": "permutation",
    "equivalence": "equivalence, Welch",
    "equivalence_student": "equivalence, Student",
    "equivalence_percent": "equivalence in percent",
    "one_way_anova": "ANOVA",
    "welch_anova": "Welch ANOVA",
    "tukey": "Tukey and Kramer",
    "games_howell": "Games-Howell",
    "dunnett": "Dunnett",
    "holm": "Holm over Welch's tests",
    "difference_ci_f_then_t": "difference, F-test first",
    "difference_ci_student": "difference, Student",
    "difference_ci_welch": "difference, Welch",
    "hedges_g_ci": "Hedges's g",
    "eta_squared_ci": "eta and omega squared",
    "fieller": "savings, Fieller",
    "delta": "savings, delta",
    "log_ratio": "savings, logarithm",
    "bootstrap": "difference, studentised bootstrap",
    "bootstrap_bca": "difference, BCa bootstrap",
    "mean_ci": "mean",
    "fit_linear_ci": "slope of a line",
    "blocked_by_day": "mixed model",
    "blocked_by_day_exact": "exact test",
    "blocked_by_day_ci": "difference, mixed model",
}
LAYOUTS = {
    "shared": "shared",
    "own": "each condition's own",
    "partly": "the first shared, the others each condition's own",
    "mostly": "shared but the last, which is each condition's own",
    "holes": "shared, 40 % of values missing",
    "runs": "shared, two runs each",
}
SHOWN_TIMES, SHOWN_POOLED_TIMES = (3, 6, 10), (5, 10)
"""Values a day of the designs over days that are printed; the rest stands in the record."""
VARIANCE_TESTS = ("f_test", "bartlett", "levene", "brown_forsythe")
TWO_MEANS = (
    *("f_then_t", "student", "welch", "permutation"),
    *("equivalence", "equivalence_student", "equivalence_percent"),
)
MANY_MEANS = ("one_way_anova", "welch_anova", "tukey", "games_howell", "dunnett", "holm")
INTERVALS = (
    *("difference_ci_f_then_t", "difference_ci_student", "difference_ci_welch", "bootstrap", "bootstrap_bca"),
    *("hedges_g_ci", "eta_squared_ci", "fieller", "delta", "log_ratio", "fit_linear_ci"),
)
BY_DISTRIBUTION = ("mean_ci", "f_ratio_ci")
MODELS = ("blocked_by_day", "blocked_by_day_exact", "blocked_by_day_ci", "permutation", "bootstrap")
POOLED = (
    *("f_then_t", "student", "welch", "one_way_anova", "equivalence", "equivalence_percent"),
    *("difference_ci_f_then_t", "difference_ci_welch", "fieller"),
)
Label = Callable[[Recorded], str]


def section() -> list[str]:
    """Return the chapter in lines of Markdown."""
    rows = recorded()
    plain = [row for row in rows if row.days is None]
    two = [row for row in plain if len(row.n) == 2]
    days = [row for row in rows if row.days is not None]
    few = [row for row in days if int(_times(row)) in SHOWN_TIMES]
    pooled = [row for row in days if row.method in POOLED and int(_times(row)) in SHOWN_POOLED_TIMES]
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
        "normality as much as of variance; Brown and Forsythe's test never errs too often, and at three to five values "
        "hardly ever finds anything.",
        "",
        *_table(_of(two, VARIANCE_TESTS), {"test": _name, "values": _distribution}, _sizes),
        "",
        "### Tests of two means (size)",
        "",
        "The SD ratio is that of the first group to the second. Student's test and the route through the F-test err "
        "where the smaller group scatters more; Welch's errs at 3 values against 10. The tests of equivalence are "
        "taken with the truth on a bound.",
        "",
        *_table(_of(two, TWO_MEANS), {"test": _name, "SD ratio": _ratio}, _sizes),
        "",
        "### Tests of several means (size)",
        "",
        "Three groups, four for Dunnett (the first is the control) and for Holm (three treatments against one control, "
        "Welch's tests); the SDs lie on equal ratios from the first group to the last. Counted is any rejection in the "
        "family.",
        "",
        *_table(_of(plain, MANY_MEANS), {"test": _name, "SD ratio": _ratio}, _sizes),
        "",
        "### Intervals (coverage)",
        "",
        "Hedges's g at a true 0.8, eta squared of three means 0.5 SD apart each, savings of 30 % where the larger "
        "coefficient of variation is 0.2. The slope's SD ratio is that of the scatter at the end of the line to that "
        "at its start.",
        "",
        *_table(_of(plain, INTERVALS), {"interval": _name, "SD ratio": _ratio}, _sizes),
        "",
        *_table(_of(plain, BY_DISTRIBUTION), {"interval": _name, "values": _distribution}, _sizes),
        "",
        "### Conditions over days",
        "",
        "Two or three conditions, each measured so often on each of its days. The permutation test and the bootstrap "
        "shuffle and redraw within days. Days differ with the SD given, runs of a day with 1. The exact test has "
        "its size whatever days do. The mixed model is the same test where it finds that days differ; where it puts "
        "their variance at 0 it takes days and values together, which on days of each condition's own makes it err too "
        "rarely if days do not differ, and a little too often if they do and are two. Both take all conditions to "
        "scatter alike: where one of three has twice the SD, intervals of its differences cover 0.91 to 0.92. Two "
        "conditions that share one day of several, or all but one, stand for designs between shared days and own ones: "
        "there the mixed model errs too often, the more so the fewer days there are and are shared.",
        "",
        *_over_days(_of(few, MODELS)),
        "",
        "The same days ignored: all values compared as if each told something new. With days of their own a test finds "
        "the days and an interval misses the truth; one day in common of several mends the smaller part of it, and one "
        "day that is not in common still tells with ten values a day. On "
        "shared days a test errs too rarely and so overlooks effects.",
        "",
        *_over_days(pooled),
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
        "The bootstrap, shuffles within days or of more than 200 000 arrangements, and the mixed model where values "
        "are missing or lie in runs or conditions share one day of several are the library's own calls, study by "
        "study; all else is computed over arrays of studies, by formulas that the tests hold to the library's "
        "functions to 1e-12. "
        "`python benchmarks/stats_evidence/sizes/record.py` makes rows that are missing.",
        "",
        "Three things decide more than all the rest: days that differ and are not in the analysis, a smaller group "
        "that scatters more, and an F-test of variances on values that are not normal. Hence reports show Welch's test "
        "beside any other and Brown and Forsythe's beside the F-test. Where each condition had one day of its own the "
        "comparison by day gives no p; t-tests and tests of equivalence give theirs and savings their interval all the "
        "same, and the report says how far these are off on such days. The worst of every method that needs a sentence "
        "at all:",
    ]


def _worst(rows: Sequence[Recorded]) -> list[str]:
    lines = ["| method | size or coverage at its worst | where |", "|---|---|---|"]
    for method in dict.fromkeys(row.method for row in rows):
        weak = [row for row in rows if row.method == method and row.weak]
        for among in ([row for row in weak if row.days is None], [row for row in weak if row.days is not None]):
            if among:
                row = max(among, key=lambda row: abs(row.value - row.nominal))
                lines.append(f"| {NAMES[method]} | {row.kind} {_share(row)} | {where(row)} |")
    return lines


def where(row: Recorded) -> str:
    """Return the design of a row in words."""
    parts = [f"n = {_sizes(row)}" if len(set(row.n)) > 1 or len(row.n) == 1 else f"n = {row.n[0]} each"]
    if row.distribution != "normal":
        parts.append(f"{_distribution(row)} values")
    if row.sd_ratio != 1.0:
        parts.append(f"SD ratio {_ratio(row)}")
    if row.days is not None:
        parts.append(f"{row.days} day{'' if row.days == 1 else 's'} ({_layout(row)}), SD of days {row.day_sd:g}")
    return ", ".join(parts)


def _over_days(rows: Sequence[Recorded]) -> list[str]:
    down = {
        "method": _name,
        "conditions": _conditions,
        "days": _layout,
        "SD of days": _day_sd,
        "SD ratio": _ratio,
        "values a day": _times,
    }
    return _table(rows, down, lambda row: f"{row.days} d")


def _of(rows: Sequence[Recorded], methods: Sequence[str]) -> list[Recorded]:
    return [row for method in methods for row in rows if row.method == method]


def _table(rows: Sequence[Recorded], down: Mapping[str, Label], across: Label) -> list[str]:
    heads = list(dict.fromkeys(map(across, rows)))
    cells: dict[tuple[str, ...], dict[str, str]] = {}
    for row in rows:
        label = tuple(say(row) for say in down.values())
        cells.setdefault(label, {})[across(row)] = _share(row)
    lines = [f"| {' | '.join((*down, *heads))} |", "|" + "---|" * (len(down) + len(heads))]
    for label, shares in cells.items():
        lines.append(f"| {' | '.join((*label, *(shares.get(head, '') for head in heads)))} |")
    return lines


def _share(row: Recorded) -> str:
    text = f"{row.value:.3f}".removeprefix("0")
    return f"**{text}**" if row.weak else text


def _sizes(row: Recorded) -> str:
    if len(set(row.n)) == 1:
        return str(row.n[0])
    return ", ".join(map(str, row.n[:3])) + (" …" if len(row.n) > 3 else "")


def _conditions(row: Recorded) -> str:
    return str(len(row.n))


def _name(row: Recorded) -> str:
    return NAMES[row.method]


def _ratio(row: Recorded) -> str:
    return f"{row.sd_ratio:g}"


def _distribution(row: Recorded) -> str:
    return row.distribution


def _layout(row: Recorded) -> str:
    return LAYOUTS[row.layout]


def _day_sd(row: Recorded) -> str:
    return f"{row.day_sd:g}"


def _times(row: Recorded) -> str:
    return str(row.n[0] // (row.days or 1))
