"""Axes that cannot be swept, and what the rules between parameters read."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UsageError
from simulator.declared import all_parameters
from simulator.scene_file import load_scene
from simulator.scene_rules import RULES, Rule
from simulator.sweep.sweep import rule_reads
from tests.helpers.scenes import is_sentence
from tests.helpers.sweeps import grid_sweep, sobol_sweep
from tests.helpers.wording import says


@pytest.mark.parametrize(
    ("over", "said"),
    [
        (["foot_radius=0,0.03"], "foot_radius = 0 m is outside what can be simulated"),
        (["b_ad=-1:300:3"], "b_ad = -1 kg/m is outside"),
        (["b_ad=0:1e6:3"], "b_ad = 1e+06 kg/m is outside"),
        (["ad_share=0.1,0.2"], "ad_share would change nothing"),
        (["platform_travel=0.01,0.02"], "platform_travel would change nothing"),
    ],
)
def test_refused_with_the_first_value_that_cannot_be(over: list[str], said: str) -> None:
    with pytest.raises(UsageError) as refusal:
        grid_sweep(*over)
    assert said in str(refusal.value)
    assert is_sentence(str(refusal.value))


def test_a_rule_is_asked_about_combinations_and_not_about_each_axis() -> None:
    whole = grid_sweep("upper_link=0.12,0.22", "lower_link=0.25,0.3", "rest_length=0.28,0.32")
    assert whole.refusals.count == 0
    assert (
        "rest_length = 0.36"
        in grid_sweep("upper_link=0.12,0.22", "lower_link=0.23,0.3", "rest_length=0.28,0.36").refused
    )


def test_a_sample_is_looked_at_row_by_row() -> None:
    assert sobol_sweep(512, "kg_scale=1:10", "foot_radius=0.02:0.05").refusals.count == 0
    says(sobol_sweep(512, "kg_scale=0.01:10:log", "foot_radius=0.02:0.05").refused, "m_a")


@pytest.mark.parametrize("rule", RULES, ids=[rule.fault.__name__ for rule in RULES])
@given(data=st.data())
def test_a_rule_reads_the_same_parameters_whatever_their_values(rule: Rule, data: Any) -> None:
    scene = load_scene("bed")
    plain = {name: value.value for name, value in scene.values.items()}
    read = rule_reads(rule, plain)
    parameters = [all_parameters()[name] for name in sorted(read)]
    others = {item.name: data.draw(st.floats(item.low, item.high)) for item in parameters}
    assert rule_reads(rule, {**plain, **others}) == read
    assert rule_reads(rule, others) == read
