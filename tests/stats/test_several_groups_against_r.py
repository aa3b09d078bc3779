"""Several groups against R (ptukey, t.test, p.adjust): r/several_groups.R."""

import csv
from collections import defaultdict
from pathlib import Path

import pytest
from scipy.stats import studentized_range

from stats.compare.equivalence import equivalence
from stats.groups.multiple import holm
from stats.groups.tukey import compare_all_pairs, range_tail

CASES = {
    "equal": {
        "CE": [42.1, 39.8, 44.0, 41.5, 43.2],
        "AD50": [36.9, 38.2, 35.1, 37.7, 36.0],
        "AD100": [37.0, 39.5, 38.1, 36.2, 40.3],
        "AD150": [41.0, 40.2, 43.9, 42.2, 39.1],
    },
    "unequal": {
        "CE": [42.1, 39.8, 44.0, 41.5, 43.2, 40.7, 42.9],
        "AD50": [36.9, 38.2, 35.1],
        "AD100": [37.0, 39.5, 48.1, 31.2, 40.3],
        "AD150": [41.0, 40.2, 43.9, 42.2, 39.1, 42.0, 41.1, 40.9],
    },
    "little": {"a": [1.01, 1.02, 1.04], "b": [1.00, 1.05, 1.03], "c": [1.02, 1.01, 1.05]},
}
R: dict[tuple[str, str], dict[str, float]] = defaultdict(dict)
with (Path(__file__).parent / "r" / "several_groups.csv").open() as rows:
    for row in csv.DictReader(rows):
        R[row["case"], row["method"]][row["name"]] = float(row["value"])
EACH = pytest.mark.parametrize("case", CASES)


@EACH
def test_games_howell(case):
    """R's ptukey is off by 1e-6 to 1e-4 at the few degrees of freedom here; scipy's range (slow) is not."""
    for pair in compare_all_pairs(CASES[case], variances="unequal").pairs:
        assert pair.p == pytest.approx(R[case, "games_howell_p"][f"{pair.b}-{pair.a}"], abs=2e-5)
        assert pair.p == pytest.approx(studentized_range.sf(pair.q, len(CASES[case]), pair.df), rel=1e-11)


@EACH
def test_two_one_sided_tests(case):
    b, a = list(CASES[case].values())[:2]
    found = equivalence(a, b, low=-4.0, high=4.0)
    for name, test in (("welch", found.welch), ("student", found.student)):
        assert test.p_low == pytest.approx(R[case, "tost_low"][name], rel=1e-9)
        assert test.p_high == pytest.approx(R[case, "tost_high"][name], rel=1e-9)
        ends = (R[case, "tost_ci_low"][name], R[case, "tost_ci_high"][name])
        assert test.estimate_ci == pytest.approx(ends, rel=1e-9, abs=1e-13)


def test_holm():
    p = {"a": 0.01, "b": 0.04, "c": 0.03, "d": 0.005, "e": 0.04, "f": 1e-200}
    found = holm(p, "six tests")
    assert dict(zip(found.names, found.adjusted_p, strict=True)) == pytest.approx(R["p_values", "holm"], rel=1e-14)


def test_the_studentized_range():
    """ptukey stands to 1e-7, at 2 degrees of freedom only to 1e-4; scipy to 1e-13."""
    for name, expected in R["range", "ptukey"].items():
        q, k, df = (float(part.replace("Inf", "inf")) for part in name.split("/"))
        found = range_tail(q, int(k), df).p
        assert found == pytest.approx(expected, abs=2e-4 if df < 5.0 else 1e-7), name
        if q in (2.0, 5.0):
            assert found == pytest.approx(studentized_range.sf(q, k, df), abs=1e-13), name
