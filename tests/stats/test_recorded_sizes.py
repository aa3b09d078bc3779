"""How often tests err and intervals cover, held to what `stats/recorded.csv` says.

Where a method is exact the recorded share lies within four Monte-Carlo errors of the nominal one; elsewhere studies
drawn anew find the recorded share. What is simulated over arrays is the library's own function, to 1e-12.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from benchmarks.stats_evidence.sizes.design import Design, draw
from benchmarks.stats_evidence.sizes.method import said_of, seed_of, simulated, standard_error, studies
from benchmarks.stats_evidence.sizes.record import design_of, key_of, main, read, row_of
from benchmarks.stats_evidence.sizes.registry import METHODS
from benchmarks.stats_evidence.sizes.section import section
from data_schema.vocabulary import Undefined
from stats.blocked import blocked_by_day
from stats.recorded import FILE, Recorded, recorded, weak_points

OVER_ARRAYS = [method for method in METHODS if method.many is not None]
ROWS = [(method, design) for method in METHODS for design in method.designs]
BY_DESIGN = {(row.method, row.kind, design_of(row)): row for row in recorded()}
SLOW = ("bootstrap", "games_howell", "permutation")
LIGHT_RUNS, ONE_BY_ONE_RUNS, SHARE_OF_ROWS = 2000, 30, 11


def named(method, design):
    layout = f"-{design.days}d-{design.layout}-{design.day_sd:g}" if design.days else ""
    sizes = "+".join(map(str, design.n))
    return f"{method.name}-{method.kind}-{sizes}-{design.sd_ratio:g}-{design.distribution}{layout}"


def test_the_record_holds_every_method_on_every_design_with_its_seed():
    there = read(Path(str(FILE)))
    due = {key_of(row_of(method, design)): seed_of(method, design) for method, design in ROWS}
    assert list(there) == list(due)
    assert {key: int(row["seed"]) for key, row in there.items()} == due
    assert len(BY_DESIGN) == len(recorded()) == len(ROWS)


@pytest.mark.parametrize("place", range(len(OVER_ARRAYS)), ids=lambda place: OVER_ARRAYS[place].name)
def test_what_is_simulated_over_arrays_is_the_librarys_own(place):
    method = OVER_ARRAYS[place]
    rng = np.random.default_rng(place)
    few = 1 if method.name in SLOW else min(6, len(method.designs))
    for design in [method.designs[i] for i in rng.choice(len(method.designs), few, replace=False)]:
        groups = draw(design, 2 if method.name in SLOW else 4, rng)
        library = [method.one(study, design) for study in studies(groups)]
        np.testing.assert_allclose(said_of(method, groups, design), np.array(library, float), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("place", range(len(METHODS)), ids=lambda place: METHODS[place].name)
def test_exact_methods_have_the_nominal_share(place):
    method = METHODS[place]
    rows = [BY_DESIGN[method.name, method.kind, design] for design in method.designs if method.exact(design)]
    wrong = [row for row in rows if abs(row.value - row.nominal) >= 4.0 * standard_error(row.nominal, row.runs)]
    assert wrong == []


def test_which_methods_are_exact_and_on_how_many_designs():
    exact = Counter(method.name for method in METHODS for design in method.designs if method.exact(design))
    assert exact["one_way_anova"] == exact["dunnett"] == 5
    assert exact["f_test"] == exact["f_ratio_ci"] == 8
    assert exact["tukey"] == exact["mean_ci"] == exact["fit_linear_ci"] == 4
    assert exact["blocked_by_day_exact"] == 125
    assert exact["welch"] == exact["f_then_t"] == exact["levene"] == exact["fieller"] == 0


@pytest.mark.parametrize(("method", "design"), [pytest.param(*pair, id=named(*pair)) for pair in ROWS[::SHARE_OF_ROWS]])
def test_studies_drawn_anew_find_the_recorded_share(method, design):
    runs = ONE_BY_ONE_RUNS if method.many is None or method.name in SLOW else LIGHT_RUNS
    row = BY_DESIGN[method.name, method.kind, design]
    value = simulated(method, design, runs, seed_of(method, design) + 1)
    error = math.hypot(standard_error(row.value, runs), standard_error(row.value, row.runs))
    assert abs(value - row.value) < 4.0 * error


WHOLE_ROWS = [
    ("games_howell", Design((3, 3, 3))),
    ("permutation", Design((3, 10), 2.0)),
    ("permutation", Design((10, 10), days=2, day_sd=1.0, layout="shared")),
    ("bootstrap", Design((6, 6), days=2, day_sd=1.0, layout="shared")),
    ("bootstrap_bca", Design((3, 3))),
    ("blocked_by_day", Design((6, 6), days=2, day_sd=1.0, layout="partly")),
    ("blocked_by_day_ci", Design((6, 6), days=2, day_sd=1.0, layout="partly")),
]
"""Of methods that are too slow for many studies drawn anew, of which few tell little, a quick row each."""


@pytest.mark.parametrize(("name", "design"), WHOLE_ROWS, ids=lambda one: one if isinstance(one, str) else "")
def test_a_whole_row_of_each_slow_method_is_what_its_seed_gives(name, design):
    """To one study: another processor may round a study on the edge to its other side."""
    (method,) = [each for each, one in ROWS if (each.name, one) == (name, design)]
    row = BY_DESIGN[name, method.kind, design]
    assert abs(simulated(method, design, row.runs, seed_of(method, design)) - row.value) < 1.5 / row.runs


def test_a_whole_row_is_made_of_every_slow_method():
    slow = {method.name for method in METHODS if method.many is None or method.name in SLOW}
    assert slow == {name for name, _design in WHOLE_ROWS}


@pytest.mark.soak
@pytest.mark.parametrize("place", range(len(METHODS)), ids=lambda place: METHODS[place].name)
def test_every_row_is_what_its_seed_gives(place):
    """To one study: another processor may round a study on the edge to its other side."""
    method, wrong = METHODS[place], []
    for design in method.designs:
        row = BY_DESIGN[method.name, method.kind, design]
        value = simulated(method, design, row.runs, seed_of(method, design))
        wrong += [(row, value)] if abs(value - row.value) > 1.5 / row.runs else []
    assert wrong == []


YARDSTICKS = [
    ("f_test", Design((10, 10)), 0.05, 0.005),
    ("f_test", Design((30, 30)), 0.05, 0.005),
    ("f_test", Design((10, 10), distribution="t5"), 0.13, 0.005),
    ("f_test", Design((30, 30), distribution="t5"), 0.18, 0.005),
    ("f_test", Design((10, 10), distribution="t3"), 0.22, 0.005),
    ("f_test", Design((30, 30), distribution="t3"), 0.33, 0.005),
    ("f_test", Design((10, 10), distribution="exponential"), 0.24, 0.005),
    ("f_test", Design((30, 30), distribution="exponential"), 0.29, 0.005),
    ("f_test", Design((10, 10), distribution="uniform"), 0.01, 0.005),
    ("f_test", Design((30, 30), distribution="uniform"), 0.003, 0.0005),
    ("levene", Design((10, 10), distribution="t3"), 0.07, 0.005),
    ("levene", Design((30, 30), distribution="t3"), 0.055, 0.0005),
    ("levene", Design((10, 10), distribution="exponential"), 0.15, 0.005),
    ("levene", Design((30, 30), distribution="exponential"), 0.14, 0.005),
    ("student", Design((5, 20), 2.0), 0.183, 0.0005),
    ("f_then_t", Design((5, 20), 2.0), 0.114, 0.0005),
    ("welch", Design((5, 20), 2.0), 0.055, 0.0005),
    ("student", Design((10, 40), 1.5), 0.122, 0.0005),
    ("f_then_t", Design((10, 40), 1.5), 0.086, 0.0005),
    ("welch", Design((10, 40), 1.5), 0.049, 0.0005),
    ("f_then_t", Design((3, 10), 1.5), 0.108, 0.0005),
    ("welch", Design((3, 10), 1.5), 0.072, 0.0005),
    ("f_then_t", Design((3, 3)), 0.046, 0.0005),
    ("welch", Design((3, 3)), 0.033, 0.0005),
    ("student", Design((10, 10), days=1, day_sd=1.0, layout="own"), 0.54, 0.005),
    ("student", Design((10, 10), days=2, day_sd=1.0, layout="own"), 0.30, 0.005),
    ("student", Design((25, 25), days=5, day_sd=1.0, layout="own"), 0.27, 0.005),
    ("fieller", Design((5, 5)), 0.956, 0.0005),
    ("delta", Design((5, 5)), 0.950, 0.0005),
]
"""Method, design, share published for it (20 000 studies) and half a unit of its last digit."""


@pytest.mark.parametrize(("name", "design", "share", "rounding"), YARDSTICKS)
def test_the_record_agrees_with_published_shares(name, design, share, rounding):
    (row,) = [row for row in recorded() if row.method == name and design_of(row) == design]
    assert abs(row.value - share) < rounding + 4.0 * math.sqrt(2.0) * standard_error(share, 20_000)


def test_brown_and_forsythe_never_err_too_often():
    """0.034 to 0.049 in all distributions at 10 and 30 values; fewer values reject less."""
    shares = {
        row.n[0]: [each.value for each in recorded() if each.method == row.method and each.n == row.n]
        for row in recorded()
        if row.method == "brown_forsythe" and row.n in ((3, 3), (5, 5), (10, 10), (30, 30))
    }
    error = 4.0 * standard_error(0.05, 20_000)
    assert all(0.03 - error < share < 0.05 + error for n in (10, 30) for share in shares[n])
    assert max(shares[3]) < 0.001
    assert max(shares[5]) < 0.02


def test_day_means_hold_the_level_that_pooled_values_do_not():
    for row in recorded():
        if row.method == "blocked_by_day_exact" and row.sd_ratio == 1.0:
            assert abs(row.value - 0.05) < 4.0 * standard_error(0.05, row.runs)
    assert all(row.value > 0.17 for row in recorded() if row.days and row.method == "student" and row.layout == "own")


def test_conditions_of_one_day_each_get_no_p_at_all():
    found = blocked_by_day(np.arange(8.0) ** 2, [0, 1] * 4, [0, 1] * 4)
    assert isinstance(found.p, Undefined)
    assert not [row for row in recorded() if row.method.startswith("blocked") and (row.days, row.layout) == (1, "own")]


@pytest.mark.parametrize(
    ("method", "n", "days", "found"),
    [
        ("f_then_t", (5, 20), None, {(1.5, 0.099), (2.0, 0.114), (3.0, 0.090)}),
        ("f_then_t", (21, 6), None, {(1.5, 0.099), (2.0, 0.114), (3.0, 0.090)}),
        ("welch", (3, 9), None, {(1.0, 0.067), (1.5, 0.073), (2.0, 0.072), (3.0, 0.071)}),
        ("welch", (9, 9), None, set()),
        ("welch", (10, 11), 2, {(1.0, 0.304), (1.0, 0.173)}),
        ("welch", (200, 200), 9, {(1.0, 0.605)}),
        ("one_way_anova", (10, 10), None, set()),
        ("mean_ci", (4,), None, set()),
        ("brown_forsythe", (3, 3), None, set()),
        ("no such method", (3, 3), None, set()),
        ("welch", (), None, set()),
    ],
)
def test_weak_points_of_a_design(method, n, days, found):
    assert {(row.sd_ratio, round(row.value, 3)) for row in weak_points(method, n, days)} == found


def test_weak_points_of_other_values_and_of_one_layout_only():
    (t3,) = weak_points("f_test", (11, 11), distribution="t3")
    assert t3.value > 0.2
    assert weak_points("f_test", (11, 11)) == ()
    assert weak_points("welch", (12, 12), 2, layout="shared") == ()
    student = weak_points("difference_ci_student", (3, 3))
    assert {(row.kind, row.sd_ratio, round(row.value, 3)) for row in student} == {("coverage", 3.0, 0.926)}
    assert weak_points("bootstrap", (3, 3)) == ()


def test_what_chance_in_drawing_explains_is_no_weak_point():
    near = Recorded("some test", "size", (5, 5), 1.0, None, 0.05, 0.0625, 20_000)
    assert near.standard_error == pytest.approx(math.sqrt(0.0625 * 0.9375 / 20_000))
    assert not replace(near, runs=2000).weak  # 0.0625 - 2 * 0.0054 is below 0.06
    assert not replace(near, value=0.0633).weak
    assert replace(near, value=0.0636).weak
    interval = replace(near, kind="coverage", nominal=0.95, value=0.925)
    assert interval.weak
    assert not replace(interval, runs=2000).weak
    assert not [row for row in recorded() if row.weak and abs(row.value - row.nominal) < 0.01]


@pytest.mark.parametrize("method", ["equivalence", "equivalence_percent", "welch", "f_then_t", "one_way_anova"])
def test_one_day_in_common_leaves_a_test_that_errs_too_often(method):
    k = 3 if method == "one_way_anova" else 2
    for days in (2, 3, 6):
        (partly,) = weak_points(method, (5 * days,) * k, days, layout="partly")
        (own,) = weak_points(method, (5 * days,) * k, days, layout="own")
        assert 0.06 < partly.value < own.value


@pytest.mark.parametrize("method", ["equivalence", "equivalence_percent", "welch", "f_then_t", "one_way_anova"])
def test_one_day_that_is_not_in_common_still_tells_with_ten_values_a_day(method):
    k = 3 if method == "one_way_anova" else 2
    there = {
        (row.layout, row.days, row.n[0] // row.days): row.value
        for row in recorded()
        if (row.method, len(row.n), row.sd_ratio) == (method, k, 1.0) and row.layout in ("partly", "mostly")
    }
    for days in range(3, 7):
        for times in (3, 5, 10):
            assert there["mostly", days, times] < there["partly", days, times]
        assert there["mostly", days, 10] > 0.08
    assert max(there["mostly", days, 3] for days in (4, 5, 6)) < 0.06


@pytest.mark.parametrize("method", ["difference_ci_welch", "difference_ci_f_then_t", "fieller"])
def test_intervals_miss_the_truth_on_days_that_groups_do_not_share(method):
    for days in (2, 6):
        (partly,) = weak_points(method, (5 * days,) * 2, days, layout="partly")
        (own,) = weak_points(method, (5 * days,) * 2, days, layout="own")
        assert own.value < partly.value < 0.93


def test_two_conditions_by_day_are_on_record_as_a_report_compares_them():
    there = {
        (row.kind, row.layout, row.days): row
        for row in recorded()
        if row.n == (10 * (row.days or 0),) * 2 and row.method in ("blocked_by_day", "blocked_by_day_ci")
    }
    assert {key[1:] for key in there} == {
        *((layout, days) for layout in ("shared", "own", "partly") for days in range(2, 7)), ("shared", 1),
        *(("mostly", days) for days in range(3, 7)),
    }  # fmt: skip
    exact = {(row.layout, row.days) for row in recorded() if row.method == "blocked_by_day_exact" and len(row.n) == 2}
    assert exact == {key[1:] for key in there if key[1] in ("shared", "own")}
    for (kind, layout, days), row in there.items():
        if kind == "size":  # a condition's interval leaves out 0 where its test rejects
            interval = there["coverage", layout, days]
            error = math.hypot(row.standard_error, interval.standard_error)
            assert abs(row.value + interval.value - 1.0) < 4.0 * error


def test_a_record_with_rows_missing_is_completed_as_it_was(tmp_path):
    whole = Path(str(FILE)).read_bytes()
    part = tmp_path / "recorded.csv"
    part.write_bytes(b"".join(line for line in whole.splitlines(True) if not line.startswith(b"fit_linear_ci,")))
    assert part.read_bytes() != whole
    main(["fit_linear_ci"], part)
    assert part.read_bytes() == whole
    with pytest.raises(SystemExit, match="there is no method 'fit'"):
        main(["fit"], part)


def test_the_chapter_shows_weak_cells_in_bold():
    text = "\n".join(section())
    assert "| F-test, then Student or Welch | 2 | .059 | .053 | " in text
    assert "| **.114** |" in text
    assert all(line.count("|") == table.count("|") for table, line in _pairs_of_table_lines(text))


def _pairs_of_table_lines(text):
    lines = text.splitlines()
    return [(one, two) for one, two in pairwise(lines) if one.startswith("|") and two.startswith("|")]
