"""`[simulation]` in `labbook.toml`: the scene that the study's conditions are predicted with.

    [simulation]
    scene = "bed"
    assumed = ["body_mass", "foot_mass"]
    varied = { body_mass = 0.025 }
    factors = { foot = "foot_radius", k_gain = "k_extension" }

    [simulation.levels.surface]
    sand = { kg_scale = 1.2 }

The scene is a shipped one, or a file of one's own.
`factors` names the parameter that a factor's physical value is; `levels` gives parameters level by level, `parameters`
for all conditions. The robot's masses and lengths are those of the book; `assumed` names what has no source all the
same, and is varied as the scene's own assumptions are: by a tenth, by `varied_by`, or by what `varied` says. Names of
parameters are the simulator's, which checks them when it is asked.

A scene of one's own: `[simulation]` of `labbook.toml` names its file, and the book keeps what the file says.

    [simulation]
    scene = "gravel.toml"

The path is relative to the book. A configuration is stored with the file's text below its own, under `[scene_files]`,
so that each prediction can be made again from the journal alone, whatever has become of the file. The simulator reads
its TOML.
"""

from __future__ import annotations

import importlib.resources
import json
from collections.abc import Mapping
from pathlib import Path

from data_schema.errors import unknown_name
from labbook.config.factors import unknown_factor
from labbook.config.model import FactorSettings, SimulationSettings
from labbook.config.tables import TableReader, is_plain

SCENE_FILES = "scene_files"
SUFFIX = ".toml"


def read_own_scene(top: TableReader, table: TableReader, name: str, folder: Path | None) -> str | None:
    """Return the text of the scene file `name`: from `folder`, or without one from the configuration's `[scene_files]`.

    `table` is the one that names the scene. Gives None, and adds a fault, where there is no such text.
    """
    if folder is not None:
        return _read(table, name, folder / name)
    stored = top.table(SCENE_FILES).value(name)
    if isinstance(stored, str):
        return stored
    table.fault("scene", f"the text of {name} is not kept with it: put that under [{SCENE_FILES}].")
    return None


def _read(table: TableReader, name: str, path: Path) -> str | None:
    try:
        return path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        table.fault("scene", f"{name} is not text in UTF-8: save it as such.")
    except OSError as error:
        message = error.strerror or str(error)
        table.fault("scene", f"{path} cannot be read ({message}): put the scene there, or name one that is shipped.")
    return None


def with_own_scene(text: str, name: str, scene_toml: str) -> str:
    """Return the text of a configuration with that of the scene's file below it."""
    return f"{text}\n\n[{SCENE_FILES}]\n{_quoted(name)} = {_quoted(scene_toml)}\n"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


ACCURACY = 1e-6
VARIED_BY = 0.1
"""Relative error asked of the simulator, and the part by which assumed parameters are varied, where none is given."""


def read_simulation(
    top: TableReader, factors: Mapping[str, FactorSettings], folder: Path | None
) -> SimulationSettings | None:
    """Read `[simulation]`, None where the book has none; `folder` is where the file of a scene of one's own may lie."""
    if top.value("simulation") is None:
        return None
    table = top.table("simulation")
    below = table.table("levels")
    scene = table.text("scene")
    own = scene.endswith(SUFFIX)
    settings = SimulationSettings(
        scene=scene if own else _shipped_scene(table, scene),
        scene_toml=read_own_scene(top, table, scene, folder) if own else None,
        effects=table.optional_text("effects"),
        accuracy=table.number("accuracy", ACCURACY, above=0.0),
        varied_by=_part(table, "varied_by", VARIED_BY),
        varied={name: _part(of, name) for of in [table.table("varied")] for name in of.names()},
        parameters=_numbers(table.table("parameters")),
        assumed=tuple(_assumed(table)),
        factors=_parameters_of_factors(table.table("factors"), factors),
        levels={name: _levels(below.table(name), name, factors) for name in below.names()},
    )
    table.finish()
    return settings


def _shipped_scene(table: TableReader, scene: str) -> str:
    shipped = _shipped()
    if scene and scene not in shipped:
        own = "A scene of your own is given by its file, NAME.toml, relative to labbook.toml."
        table.fault("scene", str(unknown_name("scene", scene, shipped, own)))
    return scene


def _shipped() -> list[str]:
    """Return the names of the scenes that come with labbook, without loading the simulator."""
    folder = importlib.resources.files("simulator") / "scenes"
    return sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))


def _part(table: TableReader, key: str, default: float | None = None) -> float:
    part = table.number(key, default, above=0.0)
    if part >= 1.0:
        table.fault(key, f"{part:g} is no part of a value: write one below 1, such as 0.1.")
    return part


def _numbers(table: TableReader) -> dict[str, float]:
    return {name: table.number(name) for name in table.names()}


def _assumed(table: TableReader) -> list[str]:
    names = []
    for given in table.items("assumed", "names of parameters in quotes"):
        if isinstance(given, str) and is_plain(given):
            names.append(given)
        else:
            table.fault("assumed", f"{given!r} is not a name: write names of parameters in quotes.")
    return names


def _parameters_of_factors(table: TableReader, factors: Mapping[str, FactorSettings]) -> dict[str, str]:
    found = {}
    for name in table.names():
        _check_factor(table, name, factors)
        found[name] = table.text(name)
    return found


def _levels(table: TableReader, factor: str, factors: Mapping[str, FactorSettings]) -> dict[str, dict[str, float]]:
    _check_factor(table, factor, factors)
    labels = [level.label for level in factors[factor].levels] if factor in factors else []
    found = {}
    for label in table.names():
        if labels and label not in labels:
            table.fault(label, str(unknown_name(f"level of {factor}", label, labels)))
        found[label] = _numbers(table.table(label))
    return found


def _check_factor(table: TableReader, name: str, factors: Mapping[str, FactorSettings]) -> None:
    if name not in factors:
        table.fault(name, unknown_factor(name, factors))
