"""Which settings of labbook.toml the numbers of a report rest on, each by its full name."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from msgspec import json

from labbook.config.model import AnalysisSettings, Configuration

_TABLES = ("study", "factors", "protocol", "gains", "robots", "batteries", "simulation", "analysis", "hypotheses")
_NO_NUMBER = frozenset(
    {
        *("name", "title", "control_name", "treatment", "symbol", "text", "source", "published"),
        *("run_names", "checks", "idle_minutes"),
    }
)
"""Keys that no number rests on."""


def settings_of_numbers(configuration: Configuration) -> dict[str, Any]:
    """Return the settings that numbers rest on, `analysis.alpha` and the like, as JSON has them; defaults filled in.

    Of a scene of one's own it is the hash.
    """
    whole = replace(configuration, analysis=configuration.analysis or AnalysisSettings())
    tables = json.decode(json.encode(whole))
    found = dict(_flat({name: tables[name] for name in _TABLES}, ""))
    scene = found.get("simulation.scene_toml")
    if scene is not None:
        found["simulation.scene_toml"] = hashlib.sha256(scene.encode()).hexdigest()[:12]
    return found


def _flat(table: dict[str, Any], path: str) -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        name = f"{path}.{key}".lstrip(".")
        if isinstance(value, dict):
            yield from _flat(value, name)
        elif key not in _NO_NUMBER:
            yield name, value
