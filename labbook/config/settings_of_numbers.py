"""Which settings of labbook.toml the numbers of a report rest on, each by its full name."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from labbook.config.model import AnalysisSettings, Configuration, LevelSettings

_NO_NUMBER = frozenset(
    {
        *("name", "label", "title", "control_name", "treatment", "symbol", "text", "source", "published"),
        *("run_names", "checks", "idle_minutes", "rules_given"),
    }
)
"""Fields of settings that no number rests on."""


def settings_of_numbers(configuration: Configuration) -> dict[str, Any]:
    """Return the settings that numbers rest on, `analysis.alpha` and the like, as JSON has them; defaults filled in.

    Of a scene of one's own it is the hash.
    """
    tables = {
        "study": configuration.study,
        "factors": configuration.factors,
        "protocol": configuration.protocol,
        "gains": configuration.gains,
        "robots": configuration.robots,
        "batteries": configuration.batteries,
        "simulation": configuration.simulation,
        "analysis": configuration.analysis or AnalysisSettings(),
        "hypotheses": {one.name: one for one in configuration.hypotheses},
    }
    return dict(_flat(tables))


def _flat(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    if is_dataclass(value):
        value = {each.name: getattr(value, each.name) for each in fields(value) if each.name not in _NO_NUMBER}
    if isinstance(value, tuple) and value and isinstance(value[0], LevelSettings):
        value = {level.label: level for level in value}
    if isinstance(value, Mapping):
        for key, below in value.items():
            yield from _flat(below, f"{name}.{key}".lstrip("."))
    elif name == "simulation.scene_toml" and value is not None:
        yield name, hashlib.sha256(value.encode()).hexdigest()[:12]
    else:
        yield name, [str(each) if is_dataclass(each) else each for each in value] if isinstance(value, tuple) else value
