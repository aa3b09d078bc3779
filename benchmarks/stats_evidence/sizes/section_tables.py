"""Rows of the record as tables of the chapter on size and coverage, and a design in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from benchmarks.stats_evidence.sizes.design import FURTHER_PAIRS, FURTHER_TRIPLES
from stats.planning.recorded import Recorded

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
    "dunnett_greater": "Dunnett, one-sided",
    "holm": "Holm over Welch's tests",
    "difference_ci_f_then_t": "difference, F-test first",
    "difference_ci_student": "difference, Student",
    "difference_ci_welch": "difference, Welch",
    "hedges_g_ci": "Hedges's g",
    "eta_squared_ci": "eta and omega squared",
    "welch_eta_squared_ci": "eta and omega squared, Welch",
    "equivalence_percent_ci": "difference in percent, Welch",
    "equivalence_percent_student": "equivalence in percent, Student",
    "equivalence_percent_student_ci": "difference in percent, Student",
    "fieller": "savings, Fieller",
    "delta": "savings, delta",
    "log_ratio": "savings, logarithm",
    "bootstrap": "difference, studentised bootstrap",
    "bootstrap_bca": "difference, BCa bootstrap",
    "bootstrap_percentile": "difference, bootstrap percentiles",
    "mean_ci": "mean",
    "fit_linear_ci": "slope of a line",
    "fit_linear_intercept_ci": "intercept of a line",
    "fit_linear_at_ci": "line at its end",
    "fit_polynomial_ci": "bend of a parabola",
    "fit_polynomial_at_ci": "parabola at its end",
    "blocked_by_day": "mixed model",
    "blocked_by_day_exact": "exact test",
    "blocked_by_day_ci": "difference, mixed model",
    "blocked_by_day_mean_ci": "mean, mixed model",
    "blocked_by_day_exact_ci": "difference, exact test",
    "blocked_by_day_exact_ci_six_idle_runs": "difference, exact test, six idle runs",
    "blocked_by_day_ci_six_idle_runs": "difference, mixed model, six idle runs",
    "blocked_by_day_lmertest": "mixed model, as lmerTest",
    "mean_ci_shared": "mean",
    "difference_ci_f_then_t_shared": "difference, F-test first",
    "difference_ci_welch_shared": "difference, Welch",
    "fieller_shared": "savings, Fieller",
    "delta_shared": "savings, delta",
    "log_ratio_shared": "savings, logarithm",
    "f_then_t_shared": "F-test, then Student or Welch (size)",
    "welch_shared": "Welch (size)",
    "student_shared": "Student (size)",
    "difference_ci_student_shared": "difference, Student",
    **{
        f"{line}_{of}_ci": f"{said}, {words}"
        for line, said in (
            ("passive_drain", "passive drain"),
            ("passive_drain_in_steps", "passive drain told in steps"),
            ("gain_line", "stiffness over gain"),
            ("packing", "packing"),
        )
        for of, words in (
            ("slope", "slope"),
            ("intercept", "intercept"),
            ("middle", "in its middle"),
            ("at", "at its end"),
        )
    },
    **{
        f"{fit}_{what}": f"{said}, {words}"
        for fit, said in (
            ("fit_linear_of_two", "plane"),
            ("fit_linear_through_0", "line through 0"),
            ("fit_polynomial_cubic", "cubic"),
        )
        for what, words in (("ci", "last coefficient"), ("f_test", "F-test (size)"))
    },
    "stiffness_ci": "stiffness",
    "damping_ci": "damping",
}
LAYOUTS = {
    "shared": "shared",
    "own": "each condition's own",
    "partly": "the first shared, the others each condition's own",
    "mostly": "shared but the last, which is each condition's own",
    "holes": "shared, 40 % of values missing",
    "runs": "shared, two runs each",
}
Label = Callable[[Recorded], str]
_FURTHER = {*FURTHER_PAIRS, *FURTHER_TRIPLES, (6, 6), (6, 6, 6), (2, 2, 2), (2, 4, 8)}


def where(row: Recorded) -> str:
    """Return the design of a row in words."""
    parts = [f"n = {sizes(row)}{' each' if len(set(row.groups)) == 1 < len(row.groups) else ''}"]
    if row.idle_runs:
        parts.append(f"{row.idle_runs} idle runs")
    if row.distribution != "normal":
        parts.append(f"{distribution(row)} values")
    if row.sd_ratio != 1.0:
        parts.append(f"SD ratio {ratio(row)}")
    if row.days is not None:
        parts.append(f"{row.days} day{'' if row.days == 1 else 's'} ({_layout(row)}), SD of days {row.day_sd:g}")
    return ", ".join(parts)


def over_days(rows: Sequence[Recorded]) -> list[str]:
    """Return a table of methods over days, a column for each number of days."""
    down = {
        "method": name,
        "conditions": _conditions,
        "days": _layout,
        "SD of days": _day_sd,
        "SD ratio": ratio,
        "values a day": times,
    }
    return table(rows, down, lambda row: f"{row.days} d")


def of_methods(rows: Sequence[Recorded], methods: Sequence[str]) -> list[Recorded]:
    """Return the rows of these methods, in their order."""
    return [row for method in methods for row in rows if row.method == method]


def by_sizes(rows: Sequence[Recorded], down: Mapping[str, Label]) -> list[str]:
    """Return tables with a column for the sizes of groups: the common ones, then those between and beyond."""
    further = [row for row in rows if row.n in _FURTHER]
    common = [row for row in rows if row.n not in _FURTHER]
    return table(common, down, sizes) + (["", *table(further, down, sizes)] if further else [])


def table(rows: Sequence[Recorded], down: Mapping[str, Label], across: Label) -> list[str]:
    """Return a table in Markdown with these labels down the side and a column for each label across."""
    heads = list(dict.fromkeys(map(across, rows)))
    cells: dict[tuple[str, ...], dict[str, str]] = {}
    for row in rows:
        label = tuple(say(row) for say in down.values())
        cells.setdefault(label, {})[across(row)] = share(row)
    lines = [f"| {' | '.join((*down, *heads))} |", "|" + "---|" * (len(down) + len(heads))]
    for label, shares in cells.items():
        lines.append(f"| {' | '.join((*label, *(shares.get(head, '') for head in heads)))} |")
    return lines


def share(row: Recorded) -> str:
    """Return the share, bold where it is a weak point."""
    text = f"{row.value:.3f}".removeprefix("0")
    return f"**{text}**" if row.weak else text


def sizes(row: Recorded) -> str:
    """Return the group sizes: one number where all are alike."""
    if len(set(row.groups)) == 1:
        return str(row.groups[0])
    return ", ".join(map(str, row.groups[:3])) + (" …" if len(row.groups) > 3 else "")


def idle_runs(row: Recorded) -> str:
    """Return how many idle runs the line goes through."""
    return str(row.idle_runs)


def _conditions(row: Recorded) -> str:
    return str(len(row.n))


def name(row: Recorded) -> str:
    """Return the method in words."""
    return NAMES[row.method]


def ratio(row: Recorded) -> str:
    """Return the ratio of standard deviations."""
    return f"{row.sd_ratio:g}"


def distribution(row: Recorded) -> str:
    """Return what the values were drawn from."""
    return row.distribution


def _layout(row: Recorded) -> str:
    return LAYOUTS[row.layout]


def _day_sd(row: Recorded) -> str:
    return f"{row.day_sd:g}"


def times(row: Recorded) -> str:
    """Return how many values a group has a day: one number where all have as many."""
    found = [str(n // (row.days or 1)) for n in row.n]
    return found[0] if len(set(found)) == 1 else ", ".join(found)
