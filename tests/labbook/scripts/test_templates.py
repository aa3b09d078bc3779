"""The parts that scripts are made of, beside `stats` on random runs, and how they are put together."""

from __future__ import annotations

import ast
import importlib
import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from data_schema.calibration import Calibration
from data_schema.queries.signals import CalibratedChannel
from labbook.scripts import assembling
from labbook.scripts.facts import Script
from labbook.scripts.templates import days, predictions
from labbook.scripts.templates import runs as of_runs
from labbook.scripts.templates.runs import Run, Source
from stats.compare.agreement import Interval, PredictedRun, bias_by_day, limits_of_agreement
from stats.compare.shared_error import SharedError
from stats.days.contrasts import Effect, linear_contrast
from stats.days.decision import Contrast, blocks_of_runs, contrast_by_day
from stats.days.order import adjust_for_position
from stats.days.overall import overall_equivalence, overall_savings

PAIR = (("control",), ("one", "two"))
LEVEL = 0.9


def modules() -> Iterator[ModuleType]:
    for name in assembling.TEMPLATES:
        yield importlib.import_module(f"labbook.scripts.templates.{name}")


@pytest.fixture(autouse=True)
def level(monkeypatch: pytest.MonkeyPatch) -> None:
    """All intervals have one level, which is not the usual one."""
    for module in modules():
        if hasattr(module, "LEVEL"):
            monkeypatch.setattr(module, "LEVEL", LEVEL)
    monkeypatch.setattr(days, "PAIR", PAIR)


def random_runs(seed: int, n_days: int, df: float = 6.0) -> list[Run]:
    """Runs of three conditions on some days, with two errors that they share."""
    rng = np.random.default_rng(seed)
    found = []
    for condition, effect in (("control", 0.0), ("one", -8.0), ("two", -5.0)):
        for day in range(n_days):
            for _repeat in range(int(rng.integers(2, 4))):
                terms = rng.normal(0.0, 0.5, 2)
                errors = {Source("line", "level", df): terms[0], Source("line", "slope", df): terms[1]}
                row = {"condition": condition, "day": f"2021-06-{day + 1:02d}", "position_in_day": str(len(found) % 7)}
                found.append(Run(row, 60.0 + effect + day + float(rng.normal(0.0, 2.0)), errors))
    return found


def shared_of(run: Run) -> SharedError:
    terms = {(source.fit, source.term): size for source, size in run.shared.items()}
    return SharedError(terms, {source.fit: source.df for source in run.shared})


def contrast_of(runs: list[Run]) -> Contrast:
    sides = [[run for run in runs if run.row["condition"] in side] for side in PAIR]
    control, treated = ([run.value for run in side] for side in sides)
    days_control, days_treated = ([run.row["day"] for run in side] for side in sides)
    shared_control, shared_treated = (list(map(shared_of, side)) for side in sides)
    return contrast_by_day(
        treated, control,
        days_treated=days_treated, days_control=days_control,
        shared_treated=shared_treated, shared_control=shared_control,
    )  # fmt: skip


@pytest.mark.parametrize("df", [6.0, 2.0])
@pytest.mark.parametrize("n_days", [6, 2])
def test_the_deciding_test_is_that_of_stats(n_days: int, df: float, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = random_runs(n_days, n_days, df)
    found = contrast_of(runs)
    for mine, theirs in (
        (days.difference_of_means(runs), found.difference(LEVEL)),
        (days.savings(runs), found.savings(LEVEL)),
    ):
        assert isinstance(theirs.ci, tuple)
        ends = theirs.ci
        expected = [theirs.value, theirs.se, theirs.shared_se, *ends, theirs.df]
        names = ("value", "se", "shared_se", "ci_low", "ci_high", "df")
        assert [mine[name] for name in names] == pytest.approx(expected, rel=1e-11)
    assert days.difference_of_means(runs)["t"] == pytest.approx(found.difference(LEVEL).t, rel=1e-11)
    assert days.difference_of_means(runs)["p"] == pytest.approx(found.difference(LEVEL).p, rel=1e-9)
    assert days.run_sd(runs)["value"] == pytest.approx(found.run_sd, rel=1e-11)


@pytest.mark.parametrize("percent", [True, False])
def test_equivalence_is_that_of_stats(percent: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = random_runs(3, 5)
    monkeypatch.setattr(days, "IN_PERCENT", percent)
    monkeypatch.setattr(days, "LOW", -20.0)
    monkeypatch.setattr(days, "HIGH", 12.0)
    theirs = contrast_of(runs).equivalence(-20.0, 12.0, (1.0 - LEVEL) / 2.0, percent=percent)
    found = days.equivalence(runs)
    expected = [theirs.t_low, theirs.p_low, theirs.t_high, theirs.p_high, theirs.p]
    assert [found[name] for name in ("t_low", "p_low", "t_high", "p_high", "p")] == pytest.approx(expected, rel=1e-9)
    assert isinstance(theirs.ci, tuple)
    assert [found["ci_low"], found["ci_high"]] == pytest.approx(theirs.ci, rel=1e-10)


@pytest.mark.parametrize("n_days", [6, 2])
def test_contrasts_are_those_of_stats(n_days: int) -> None:
    runs = random_runs(4, n_days)
    blocks = {
        name: blocks_of_runs(name, [run.value for run in own], [run.row["day"] for run in own], None,
                             [shared_of(run) for run in own])
        for name in ("control", "one", "two")
        for own in [[run for run in runs if run.row["condition"] == name]]
    }  # fmt: skip
    theirs = linear_contrast(
        blocks, [Effect(1.0, "one", "control"), Effect(-1.0, "two", "control")], percent=True, level=LEVEL
    ).estimate
    effects = ((1.0, (("control",), ("one",))), (-1.0, (("control",), ("two",))))
    mine = days.contrast_of(runs, effects, percent=True)
    assert isinstance(theirs.ci, tuple)
    expected = [theirs.value, theirs.se, theirs.shared_se, *theirs.ci, theirs.df, theirs.t]
    names = ("value", "se", "shared_se", "ci_low", "ci_high", "df", "t")
    assert [mine[name] for name in names] == pytest.approx(expected, rel=1e-9)


def test_effects_over_groups_are_those_of_stats(monkeypatch: pytest.MonkeyPatch) -> None:
    groups = {"first": random_runs(5, 5), "second": random_runs(6, 6), "third": random_runs(7, 2)}
    found = {name: contrast_of(runs) for name, runs in groups.items()}
    runs = [
        run._replace(row={**run.row, "condition": f"{name} {run.row['condition']}"})
        for name, own in groups.items()
        for run in own
    ]
    claimed = {name: ((f"{name} control",), (f"{name} one", f"{name} two")) for name in groups}
    monkeypatch.setattr(days, "CLAIMED", claimed)
    theirs = overall_savings(found, LEVEL)
    mine = days.overall_savings(runs)
    assert isinstance(theirs.estimate.ci, tuple)
    expected = [theirs.estimate.value, theirs.estimate.se, *theirs.estimate.ci, theirs.estimate.df]
    assert [mine[name] for name in ("value", "se", "ci_low", "ci_high", "df")] == pytest.approx(expected, rel=1e-10)
    assert days.heterogeneity_p(runs)["value"] == pytest.approx(getattr(theirs.heterogeneity, "p", None), rel=1e-9)
    bounded = overall_equivalence(found, -5.0, 5.0, (1.0 - LEVEL) / 2.0).bounded
    assert days.overall_equivalence(runs)["p"] == pytest.approx(bounded.p, rel=1e-9)


@pytest.mark.parametrize("n_days", [4, 2])
def test_effects_over_groups_that_err_by_rounding_alone_are_those_of_stats(
    n_days: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    alike = {}
    for name, lower in (("first", 0.1), ("second", 0.3)):
        joules = {"control": 40.1, "one": 40.1 - lower, "two": 40.1 - lower}
        alike[name] = [
            run._replace(
                value=joules[run.row["condition"]],
                shared={Source("rounding", f"{name} {joules[run.row['condition']]}", math.inf): 0.2},
            )
            for run in random_runs(9, n_days)
        ]
    runs = [
        run._replace(row={**run.row, "condition": f"{name} {run.row['condition']}"})
        for name, own in alike.items()
        for run in own
    ]
    claimed = {name: ((f"{name} control",), (f"{name} one", f"{name} two")) for name in alike}
    monkeypatch.setattr(days, "CLAIMED", claimed)
    theirs, mine = (
        overall_savings({name: contrast_of(own) for name, own in alike.items()}, LEVEL),
        days.overall_savings(runs),
    )
    assert isinstance(theirs.estimate.ci, tuple)
    expected = [theirs.estimate.value, theirs.estimate.shared_se, *theirs.estimate.ci, theirs.estimate.df]
    assert [mine[name] for name in ("value", "shared_se", "ci_low", "ci_high", "df")] == pytest.approx(expected)
    assert days.heterogeneity_p(runs)["value"] == pytest.approx(getattr(theirs.heterogeneity, "p", None))


def test_values_at_the_mean_position_are_those_of_stats(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = random_runs(8, 5)
    monkeypatch.setattr(of_runs, "GROUPS", {"all": PAIR})
    theirs = adjust_for_position(
        [run.value for run in runs],
        [int(run.row["position_in_day"]) for run in runs],
        [run.row["condition"] in PAIR[1] for run in runs],
        [run.row["day"] for run in runs],
        [run.row["condition"] for run in runs],
    )
    mine = of_runs.at_mean_position(runs)
    assert [run.value for run in mine] == pytest.approx(getattr(theirs, "values", None), rel=1e-11)
    errors = [error.se for error in getattr(theirs, "shared", ())]
    assert [abs(run.shared[list(run.shared)[-1]]) for run in mine] == pytest.approx(errors, rel=1e-9, abs=1e-15)


def test_the_error_of_a_calibration_is_that_of_its_channel() -> None:
    calibration = Calibration(scale=2.0, offset=0.1, errors=((0.0, 0.004), (0.002, -0.001)), df=5)
    channel = CalibratedChannel("body_height", "pot", -0.5, 0.3, -1, calibration, "m", "Ada Nwosu")
    row = {
        "apex_height_m": "0.42", "calibration": "c", "calibration_df": "5", "height_sign": "-1", "height_scale": "-0.5",
        "height_zero": "0.3", "calibration_scale": "2.0", "error_slopes": "0.0 0.002",
        "error_intercepts": "0.004 -0.001",
    }  # fmt: skip
    assert list(of_runs.calibration_errors_m(row).values()) == pytest.approx(channel.error_terms(0.42), rel=1e-12)


def with_simulated(runs: list[Run], seed: int) -> list[Run]:
    """The same with predictions: a value of each condition, lowered and raised by a parameter, and another branch."""
    rng = np.random.default_rng(seed)
    found = {}
    for condition in dict.fromkeys(run.row["condition"] for run in runs):
        value, *varied = 58.0 + rng.normal(0.0, 2.0, 4)
        found[condition] = {
            "simulated": repr(float(value)), "simulated_error": "1e-06", "varied": "mass;mass;other branch",
            "simulated_varied": ";".join(repr(float(one)) for one in varied),
        }  # fmt: skip
    return [run._replace(row={**run.row, **found[run.row["condition"]]}) for run in runs]


@pytest.mark.parametrize("n_days", [5, 2, 1])
def test_biases_of_predictions_are_those_of_stats(n_days: int) -> None:
    runs = with_simulated(random_runs(9, n_days), n_days)
    predicted = predictions.predictions_of(runs)
    theirs = bias_by_day(
        [
            PredictedRun(run.row["day"], run.value, shared_of(run), one["value"], one["se"])
            for run in runs
            for one in [predicted[run.row["condition"]]]
        ],
        LEVEL,
    )
    for mine, interval in (
        (predictions.bias(runs), theirs.in_all),
        (predictions.bias_of_measured(runs), theirs.of_measured),
    ):
        assert mine["value"] == pytest.approx(theirs.bias, rel=1e-10)
        if isinstance(interval, Interval):
            expected = [interval.se, *interval.ci, interval.df]
            assert [mine[name] for name in ("se", "ci_low", "ci_high", "df")] == pytest.approx(expected, rel=1e-9)
            assert mine["p"] == pytest.approx(interval.p, rel=1e-9)
        else:
            assert set(mine) == {"value"}
    away = [
        one["value"] - np.mean([run.value for run in runs if run.row["condition"] == condition])
        for condition, one in predicted.items()
    ]
    limits = limits_of_agreement(away, LEVEL)
    ends = predictions.lower_limit(runs)
    assert [ends["value"], ends["ci_low"], ends["ci_high"]] == pytest.approx([limits.low, *limits.low_ci], rel=1e-9)


def test_a_prediction_whose_varied_jump_has_no_apex_has_no_error() -> None:
    row = {"condition": "control", "simulated": "0.3", "simulated_error": "1e-6", "varied": "mass;mass"}
    without = Run({**row, "simulated_varied": "0.29;nan"}, 0.31, {})
    known = Run({**row, "simulated_varied": "0.29;0.32"}, 0.31, {})
    assert predictions.predicted_mean([without]) == {"value": 0.3}
    assert predictions.predicted_mean([known])["se"] == pytest.approx(0.02, rel=1e-6)


def test_every_template_is_listed_and_names_are_its_own() -> None:
    files = {file.stem for file in assembling.FOLDER.glob("*.py")} - {"__init__"}
    assert set(assembling.TEMPLATES) == files
    statements = [node for each in assembling.TEMPLATES for node in assembling.statements_of(each)]
    names = Counter(node.name for node in statements if isinstance(node, ast.FunctionDef | ast.ClassDef))
    for node in statements:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names.update(one.id for target in targets for one in ast.walk(target) if isinstance(one, ast.Name))
    assert [name for name, count in names.items() if count > 1] == []


def test_templates_in_r_have_the_numbers_of_those_in_python() -> None:
    numbers = [
        (where, node.name)
        for where in assembling.TEMPLATES
        for node in assembling.statements_of(where)
        if isinstance(node, ast.FunctionDef) and node.returns is not None
        if ast.unparse(node.returns) == "Number" and node.args.args[0].arg in ("runs", "rows")
    ]
    assert len(numbers) > 25
    for where, name in numbers:
        assert f"\n{name} <- function(" in (assembling.R_FOLDER / f"{where}.R").read_text(encoding="utf-8"), name


def test_settings_are_written_as_python_reads_them() -> None:
    settings = {
        "LOW": -float("inf"), "HIGH": 5.0, "IN_PERCENT": False,
        "PAIR": (("a",), tuple(f"foot=large k_gain={gain}" for gain in range(9))),
    }  # fmt: skip
    script = Script([], ("heights_of_runs", "equivalence"), settings)
    text = assembling.assemble(script, "A p.", "the report prints 1.0")
    names: dict[str, object] = {"__name__": "read", "__file__": str(Path(__file__))}
    exec(text, names)
    assert {name: names[name] for name in settings} == settings
    assert max(map(len, text.splitlines())) <= 120


def test_quantiles_are_of_the_level_that_is_asked_for() -> None:
    assert of_runs.quantile(0.95, 1e9) == pytest.approx(1.959964, rel=1e-6)
