"""A simulated jump in a notebook: its sentence, and its numbers below."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from simulator.result import JumpResult


def test_a_jump_shows_its_apex_and_what_it_cost() -> None:
    values: dict[str, Any] = {field.name: 0.25 for field in fields(JumpResult)}
    values |= {"outcome": "<jumped>", "apex_height_m": 0.30812, "cost_J": 25.712, "counters": {}, "mode_changes": ()}
    shown = JumpResult(**values)._repr_html_()
    assert shown.startswith("<p>&lt;jumped&gt;: apex at 0.3081 m, 25.71 J.</p>")
    assert "<td>max_depth_m</td><td>0.25</td>" in shown
    assert "counters" not in shown


def test_a_jump_without_an_apex_says_so() -> None:
    values: dict[str, Any] = {field.name: 0.25 for field in fields(JumpResult)}
    shown = JumpResult(**values | {"outcome": "sank", "apex_height_m": None})._repr_html_()
    assert "sank: no apex, 0.25 J." in shown
