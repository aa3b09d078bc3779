"""What every result has: fields nobody can change, rows, JSON, a sentence where one is printed; and names to call."""

from __future__ import annotations

import html
import importlib
import inspect
import json
import math
import pkgutil
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import FrozenInstanceError, dataclass, fields
from typing import Any, get_args, get_type_hints

import numpy as np
import pandas as pd
import pytest

import stats
from data_schema.reasons import Reason
from data_schema.vocabulary import RunKind, Undefined
from stats.results import Result

A, B, C = [42.1, 39.8, 44.0, 41.2], [36.9, 38.2, 35.1, 37.7], [30.0, 33.3, 31.2, 36.8]
FLAT = [0.1, 0.1, 0.1]
RNG = np.random.default_rng(8)
X, V = RNG.normal(size=300), RNG.normal(size=300)
SHARED = stats.SharedError({("idle", "level"): 0.3}, {"idle": 5.0})

DEFINED: dict[str, Callable[[], Any]] = {
    "describe": lambda: stats.describe(A),
    "compare_two": lambda: stats.compare_two(A, B),
    "brown_forsythe": lambda: stats.brown_forsythe({"a": A, "b": B}),
    "one_way_anova": lambda: stats.one_way_anova({"a": A, "b": B, "c": C}),
    "welch_anova": lambda: stats.welch_anova({"a": A, "b": B, "c": C}),
    "compare_all_pairs": lambda: stats.compare_all_pairs({"a": A, "b": B, "c": C}),
    "holm": lambda: stats.holm({"one": 0.01, "two": 0.2}, "of two"),
    "describe_shared": lambda: stats.describe_shared(A, SHARED),
    "cohen_kappa": lambda: stats.cohen_kappa(["yes", "no", "no", "no"], ["yes", "yes", "no", "no"]),
    "power_t": lambda: stats.power_t(1.0, 1.0, 10, 10),
    "power_welch": lambda: stats.power_welch(1.0, 1.0, 2.0, 10, 10),
    "power_by_day": lambda: stats.power_by_day(1.0, 1.0, [(5, 8)] * 5),
    "power_equivalence_by_day": lambda: stats.power_equivalence_by_day(1.0, -1.0, 1.0, [(5, 8)] * 5),
    "power_anova": lambda: stats.power_anova([0.0, 0.5, 1.0], 1.0, 10),
    "power_equivalence": lambda: stats.power_equivalence(1.0, -1.0, 1.0, 20, 20),
    "sample_size": lambda: stats.sample_size(lambda n: stats.power_t(1.0, 1.0, n, n)),
    "fit_linear": lambda: stats.fit_linear(A, {"b": B}),
    "LinearFit.at": lambda: stats.fit_linear(A, {"b": B}).at({"b": 36.0}),
    "fit_passive_drain": lambda: stats.fit_passive_drain([600.0, 1200.0, 1800.0, 2400.0], [70.0, 141.0, 211.5, 281.0]),
    "PassiveDrain.at": lambda: stats.fit_passive_drain([600.0, 1200.0, 1800.0], [70.0, 141.0, 211.5]).at(900.0),
    "fit_stiffness": lambda: stats.fit_stiffness(X, V, 600.0 * X + 20.0 * V + RNG.normal(size=300)),
    "fit_gain_line": lambda: stats.fit_gain_line([100.0, 200.0, 300.0, 400.0], [320.0, 580.0, 836.0, 1090.0]),
    "rmse_over_iqr": lambda: stats.rmse_over_iqr(A, B),
}
UNDEFINED: dict[str, Callable[[], Any]] = {
    "describe": lambda: stats.describe([]),
    "compare_two": lambda: stats.compare_two(FLAT, FLAT),
    "brown_forsythe": lambda: stats.brown_forsythe({"a": FLAT, "b": FLAT}),
    "one_way_anova": lambda: stats.one_way_anova({"a": FLAT, "b": FLAT}),
    "welch_anova": lambda: stats.welch_anova({"a": FLAT, "b": FLAT}),
    "compare_all_pairs": lambda: stats.compare_all_pairs({"a": FLAT, "b": FLAT}),
    "holm": lambda: stats.holm({"one": 0.01, "two": Undefined(Reason.AS_SAID, said="nothing scatters")}, "of two"),
    "describe_shared": lambda: stats.describe_shared([1.0], SHARED),
    "cohen_kappa": lambda: stats.cohen_kappa(["yes", "yes"], ["yes", "yes"]),
    "power_t": lambda: stats.power_t(1.0, 1.0, 1, 1),
    "power_welch": lambda: stats.power_welch(1.0, 1.0, 2.0, 1, 1),
    "power_by_day": lambda: stats.power_by_day(1.0, 1.0, []),
    "power_equivalence_by_day": lambda: stats.power_equivalence_by_day(1.0, -1.0, 1.0, []),
    "power_anova": lambda: stats.power_anova([0.0, 0.5, 1.0], 1.0, 1),
    "power_equivalence": lambda: stats.power_equivalence(1.0, -1.0, 1.0, 1, 1),
    "fit_linear": lambda: stats.fit_linear([1.0, 2.0], {"x": [3.0, 4.0]}),
    "LinearFit.at": lambda: stats.fit_linear([1.0, 2.0], {"x": [3.0, 4.0]}).at({"x": 9.0}),
    "fit_passive_drain": lambda: stats.fit_passive_drain([600.0, 1200.0, 1800.0], [70.0, 70.0, 70.0]),
    "sample_size": lambda: stats.sample_size(lambda n: stats.power_t(0.0, 1.0, n, n)),
    "rmse_over_iqr": lambda: stats.rmse_over_iqr(FLAT, FLAT),
}


def functions() -> Iterator[tuple[str, type]]:
    """Every public function that returns a result, and its class."""
    for module in pkgutil.walk_packages(stats.__path__, "stats."):
        for name, function in inspect.getmembers(importlib.import_module(module.name), inspect.isfunction):
            if function.__module__ != module.name or name.startswith("_"):
                continue
            returned = get_type_hints(function, localns={"pd": pd}).get("return")
            for kind in get_args(returned) or (returned,):
                if inspect.isclass(kind) and issubclass(kind, Result):
                    yield name, kind


def test_a_series_without_scatter_has_no_autocorrelation() -> None:
    assert stats.autocorrelation(FLAT) == Undefined(Reason.SERIES_CONSTANT)
    assert isinstance(stats.autocorrelation([1.0]), Undefined)


def test_every_function_that_returns_a_result_is_tried_here():
    found = dict(functions())
    del found["plane_of"]  # of one result of a study, by `fit_stiffness`
    assert set(found) == {name for name in DEFINED if "." not in name} <= set(stats.__all__)
    for name, kind in found.items():
        assert type(DEFINED[name]()) is kind


OWN_COUNT = ("holm",)
"""What says its number of tests in place of n."""


def has_reason(data: Any) -> bool:
    if isinstance(data, dict):
        return any("reason" in str(key) and item for key, item in data.items()) or any(map(has_reason, data.values()))
    return isinstance(data, list) and any(map(has_reason, data))


@pytest.mark.parametrize(
    ("name", "undefined"), [*((name, False) for name in DEFINED), *((name, True) for name in UNDEFINED)]
)
def test_a_result_is_frozen_and_has_rows_json_a_sentence_and_a_view_in_a_notebook(name, undefined):
    result = (UNDEFINED if undefined else DEFINED)[name]()
    assert isinstance(result, Result)
    with pytest.raises((FrozenInstanceError, TypeError)):
        setattr(result, fields(result)[0].name, None)

    table, rows = result.to_frame(), result.rows()
    assert len(table) == len(rows) >= 1
    for field in fields(rows[0]):
        assert any(column == field.name or column.startswith(f"{field.name}_") for column in table.columns), field.name
    data = json.loads(result.to_json())
    assert data == result.to_dict()
    for field in fields(result):
        value = getattr(result, field.name)
        if isinstance(value, Undefined):
            assert data[field.name] is None
            assert data[f"{field.name}_reason"] == value.reason
        elif isinstance(value, float):
            assert data[field.name] == value or math.isinf(value)
    assert has_reason(data) or not undefined

    shown = result._repr_html_()
    assert "nan" not in re.sub(r"<p>.*?</p>", "", shown)
    if not hasattr(result, "sentence"):
        return
    text = result.sentence()
    assert text[-1] == "."
    assert not re.search(r"\bnan\b|\binf\b|Undefined|None|  |e\+", text)
    if name != "sample_size" or not undefined:
        assert re.search(r"tests?\b|No test" if name in OWN_COUNT else r"n = \d", text), text
    assert html.escape(text) in shown


@pytest.mark.parametrize(
    ("name", "column", "expected"),
    [
        ("compare_all_pairs", "b", ["b", "c", "c"]),
        ("holm", "name", ["one", "two"]),
    ],
)
def test_a_result_of_several_parts_has_a_row_of_each_and_no_lists_in_cells(name, column, expected):
    table = DEFINED[name]().to_frame()
    assert list(table[column]) == expected
    assert not any(isinstance(cell, list | tuple | dict) for cell in table.to_numpy().ravel())


def test_names_are_only_text_in_a_notebook():
    shown = stats.compare_two(A, B, names=("<script>x</script>", "b & c"))._repr_html_()
    assert "<script" not in shown
    assert "&lt;script&gt;x&lt;/script&gt;" in shown


@dataclass(frozen=True, slots=True)
class Inner:
    se: float | Undefined


@dataclass(frozen=True, slots=True)
class Outer(Result):
    name: str
    kind: RunKind
    slope: float | Undefined
    slope_ci: tuple[float, float] | Undefined
    df: float
    inner: Inner
    parts: tuple[float | Undefined, ...]
    by_name: dict[str, float]
    points: np.ndarray

    @property
    def doubled(self) -> float | Undefined:
        return undefined("not asked") if isinstance(self.slope, Undefined) else 2.0 * self.slope


def undefined(said):
    return Undefined(Reason.AS_SAID, said=said)


PARTS, POINTS = (1.0, undefined("gone")), np.arange(2)
FULL = Outer("x", RunKind.IDLE, 1.5, (1.0, 2.0), 7.0, Inner(0.1), PARTS, {"a": 1.0}, POINTS)
BARE = Outer(
    "y", RunKind.IDLE, undefined("flat"), undefined("flat too"), math.inf, Inner(undefined("one")), (), {}, POINTS
)


def test_plain_data_carry_the_reasons():
    data = json.loads(BARE.to_json())
    assert (data["slope"], data["slope_reason"]) == (None, "flat")
    assert (data["slope_ci"], data["slope_ci_reason"]) == (None, "flat too")
    assert (data["df"], data["df_reason"]) == (None, "infinite")
    assert data["inner"] == {"se": None, "se_reason": "one"}
    assert data["doubled_reason"] == "not asked"
    full = FULL.to_dict()
    assert (full["doubled"], full["kind"], full["points"]) == (3.0, "idle", [0, 1])
    assert full["parts"] == [1.0, {"value": None, "reason": "gone"}]
    assert "slope_reason" not in full
    assert json.loads(FULL.to_json()) == full


def test_a_frame_has_nan_and_the_reason_of_what_is_undefined():
    full, bare = FULL.to_frame(), BARE.to_frame()
    assert (len(full), len(bare)) == (1, 1)
    assert set(full.columns) - {"by_name_a"} <= set(bare.columns)
    assert (full["slope"][0], full["slope_ci_high"][0], full["inner_se"][0]) == (1.5, 2.0, 0.1)
    assert np.isnan([bare["slope"][0], bare["slope_ci_high"][0], bare["inner_se"][0]]).all()
    assert (bare["slope_ci_reason"][0], bare["inner_se_reason"][0]) == ("flat too", "one")


def test_what_users_call_is_there_by_name() -> None:
    """Whatever was imported before, also where a function is called as its module is."""
    assert set(stats.__all__) <= set(dir(stats))
    for name in stats.__all__:
        called = getattr(stats, name)
        assert getattr(importlib.import_module(called.__module__), name) is called
    with pytest.raises(AttributeError, match="no attribute 'compare_tow'"):
        _ = stats.compare_tow


def test_a_notebook_needs_one_import() -> None:
    """Loading the package loads nothing of weight."""
    code = (
        "import sys, stats; light = not {'numpy', 'scipy', 'pandas'} & set(sys.modules); a, b = [1, 2, 4], [2, 3, 3]; "
        "print(light, stats.compare_two(a, b).n_a, stats.one_way_anova([a, b]).df_between)"
    )
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert printed.stdout.split()[:3] == ["True", "3", "1"]
