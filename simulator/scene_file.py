"""Scenes as TOML files: those that are shipped, and a user's own.

    title = "..."
    description = "..."
    jumps = 1
    effects = ["rigid_ground", ...]

    [robot]
    body_mass = { value = 1.75, source = "thesis 3.1.3" }
    foot_mass = { value = 0.175, assumed = "a tenth of the body" }

A value that was set in a scene, by `--set` say, is written with `set_by_user = true`: it has neither.

The other tables are [leg], [controller], [ground], [drive] and [start]; parameters of effects that are off may stand
there, so that the effects can be switched on.
"""

from __future__ import annotations

import difflib
import importlib.resources
import json
import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import get_args

from data_schema.errors import InputRefused, LabbookError, UnknownName, unknown_name
from simulator.declared import all_parameters
from simulator.effects.registry import EFFECTS
from simulator.parameter import Part
from simulator.scene import Scene, Value, check_effects, check_given

PARTS: tuple[str, ...] = get_args(Part)
_TOP = ("title", "description", "jumps", "effects")
_KEYS = ("value", "source", "assumed")
_SET_BY_USER, _FITTED_TO = "set_by_user", "fitted_to"
"""Keys that only `write_scene` gives a value: a person names the source, or why there is none."""
_ALIKE = 0.75
"""How much alike an unknown key and a known one are, of 1, where the one was most likely meant to be the other."""
_ADDED = "An effect of your own adds parameters (docs/add-an-effect.md)."
_KINDS = ((bool, "true or false"), (str, "text"), (list, "a list"), (dict, "a table"))
_SUFFIX = ".toml"
_SHIPPED = importlib.resources.files("simulator") / "scenes"


def shipped_scenes() -> tuple[str, ...]:
    """Return the names of the scenes that come with the simulator, in alphabetical order.

    >>> shipped_scenes()
    ('bed', 'emulator', 'force_plate', 'sim1', 'sim2')
    """
    names = (entry.name for entry in _SHIPPED.iterdir())
    return tuple(sorted(name.removesuffix(_SUFFIX) for name in names if name.endswith(_SUFFIX)))


def load_scene(name_or_path: str | Path) -> Scene:
    """Load a scene.

    Parameters
    ----------
    name_or_path : a name of `shipped_scenes`, or the path of a file that ends in .toml

    Returns
    -------
    The scene, named after its file, with every parameter in SI units and its source.

    Raises
    ------
    UnknownName for a name that is not shipped; InputRefused for a file that is missing or is no scene.

    Examples
    --------
    >>> scene = load_scene("sim2")
    >>> scene["foot_radius"], scene.values["foot_radius"].source
    (0.03, 'published with the simulations (2021)')
    """
    given = str(name_or_path)
    if given in shipped_scenes():
        return parse_scene((_SHIPPED / f"{given}{_SUFFIX}").read_text(encoding="utf-8"), given)
    path = Path(name_or_path)
    if path.suffix != _SUFFIX:
        raise unknown_name("scene", given, shipped_scenes(), "A scene of your own is given by its file, NAME.toml.")
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputRefused(f"{path.name} is not text in UTF-8: save it as such.") from error
    except FileNotFoundError as error:
        shipped = ", ".join(shipped_scenes())
        raise InputRefused(f"there is no scene file {path}: check the path, or take one of {shipped}.") from error
    except IsADirectoryError as error:
        raise InputRefused(f"{path} is a folder: give a scene file in it.") from error
    except OSError as error:
        message = (error.strerror or str(error)).lower()
        raise InputRefused(
            f"the scene file {path} cannot be read ({message}): check its path and permissions."
        ) from error
    return parse_scene(text, path.stem, path.name)


def parse_scene(text: str, name: str, origin: str = "") -> Scene:
    """Read a scene from the text of a TOML file.

    `name` becomes the scene's name; `origin` names the file in messages. Raises `InputRefused` for what is no scene.
    """
    origin = origin or f"scene {name}"
    try:
        top = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputRefused(f"{origin} is not TOML, {error}: correct that place and try again.") from error
    try:
        return _scene(top, name)
    except LabbookError as error:
        raise InputRefused(f"{origin}: {error}") from error


def write_scene(scene: Scene) -> str:
    """Return a scene as the text of a TOML file, which `parse_scene` reads back equal.

    >>> scene = load_scene("bed")
    >>> parse_scene(write_scene(scene), "bed") == scene
    True
    """
    lines = [f"title = {_text(scene.title)}", f"description = {_text(scene.description)}", f"jumps = {scene.jumps}"]
    effects = [name for name in EFFECTS if name in scene.effects]
    lines += ["effects = [", *(f"  {_text(name)}," for name in effects), "]"]
    for part in PARTS:
        lines += ["", f"[{part}]"]
        for name, value in scene.values.items():
            if all_parameters()[name].part == part:
                lines.append(f"{name} = {{ value = {_number(value.value)}, {_origin(value)} }}")
    return "\n".join(lines) + "\n"


def _origin(value: Value) -> str:
    if value.set_by_user:
        return "set_by_user = true"
    if not value.assumed:
        return f"source = {_text(value.source)}"
    fitted = f", {_FITTED_TO} = {_text(value.fitted_to)}" if value.fitted_to else ""
    return f"assumed = {_text(value.why)}{fitted}"


def _scene(top: Mapping[str, object], name: str) -> Scene:
    for key in top:
        if key not in _TOP and key not in PARTS:
            raise _unknown_key(key)
    title, description, effects = (top.get(key, "") for key in ("title", "description", "effects"))
    jumps = top.get("jumps", 1)
    if not isinstance(title, str) or not title:
        raise InputRefused("title is missing or no text: write what the scene is in a line.")
    if not isinstance(description, str):
        raise InputRefused("description is no text: write it in quotes, or leave it out.")
    if not isinstance(jumps, int):
        raise InputRefused(f"jumps = {jumps!r} is not a whole number: write for example jumps = 1.")
    if not isinstance(effects, list) or not all(isinstance(effect, str) for effect in effects):
        raise InputRefused('effects is missing or no list of names: write for example effects = ["rigid_ground"].')
    for effect in effects:
        if effects.count(effect) > 1:
            raise InputRefused(f"effects names {effect} {_times(effects.count(effect))}: name it once.")
    values: dict[str, Value] = {}
    for part in PARTS:
        table = top.get(part, {})
        if not isinstance(table, dict):
            raise InputRefused(f"{part} is not a table: write [{part}] and its parameters below it.")
        values |= {key: _value(part, key, item) for key, item in table.items()}
    check_effects(effects)
    check_given(effects, values)
    return Scene(
        name=name,
        title=title,
        description=description,
        effects=frozenset(effects),
        values=values,
        jumps=jumps,
    )


def _value(part: str, name: str, item: object) -> Value:
    parameter = all_parameters().get(name)
    if parameter is None:
        raise unknown_name("parameter", name, all_parameters(), _ADDED)
    if parameter.part != part:
        raise InputRefused(f"{name} stands in [{part}]: move it to [{parameter.part}].")
    form = f'write {name} = {{ value = ..., source = "..." }}, or assumed = "why" where it has no source.'
    if not isinstance(item, dict) or "value" not in item:
        raise InputRefused(f"{name} is not given with its value and source: {form}")
    for key in item:
        if key not in (*_KEYS, _SET_BY_USER, _FITTED_TO):
            raise unknown_name(f"key of {name}", key, _KEYS)
    source, why, is_set = item.get("source", ""), item.get("assumed", ""), item.get(_SET_BY_USER, False)
    of_their_kinds = isinstance(source, str) and isinstance(why, str) and isinstance(is_set, bool)
    if not of_their_kinds or [bool(source), bool(why), is_set].count(True) != 1:
        raise InputRefused(f"{name} has to have either a source or a reason why it is assumed: {form}")
    fitted_to = item.get(_FITTED_TO, "")
    if not isinstance(fitted_to, str) or (fitted_to and not why):
        raise InputRefused(f"{_FITTED_TO} of {name} is no name of a study beside a reason why it is assumed: {form}")
    return Value(_number_in(name, item["value"]), source, why, is_set, fitted_to)


def _number_in(name: str, found: object) -> float:
    """Return a value as a number; infinite where it is too large for one, as a scene then says."""
    if isinstance(found, bool) or not isinstance(found, int | float):
        kind = next((kind for of, kind in _KINDS if isinstance(found, of)), "a date or a time")
        raise InputRefused(f"the value of {name} is {kind} and no number: write value = and digits, without quotes.")
    try:
        return float(found)
    except OverflowError:
        return math.inf if found > 0 else -math.inf


def _unknown_key(key: str) -> LabbookError:
    """Return the refusal of a key at the top of a file: a parameter in no table, a slip, or what has no place there."""
    parameter = all_parameters().get(key)
    if parameter is not None:
        return InputRefused(f"{key} stands above all tables: move it to [{parameter.part}].")
    tables = [f"[{part}]" for part in PARTS]
    close = difflib.get_close_matches(key.lower(), (*_TOP, *PARTS), n=1, cutoff=_ALIKE)
    hint = f"did you mean {close[0]!r}?" if close else f"allowed are {', '.join((*_TOP, *tables))}."
    return UnknownName(f"{key!r} is not a known key of a scene file: {hint}")


def _times(count: int) -> str:
    return "twice" if count == 2 else f"{count} times"


def _text(words: str) -> str:
    return json.dumps(words, ensure_ascii=False).replace("\x7f", "\\u007f")


def _number(value: float) -> str:
    return repr(float(value))
