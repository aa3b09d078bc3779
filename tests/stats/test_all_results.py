"""What every result of the package has: fields nobody can change, each documented, rows, JSON and a sentence."""

from __future__ import annotations

import html
import importlib
import inspect
import json
import math
import pkgutil
import re
from collections.abc import Callable, Iterator
from dataclasses import FrozenInstanceError, fields
from typing import Any, get_args, get_type_hints

import numpy as np
import pandas as pd
import pytest

import stats
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.compare.shared_error import SharedError, describe_shared
from stats.compare.summary import autocorrelation, describe
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.multiple import holm
from stats.groups.residuals import normal_quantiles, residuals_of_groups, rmse_over_iqr
from stats.groups.tukey import compare_all_pairs
from stats.groups.variances import bartlett, brown_forsythe, levene
from stats.lines.passive_drain import fit_passive_drain
from stats.lines.regression import fit_linear
from stats.lines.stiffness import fit_gain_line, fit_stiffness, force_points
from stats.planning.power import (
    power_anova,
    power_by_day,
    power_equivalence,
    power_equivalence_by_day,
    power_t,
    power_welch,
    sample_size,
)
from stats.results import Result

A, B, C = [42.1, 39.8, 44.0, 41.2], [36.9, 38.2, 35.1, 37.7], [30.0, 33.3, 31.2, 36.8]
FLAT = [0.1, 0.1, 0.1]
RNG = np.random.default_rng(8)
X, V = RNG.normal(size=300), RNG.normal(size=300)
SHARED = SharedError({("idle", "level"): 0.3}, {"idle": 5.0})

DEFINED: dict[str, Callable[[], Any]] = {
    "describe": lambda: describe(A),
    "autocorrelation": lambda: autocorrelation(A),
    "compare_two": lambda: compare_two(A, B),
    "bartlett": lambda: bartlett({"a": A, "b": B}),
    "levene": lambda: levene({"a": A, "b": B}),
    "brown_forsythe": lambda: brown_forsythe({"a": A, "b": B}),
    "one_way_anova": lambda: one_way_anova({"a": A, "b": B, "c": C}),
    "welch_anova": lambda: welch_anova({"a": A, "b": B, "c": C}),
    "compare_all_pairs": lambda: compare_all_pairs({"a": A, "b": B, "c": C}),
    "holm": lambda: holm({"one": 0.01, "two": 0.2}, "of two"),
    "describe_shared": lambda: describe_shared(A, SHARED),
    "power_t": lambda: power_t(1.0, 1.0, 10, 10),
    "power_welch": lambda: power_welch(1.0, 1.0, 2.0, 10, 10),
    "power_by_day": lambda: power_by_day(1.0, 1.0, [(5, 8)] * 5),
    "power_equivalence_by_day": lambda: power_equivalence_by_day(1.0, -1.0, 1.0, [(5, 8)] * 5),
    "power_anova": lambda: power_anova([0.0, 0.5, 1.0], 1.0, 10),
    "power_equivalence": lambda: power_equivalence(1.0, -1.0, 1.0, 20, 20),
    "sample_size": lambda: sample_size(lambda n: power_t(1.0, 1.0, n, n)),
    "fit_linear": lambda: fit_linear(A, {"b": B}),
    "LinearFit.at": lambda: fit_linear(A, {"b": B}).at({"b": 36.0}),
    "fit_passive_drain": lambda: fit_passive_drain([600.0, 1200.0, 1800.0, 2400.0], [70.0, 141.0, 211.5, 281.0]),
    "PassiveDrain.at": lambda: fit_passive_drain([600.0, 1200.0, 1800.0], [70.0, 141.0, 211.5]).at(900.0),
    "fit_stiffness": lambda: fit_stiffness(X, V, 600.0 * X + 20.0 * V + RNG.normal(size=300)),
    "force_points": lambda: force_points([0.0, 0.1, 0.2], [0.0, 0.01, 0.03], [0.1, 0.2, 0.1], 2.0),
    "fit_gain_line": lambda: fit_gain_line([100.0, 200.0, 300.0, 400.0], [320.0, 580.0, 836.0, 1090.0]),
    "GainLine.at": lambda: fit_gain_line([100.0, 200.0, 300.0], [320.0, 580.0, 836.0]).at(250.0),
    "rmse_over_iqr": lambda: rmse_over_iqr(A, B),
    "residuals_of_groups": lambda: residuals_of_groups({"a": A, "b": B}),
    "normal_quantiles": lambda: normal_quantiles(residuals_of_groups({"a": A, "b": B})),
}
UNDEFINED: dict[str, Callable[[], Any]] = {
    "describe": lambda: describe([]),
    "autocorrelation": lambda: autocorrelation(FLAT),
    "compare_two": lambda: compare_two(FLAT, FLAT),
    "bartlett": lambda: bartlett({"a": FLAT, "b": FLAT}),
    "levene": lambda: levene({"a": FLAT, "b": FLAT}),
    "brown_forsythe": lambda: brown_forsythe({"a": FLAT, "b": FLAT}),
    "one_way_anova": lambda: one_way_anova({"a": FLAT, "b": FLAT}),
    "welch_anova": lambda: welch_anova({"a": FLAT, "b": FLAT}),
    "compare_all_pairs": lambda: compare_all_pairs({"a": FLAT, "b": FLAT}),
    "holm": lambda: holm({"one": 0.01, "two": Undefined(Reason.AS_SAID, said="nothing scatters")}, "of two"),
    "describe_shared": lambda: describe_shared([1.0], SHARED),
    "power_t": lambda: power_t(1.0, 1.0, 1, 1),
    "power_welch": lambda: power_welch(1.0, 1.0, 2.0, 1, 1),
    "power_by_day": lambda: power_by_day(1.0, 1.0, []),
    "power_equivalence_by_day": lambda: power_equivalence_by_day(1.0, -1.0, 1.0, []),
    "power_anova": lambda: power_anova([0.0, 0.5, 1.0], 1.0, 1),
    "power_equivalence": lambda: power_equivalence(1.0, -1.0, 1.0, 1, 1),
    "fit_linear": lambda: fit_linear([1.0, 2.0], {"x": [3.0, 4.0]}),
    "LinearFit.at": lambda: fit_linear([1.0, 2.0], {"x": [3.0, 4.0]}).at({"x": 9.0}),
    "fit_passive_drain": lambda: fit_passive_drain([600.0, 1200.0, 1800.0], [70.0, 70.0, 70.0]),
    "sample_size": lambda: sample_size(lambda n: power_t(0.0, 1.0, n, n)),
    "residuals_of_groups": lambda: residuals_of_groups({"a": [1.0], "b": [2.0]}),
    "normal_quantiles": lambda: normal_quantiles(residuals_of_groups({"a": [1.0], "b": [2.0]})),
    "rmse_over_iqr": lambda: rmse_over_iqr(FLAT, FLAT),
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


def test_every_function_that_returns_a_result_is_tried_here():
    found = dict(functions())
    del found["plane_of"]  # of one result of a study, by `fit_stiffness`
    assert set(found) == {name for name in DEFINED if "." not in name} <= set(stats.__all__)
    for name, kind in found.items():
        assert type(DEFINED[name]()) is kind


OWN_COUNT = ("holm", "LinearFit.at", "GainLine.at", "PassiveDrain.at")
"""What says its number of tests, or its degrees of freedom, in place of n."""


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
    if undefined:
        assert list(table.columns) == list(DEFINED[name]().to_frame().columns)

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

    text = result.sentence()
    assert text[-1] == "."
    assert not re.search(r"\bnan\b|\binf\b|Undefined|None|  |e\+", text)
    if name != "sample_size" or not undefined:
        assert re.search(r"tests?\b|df = \d|t\(|No test" if name in OWN_COUNT else r"n = \d", text), text
    shown = result._repr_html_()
    assert html.escape(text) in shown
    assert "nan" not in re.sub(r"<p>.*?</p>", "", shown)


@pytest.mark.parametrize(
    ("name", "column", "expected"),
    [
        ("fit_linear", "name", ["intercept", "b"]),
        ("compare_all_pairs", "b", ["b", "c", "c"]),
        ("holm", "name", ["one", "two"]),
    ],
)
def test_a_result_of_several_parts_has_a_row_of_each_and_no_lists_in_cells(name, column, expected):
    table = DEFINED[name]().to_frame()
    assert list(table[column]) == expected
    assert not any(isinstance(cell, list | tuple | dict) for cell in table.to_numpy().ravel())


def test_a_list_of_no_parts_has_their_columns_and_names_are_only_text_in_a_notebook():
    for name, none in (
        ("residuals_of_groups", residuals_of_groups({"a": [], "b": []})),
        ("normal_quantiles", normal_quantiles(residuals_of_groups({}))),
    ):
        assert len(none.to_frame()) == 0
        assert list(none.to_frame().columns) == list(DEFINED[name]().to_frame().columns)
    shown = compare_two(A, B, names=("<script>x</script>", "b & c"))._repr_html_()
    assert "<script" not in shown
    assert "&lt;script&gt;x&lt;/script&gt;" in shown
