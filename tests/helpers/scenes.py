"""Scenes that may be refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec

from data_schema.errors import UsageError
from simulator.changes import changed_by_words
from simulator.effects.registry import EFFECTS
from simulator.scene import Scene

P = ParamSpec("P")


def scene_or_sentence(make: Callable[P, Scene], *values: P.args, **options: P.kwargs) -> Scene | str:
    """The scene that `make` gives, or the sentence that refuses it."""
    try:
        return make(*values, **options)
    except UsageError as refusal:
        return str(refusal)


def with_set(scene: Scene, words: str) -> Scene:
    """The scene with values as `--set` takes them, with spaces between."""
    return changed_by_words(scene, words.split())


def with_needs(effects: frozenset[str], ground: str) -> frozenset[str]:
    """The effects, the ground, and all they need: of alternatives the first that nothing there excludes."""
    found = effects | {ground}
    while missing := [
        alternatives for name in found for alternatives in EFFECTS[name].needs if not found & set(alternatives)
    ]:
        free = [name for name in missing[0] if not any(name in EFFECTS[other].excludes for other in found)]
        found |= {(free or missing[0])[0]}
    return found


def is_sentence(text: str) -> bool:
    """Whether a message is one line that says what was given, and then what to do or which name is nearest."""
    return text.endswith((".", "?")) and ": " in text and "\n" not in text
