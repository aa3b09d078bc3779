"""How often tests err and intervals cover, held to what `docs/statistics/error_rates.csv` says.

Where a method is exact the recorded share lies within four Monte-Carlo errors of the nominal one; elsewhere studies
drawn anew find the recorded share. What is simulated over arrays is the library's own function, to 1e-12.
"""

from __future__ import annotations

import functools
import math
import zlib
from collections import Counter

import numpy as np
import pytest

from benchmarks.stats_evidence.sizes.design import draw
from benchmarks.stats_evidence.sizes.method import said_of, seed_of, simulated, standard_error, studies
from benchmarks.stats_evidence.sizes.record import EVERY_RATE, LOOKED_UP, design_of, main
from benchmarks.stats_evidence.sizes.registry import METHODS
from tests.helpers.recorded_rates import EVERY
from tests.helpers.wording import refuses

OVER_ARRAYS = [method for method in METHODS if method.many is not None]
ROWS = [(method, design) for method in METHODS for design in method.designs]
SLOW = ("bootstrap", "games_howell", "permutation")
LIGHT_RUNS, ONE_BY_ONE_RUNS = 2000, 30
SOME_ROWS = [
    rows[zlib.crc32(name.encode()) % len(rows)]
    for name in dict.fromkeys(method.name for method in METHODS)
    for rows in [[row for row in ROWS if row[0].name == name]]
]
"""Of each method one; in a soak those of all methods, and every row as its seed gives it."""
EVERY_NTH_METHOD = 8


@functools.cache
def by_design():
    return {(row.method, row.kind, design_of(row)): row for row in EVERY}


def named(method, design):
    layout = f"-{design.days}d-{design.layout}-{design.day_sd:g}" if design.days else ""
    sizes = "+".join(map(str, design.n))
    return f"{method.name}-{method.kind}-{sizes}-{design.sd_ratio:g}-{design.distribution}{layout}"


def test_the_record_holds_every_method_on_every_design():
    due = {(method.name, method.kind, design): method.runs for method, design in ROWS}
    assert {key: row.runs for key, row in by_design().items()} == due
    assert len(by_design()) == len(EVERY) == len(ROWS)


@pytest.mark.parametrize("most", [2, pytest.param(12, marks=pytest.mark.soak)])
@pytest.mark.parametrize("place", range(len(OVER_ARRAYS)), ids=lambda place: OVER_ARRAYS[place].name)
def test_what_is_simulated_over_arrays_is_the_librarys_own(place, most):
    method = OVER_ARRAYS[place]
    rng = np.random.default_rng(place)
    few = 1 if method.name in SLOW else min(most, len(method.designs))
    for design in [method.designs[i] for i in rng.choice(len(method.designs), few, replace=False)]:
        groups = draw(design, 2, rng)
        library = [method.one(study, design) for study in studies(groups)]
        np.testing.assert_allclose(said_of(method, groups, design), np.array(library, float), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("place", range(len(METHODS)), ids=lambda place: METHODS[place].name)
def test_exact_methods_have_the_nominal_share(place):
    method = METHODS[place]
    rows = [by_design()[method.name, method.kind, design] for design in method.designs if method.exact(design)]
    wrong = [row for row in rows if abs(row.value - row.nominal) >= 4.0 * standard_error(row.nominal, row.runs)]
    assert wrong == []


def test_which_methods_are_exact_and_on_how_many_designs():
    exact = Counter(method.name for method in METHODS for design in method.designs if method.exact(design))
    assert exact["one_way_anova"] == 16 + 6 + 4  # three groups, one day that all share, five groups
    assert exact["eta_squared_ci"] == 14 + 6
    assert exact["dunnett"] == exact["dunnett_greater"] == 5 + 5
    assert exact["student"] == 29 + 6
    assert exact["f_test"] == exact["f_ratio_ci"] == 30 + 12  # one day, whosever it is
    assert exact["tukey"] == 5 + 4  # groups of one size
    assert exact["mean_ci"] == exact["fit_linear_ci"] == exact["fit_linear_intercept_ci"] == 4
    assert exact["fit_linear_at_ci"] == exact["passive_drain_at_ci"] == exact["gain_line_slope_ci"] == 4
    assert exact["fit_linear_through_0_f_test"] == 4
    assert exact["fit_polynomial_ci"] == exact["fit_polynomial_at_ci"] == exact["fit_linear_of_two_ci"] == 3
    assert exact["stiffness_ci"] == exact["damping_ci"] == 2
    assert exact["passive_drain_in_steps_at_ci"] == exact["welch_eta_squared_ci"] == exact["mean_ci_shared"] == 0
    assert exact["blocked_by_day_exact"] == exact["blocked_by_day_exact_ci"] == 144
    assert exact["welch"] == exact["f_then_t"] == exact["levene"] == exact["fieller"] == 0


@pytest.mark.parametrize(
    ("method", "design"),
    [
        pytest.param(*pair, id=named(*pair), marks=pytest.mark.soak if place % EVERY_NTH_METHOD else ())
        for place, pair in enumerate(SOME_ROWS)
    ],
)
def test_studies_drawn_anew_find_the_recorded_share(method, design):
    runs = ONE_BY_ONE_RUNS if method.many is None or method.name in SLOW else LIGHT_RUNS
    row = by_design()[method.name, method.kind, design]
    value = simulated(method, design, runs, seed_of(method, design) + 1)
    error = math.hypot(standard_error(row.value, runs), standard_error(row.value, row.runs))
    assert abs(value - row.value) < 4.0 * error


@pytest.mark.parametrize("name", [pytest.param("bootstrap", marks=pytest.mark.soak), *SLOW[1:]])
def test_of_slow_methods_a_whole_row_is_what_its_seed_gives(name):
    method, design = min(((m, d) for m, d in ROWS if m.name == name), key=lambda row: (sum(row[1].n), len(row[1].n)))
    row = by_design()[method.name, method.kind, design]
    assert abs(simulated(method, design, row.runs, seed_of(method, design)) - row.value) <= 1.5 / row.runs


@pytest.mark.soak
@pytest.mark.parametrize("place", range(len(METHODS)), ids=lambda place: METHODS[place].name)
def test_every_row_is_what_its_seed_gives(place):
    """To one study: another processor may round a study on the edge to its other side."""
    method, wrong = METHODS[place], []
    for design in method.designs:
        row = by_design()[method.name, method.kind, design]
        value = simulated(method, design, row.runs, seed_of(method, design))
        wrong += [(row, value)] if abs(value - row.value) > 1.5 / row.runs else []
    assert wrong == []


def test_a_record_with_shares_missing_is_completed_as_it_was(tmp_path):
    whole = EVERY_RATE.read_bytes()
    lines = [line.split(b",") for line in whole.splitlines()]
    column = lines[0].index(b"coverage_fit_linear_ci")
    for line in lines[1:]:
        line[column] = b""
    every, short = tmp_path / "error_rates.csv", tmp_path / "recorded.csv"
    every.write_bytes(b"\n".join(b",".join(line) for line in lines) + b"\n")
    assert every.read_bytes() != whole
    main(["fit_linear_ci"], every, short)
    assert every.read_bytes() == whole
    assert short.read_bytes() == LOOKED_UP.read_bytes()
    with refuses(SystemExit, "is no method", "'fit'"):
        main(["fit"], every, short)
