"""`docs/statistics.md` and the tables beside it: what is measured anew, and what the page shows of it.

The page is written by hand but for what stands between markers, which is taken from the tables.
"""

from __future__ import annotations

import csv
import importlib
import os
import subprocess
import sys
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
DECISIONS = "decisions"
WORLDS = "worlds"
TABLES = ("digits", "weaknesses", ERROR_RATES, DECISIONS, WORLDS, "speed")
"""Files of the folder: what `rows()` returns in the module `rows` of a folder here, the error rates of `sizes`,
and what the long test of the decision finds."""
_YARDSTICK = "tests/stats/days/test_decision_yardstick.py"

Rows = Sequence[Mapping[str, str]]

SHOWN_DIGITS = (
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
)
"""Row of the page, quantity, data (all where empty), and whose least digits are shown beside labbook's."""

SHOWN_WEAKNESSES = {
    ("W10", "Dunnett's p of b against a"): "Dunnett's p, a value of the group missing",
    ("W14", "standard deviation of 1000000 values"): "standard deviation of a million float32 voltages",
    ("W20", "damping, v = -5 x"): "damping, where speed is a multiple of position",
    ("W24", "F"): "F of three conditions measured three times a day",
}
"""Case and question, and what the page calls them."""

SHOWN_RATES = (
    ("5 and 20 runs, the few scatter twice as much", Design((5, 20), 2.0), ("Student", "student"), ("Welch", "welch")),
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


SHOWN_LAYOUTS = (
    "5 days 4+11 3+11 3+11 4+12 2+5",
    "4 days 3+10",
    "3 days 12+2 3+20 1+28",
    "3 days 1+3",
    "2 days 3+10, 2 of AD",
    "1 day 8+20",
    "5 of CE, 5 of AD",
)
"""Layouts of days that the page shows; the file has all."""


SHOWN_WORLDS = (
    ("drift of 1 SD a day, controls first, 5 days", "5 %"),
    ("drift of 1 SD a day, random order, 5 days", "5 %"),
    ("charger's steps 1 mAh, SD of runs 0.5 %, 5 days", "5 %"),
    ("ten looks, none planned", "0 %"),
    ("five planned looks", "0 %"),
    ("2 groups on the same 6 days", "5 % and 0 %"),
    ("2 x 2 x 6: interaction with the foot, 5 days", "3 points"),
    ("2 x 2 x 6: trend for each 100 of gain, 5 days", "1.9 points"),
)
"""Worlds and true effects that the page shows; the file has all."""


def measure(name: str) -> None:
    """Make one table anew; of the error rates only what is lacking."""
    if name == ERROR_RATES:
        simulate([])
        return
    if name == DECISIONS:
        environment = {**os.environ, "LABBOOK_DECISIONS": str(FOLDER / f"{DECISIONS}.csv")}
        subprocess.run([sys.executable, "-m", "pytest", "-q", "-m", "soak", _YARDSTICK], env=environment, check=True)
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
        DECISIONS: decisions_table(read(DECISIONS)),
        WORLDS: worlds_table(read(WORLDS)),
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


def decisions_table(rows: Rows) -> str:
    """Return what the deciding test does on campaigns of each layout of days."""
    shares = ("coverage", "size", "equivalent_at_bound", "found")
    lines = [
        (row["layout"], row["rule"], *(f"{float(row[share]):.3f}"[1:] if row[share] else "" for share in shares))
        for row in rows
        if row["layout"] in SHOWN_LAYOUTS
    ]
    return table_text(
        Table(("runs of each day", "rule", "covers", "errs", "TOST errs", "finds 11 %"), tuple(lines), "")
    )


def worlds_table(rows: Rows) -> str:
    """Return what the first page says of simulated campaigns of known truth."""

    def share(text: str) -> str:
        return f"{float(text):.3f}".removeprefix("0") if text else ""

    lines = [
        (
            row["world"],
            row["truth"],
            share(row["coverage"]),
            share(row["finds"]),
            f"{share(row['warns'])}{' (needed)' if row['warning_needed'] == 'yes' else ''}",
        )
        for row in rows
        if (row["world"], row["truth"]) in SHOWN_WORLDS
    ]
    return table_text(Table(("world", "true effect", "covers", "claims it", "warns"), tuple(lines), ""))


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
