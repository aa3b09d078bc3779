"""The thirty designs of conditions over days by car, multcomp and emmeans: r/blocked_by_others.R.

car's Wald chi-squared is F times its degrees of freedom, multcomp's t of a pair is the difference over the same
standard error; the exact tests are those of a linear model with what they hold fixed as a factor.
"""

import csv
from collections import defaultdict
from functools import lru_cache
from pathlib import Path

import pytest

from data_schema.vocabulary import Undefined
from stats.days.blocked import blocked_by_day
from stats.groups.multiple import holm

HERE = Path(__file__).parent / "r"
DATA: dict[str, list[dict[str, str]]] = defaultdict(list)
with (HERE / "blocked_data.csv").open() as rows:
    for row in csv.DictReader(rows):
        DATA[row["design"]].append(row)
R: dict[tuple[str, str], dict[str, float]] = defaultdict(dict)
with (HERE / "blocked_by_others.csv").open() as rows:
    for row in csv.DictReader(rows):
        R[row["design"], row["quantity"]][row["of"]] = float(row["value"])
EACH = pytest.mark.parametrize("design", DATA)
ROUNDING_ONLY = "zero_both"
"""Its run means differ by the rounding of its values alone: car refuses them."""
WITH_EXACT = (
    "balanced",
    "unbalanced",
    "nested_balanced",
    "nested_one_run",
    "nested_shared_runs",
    "confounded_balanced",
)
EXACT = [design for design in DATA if design.startswith(WITH_EXACT)]


@lru_cache
def fitted(design: str, control: str = "a"):
    rows = DATA[design]
    runs = [row["run"] for row in rows]
    return blocked_by_day(
        [float(row["value"]) for row in rows],
        [row["condition"] for row in rows],
        [row["day"] for row in rows],
        runs if any(runs) else None,
        control=control,
    )


@EACH
@pytest.mark.parametrize("kind", [2, 3])
def test_f_is_the_wald_chi_squared_of_car(design, kind):
    found = fitted(design)
    assert found.mixed.f * found.df_between == pytest.approx(R[design, f"chi_squared_{kind}"][""], rel=1e-7)


@EACH
def test_every_pair_is_that_of_multcomp(design):
    differences = R[design, "pair_difference"]
    conditions = [mean.condition for mean in fitted(design).conditions]
    assert len(differences) == len(conditions) * (len(conditions) - 1) / 2
    for pair, difference in differences.items():
        condition, control = pair.split("-")
        (found,) = (each for each in fitted(design, control).mixed.contrasts if each.condition == condition)
        assert found.difference == pytest.approx(difference, rel=1e-8, abs=1e-12)
        assert found.se == pytest.approx(R[design, "pair_se"][pair], rel=1e-7)
        assert found.t == pytest.approx(R[design, "pair_t"][pair], rel=1e-7, abs=1e-12)


@EACH
def test_contrasts_adjusted_by_holm_are_those_of_emmeans(design):
    expected = R[design, "holm_p"]
    found = holm(
        {f"{each.condition}-{each.control}": each.p for each in fitted(design).mixed.contrasts}, "to the control"
    )
    assert dict(zip(found.names, found.adjusted_p, strict=True)) == pytest.approx(expected, rel=1e-6)


def test_there_is_an_exact_test_to_compare_with():
    assert all(not isinstance(fitted(design).exact, Undefined) for design in EXACT)


@EACH
def test_the_exact_test_is_that_of_a_linear_model(design):
    exact = fitted(design).exact
    if isinstance(exact, Undefined) or design == ROUNDING_ONLY:
        assert design not in EXACT
        return
    layout = f"{exact.unit}/{exact.block}"
    assert exact.df_within == R[design, "exact_df"][layout]
    assert (exact.f, exact.p) == pytest.approx((R[design, "exact_f"][layout], R[design, "exact_p"][layout]), rel=1e-11)
    for each in exact.contrasts:
        of = f"{layout}:{each.condition}"
        assert each.t == pytest.approx(R[design, "exact_t"][of], rel=1e-11, abs=1e-12)
        assert each.p == pytest.approx(R[design, "exact_p_of_t"][of], rel=1e-11)
        ends = (R[design, "exact_low"][of], R[design, "exact_high"][of])
        assert each.interval == pytest.approx(ends, rel=1e-11, abs=1e-12)
