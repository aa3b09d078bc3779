"""Read `labbook.toml`: the study, its people, factors, protocol, equipment and column profiles.

The file is a proposal; what is in force is in the book, and every command compares the two. A key that is not known
is refused, because a typing error must not become a default. The faults of a file are reported together.

A scene of one's own: `[simulation]` names its file, relative to the book. A configuration is stored with the file's
text below its own, under `[scene_files]`, so that each prediction can be made again from the journal alone.
"""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

from data_schema.errors import InputRefused
from labbook.config.checks import check
from labbook.config.model import Configuration
from labbook.config.reading import Faults, read_model
from labbook.config.template import template

__all__ = ["Configuration", "parse_configuration", "template"]

_SCENE_FILES = "scene_files"


def parse_configuration(text: str, source: str, folder: Path | None = None) -> Configuration:
    """Read a configuration; `source` names the file in messages.

    `folder`: where the file of a scene of one's own is looked for; None for a text that is stored with it.
    Raises `InputRefused` with one sentence a fault.
    """
    given = _toml(text, source)
    faults: Faults = []
    stored = given.pop(_SCENE_FILES, {}) if folder is None else {}
    simulation = given.get("simulation")
    scene = simulation.get("scene") if isinstance(simulation, dict) else None
    scene_toml = None
    if isinstance(scene, str) and scene.endswith(".toml"):
        scene_toml = stored.get(scene) if folder is None else _scene_file(folder / scene, scene, faults)
        if folder is None and scene_toml is None:
            faults.append(
                f"simulation.scene: the text of {scene} is not kept with it: put that under [{_SCENE_FILES}]."
            )
        elif folder is not None and scene_toml is not None:
            text = f"{text}\n\n[{_SCENE_FILES}]\n{_quoted(scene)} = {_quoted(scene_toml)}\n"
    configuration = read_model(Configuration, given, faults)
    if configuration is not None:
        simulation = configuration.simulation and replace(configuration.simulation, scene_toml=scene_toml)
        hypotheses = {name: replace(one, name=name) for name, one in configuration.hypotheses.items()}
        configuration = replace(configuration, simulation=simulation, hypotheses=hypotheses, text=text)
        check(configuration, given, faults)
    if configuration is None or faults:
        if len(faults) == 1:
            raise InputRefused(f"{source}: {faults[0]}")
        listed = "".join(f"\n  {fault}" for fault in faults)
        raise InputRefused(f"{source} has {len(faults)} faults, correct each of them and try again:{listed}")
    return configuration


def _toml(text: str, source: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise InputRefused(f"{source} has brackets too deep inside each other: write it flatter.") from error
    except ValueError as error:  # also numbers of thousands of digits
        raise InputRefused(f"{source} is not TOML, {error}: correct that place and try again.") from error


def _scene_file(path: Path, name: str, faults: Faults) -> str | None:
    try:
        return path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        faults.append(f"simulation.scene: {name} is not text in UTF-8: save it as such.")
    except OSError as error:
        message = error.strerror or str(error)
        faults.append(
            f"simulation.scene: {path} cannot be read ({message}): put the scene there, or name one that is shipped."
        )
    return None


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
