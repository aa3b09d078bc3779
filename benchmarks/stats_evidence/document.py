"""`docs/statistics.md` and the tables beside it: what is measured anew, and what the page shows of it.

The page is written by hand but for what stands between markers, which is taken from the tables.
"""

from __future__ import annotations

import csv
import importlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import cast

from benchmarks.document import table_text
from benchmarks.section import Table
from benchmarks.stats_evidence.sizes.design import Design
from benchmarks.stats_evidence.sizes.record import design_of, every_rate
from benchmarks.stats_evidence.sizes.record import main as simulate

PAGE = Path(__file__).resolve().parents[2] / "docs" / "statistics.md"
FOLDER = PAGE.with_suffix("")
ERROR_RATES = "error_rates"
TABLES = ("digits", "weaknesses", ERROR_RATES, "speed")
"""Files of the folder: what `rows()` returns in the module `rows` of a folder here, and the error rates of `sizes`."""

Rows = Sequence[Mapping[str, str]]

SHOWN_DIGITS = (
    ("standard deviation, 9 sets", "standard deviation", "", ("scipy tstd", "statsmodels DescrStatsW", "")),
    (
        "F of an analysis of variance, 11 sets",
        "F",
        "",
        ("scipy f_oneway", "statsmodels anova_oneway", "pingouin anova"),
    ),
    (
        "coefficients of lines and polynomials, 11 sets",
        "worst coefficient",
        "",
        ("scipy.linalg.lstsq", "statsmodels OLS", "pingouin linear_regression"),
    ),
    *(
        (f"t, 20 and 20 values {far}", "t", offset, ("scipy ttest_ind", "statsmodels ttest_ind", "pingouin ttest"))
        for far, offset in (("1000 times their scatter from 0", "offset 1e3"), ("a million times", "offset 1e6"))
    ),
)
"""Row of the page, quantity, data (all where empty), and whose least digits are shown beside labbook's."""

SHOWN_WEAKNESSES = {
    ("W2", "Student's p"): "p of 0.1 three times against 0.1 seven times",
    ("W10", "Dunnett's p of b against a"): "Dunnett's p, a value of the group missing",
    ("W14", "standard deviation of 1000000 values"): "standard deviation of a million float32 voltages",
    ("W16", "slope, s"): "slope of a battery's voltage over Unix time, V/s",
    ("W20", "damping, v = -5 x"): "damping, where speed is a multiple of position",
    ("W22", "upper end of the interval of the difference"): "upper end of an interval of jump heights, m",
    ("W23", "p of two conditions over 3 days"): "p of two conditions over three days",
    ("W24", "F"): "F of three conditions measured three times a day",
}
"""Case and question, and what the page calls them."""

SHOWN_RATES = (
    ("5 and 20 runs, the few scatter twice as much", Design((5, 20), 2.0), ("Student", "student"), ("Welch", "welch")),
    ("the same", Design((5, 20), 2.0), ("F-test, then Student or Welch", "f_then_t"), ("Welch", "welch")),
    (
        "15 and 15 runs on three days, each group's own",
        Design((15, 15), 1.0, 3, 1.0, "own"),
        ("Welch on runs", "welch"),
        ("exact test by day", "blocked_by_day_exact"),
    ),
    (
        "9 and 30 runs on three shared days, the few scatter twice as much",
        Design((9, 30), 2.0, 3, 1.0, "shared"),
        ("exact test by day", "blocked_by_day_exact"),
        ("Welch on runs", "welch"),
    ),
    (
        "5, 10 and 20 runs, SD 3 : 1.7 : 1",
        Design((5, 10, 20), 3.0),
        ("analysis of variance", "one_way_anova"),
        ("Welch's", "welch_anova"),
    ),
    (
        "three groups against one of 5 runs, SD 1 against 3",
        Design((5, 10, 20, 40), 3.0),
        ("Dunnett", "dunnett"),
        ("Holm over Welch", "holm"),
    ),
    (
        "are variances equal? 25 and 25 skewed values",
        Design((25, 25), distribution="exponential"),
        ("F-test", "f_test"),
        ("Brown-Forsythe", "brown_forsythe"),
    ),
    (
        "95 % interval of a difference, 3 and 3 runs: covers",
        Design((3, 3)),
        ("bootstrap percentiles", "bootstrap_percentile"),
        ("Welch", "difference_ci_welch"),
    ),
)
"""Design in words, the design, a method that errs there, and one that hardly does."""


def measure(name: str) -> None:
    """Make one table anew; of the error rates only what is lacking."""
    if name == ERROR_RATES:
        simulate([])
        return
    module = importlib.import_module(f"benchmarks.stats_evidence.{name}.rows")
    write(name, cast(Callable[[], Rows], module.rows)())


def write(name: str, rows: Rows) -> None:
    """Write a table of the folder."""
    with (FOLDER / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read(name: str) -> Rows:
    """Return the rows of a table of the folder."""
    with (FOLDER / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def page(text: str) -> str:
    """Return the page with what stands between its markers taken from the tables."""
    shown = {
        "digits": digits_table(read("digits")),
        "weaknesses": weaknesses_table(read("weaknesses")),
        ERROR_RATES: error_rates_table(),
        "speed": speed_line(read("speed")),
    }
    for name, table in shown.items():
        before, first, rest = text.partition(f"<!-- from {name}.csv -->\n")
        _old, last, after = rest.partition("<!-- end -->")
        text = before + first + table + last + after
    return text


def digits_table(rows: Rows) -> str:
    """Return the least digits of a few quantities over NIST's sets, and at two offsets."""
    lines = []
    for words, quantity, data, programs in SHOWN_DIGITS:
        found = [row for row in rows if row["quantity"] == quantity and data in ("", row["data"])]
        of_all = ({row["digits"] for row in found if row["program"] == one} for one in ("labbook", *programs))
        lines.append((words, *(f"{min(map(float, digits)):.3g}" if digits else "" for digits in of_all)))
    return table_text(Table(("least correct digits", "labbook", "scipy", "statsmodels", "pingouin"), tuple(lines), ""))


def weaknesses_table(rows: Rows) -> str:
    """Return what other programs answer to a few questions, beside the truth."""
    lines = []
    for (case, question), words in SHOWN_WEAKNESSES.items():
        found = [row for row in rows if (row["case"], row["question"]) == (case, question)]
        wrong: dict[str, list[str]] = {}
        for row in found[1:]:
            wrong.setdefault(row["answer"], []).append(f"{row['program'].split()[0]} `{row['call']}`")
        said = "; ".join(f"{answer} ({', '.join(whose)})" for answer, whose in wrong.items())
        lines.append((f"{words} ({case})", found[0]["truth"], said))
    return table_text(Table(("asked", "right", "returned"), tuple(lines), ""))


def error_rates_table() -> str:
    """Return how often a method errs on a few designs, beside one that hardly does."""
    rates = {(row.method, design_of(row)): f"{row.value:.3f}".removeprefix("0") for row in every_rate()}
    lines = [
        (words, *(f"{name} {rates[method, design]}" for name, method in both)) for words, design, *both in SHOWN_RATES
    ]
    return table_text(Table(("design, no true effect", "errs", "better"), tuple(lines), ""))


def speed_line(rows: Rows) -> str:
    """Say what a comparison of two groups costs, and which function is slowest beside scipy."""
    over_scipy = [row for row in rows if row["program"] == "scipy"]
    two = next(row for row in over_scipy if row["function"] == "compare_two")
    slowest = max(over_scipy, key=lambda row: float(row["labbook_over_program"]))
    return (
        f"Comparing two groups of {two['values']} runs takes {float(two['labbook_us']) / 1000.0:.1f} ms, "
        f"{two['labbook_over_program']} of scipy's time for the same fields; at worst\n({slowest['function']}, "
        f"{slowest['values']} values) labbook takes {slowest['labbook_over_program']} times as long as scipy.\n"
    )
