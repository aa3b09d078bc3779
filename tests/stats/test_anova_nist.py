"""NIST's eleven sets for one-way analysis of variance, against exact arithmetic on the same doubles."""

import csv
import io
import zipfile
from collections import defaultdict
from pathlib import Path

import mpmath
import pytest

from stats.groups.anova import one_way_anova

NIST = Path(__file__).parent / "nist"
SETS = ("SiRstv", "AtmWtAg", *(f"SmLs{number:02d}" for number in range(1, 10)))


def truth(name):
    with (NIST / "exact.csv").open() as rows:
        return {
            row["quantity"]: mpmath.mpf(row["exact_of_float64_input_25d"])
            for row in csv.DictReader(rows)
            if row["dataset"] == name
        }


def groups(name):
    found = defaultdict(list)
    with zipfile.ZipFile(NIST / "data.zip") as archive, archive.open(f"{name}.csv") as rows:
        for row in csv.DictReader(io.TextIOWrapper(rows)):
            found[row["group"]].append(float(row["y"]))
    return found


@pytest.mark.parametrize("name", SETS)
def test_every_quantity_of_nist(name):
    """At an offset of 1e12 (SmLs07 to 09) statsmodels and pingouin keep 2 to 3 digits of F, the textbook formula none.

    Where p is 2.1e-2477 (SmLs03, 06 and 09) every library gives 0, and minus infinity for its logarithm.
    """
    exact, found = truth(name), one_way_anova(groups(name))
    assert found.f == pytest.approx(float(exact["F"]), rel=1e-14)
    assert found.ss_between == pytest.approx(float(exact["ss_between"]), rel=1e-14)
    assert found.ss_within == pytest.approx(float(exact["ss_within"]), rel=1e-14)
    assert found.eta_squared == pytest.approx(float(exact["r_squared"]), rel=1e-14)
    assert found.residual_sd == pytest.approx(float(exact["residual_sd"]), rel=1e-14)
    assert (found.df_between, found.df_within) == (exact["df_between"], exact["df_within"])
    assert found.log10_p == pytest.approx(float(mpmath.log10(exact["p"])), rel=1e-14)
    if exact["p"] > 1e-300:
        assert found.p == pytest.approx(float(exact["p"]), rel=1e-14)
    else:
        assert found.p == 0.0
        assert -2477.0 < found.log10_p < -2476.0
