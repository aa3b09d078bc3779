"""A scene of one's own: `[simulation]` of `labbook.toml` names its file, and the book keeps what the file says.

    [simulation]
    scene = "gravel.toml"

The path is relative to the book. A configuration is kept with the file's text below its own, under `[scene_files]`: the
journal alone then gives each prediction again, whatever has become of the file. Its TOML is the simulator's to read.
"""

from __future__ import annotations

import json
from pathlib import Path

from labbook.config.tables import TableReader

SCENE_FILES = "scene_files"
SUFFIX = ".toml"


def read_own_scene(top: TableReader, table: TableReader, name: str, folder: Path | None) -> str | None:
    """Return the text of the file `name` of a scene, as it stands in `folder`, or without one as it is kept.

    `table` is the one that names the scene. Gives None, and adds a fault, where there is no such text.
    """
    if folder is not None:
        return _read(table, name, folder / name)
    kept = top.table(SCENE_FILES).value(name)
    if isinstance(kept, str):
        return kept
    table.fault("scene", f"the text of {name} is not kept with it: put that under [{SCENE_FILES}].")
    return None


def _read(table: TableReader, name: str, path: Path) -> str | None:
    try:
        return path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        table.fault("scene", f"{name} is not text in UTF-8: save it as such.")
    except OSError as error:
        said = error.strerror or str(error)
        table.fault("scene", f"{path} cannot be read ({said}): put the scene there, or name one that is shipped.")
    return None


def with_own_scene(text: str, name: str, scene_toml: str) -> str:
    """Return the text of a configuration with that of the scene's file below it."""
    return f"{text}\n\n[{SCENE_FILES}]\n{_quoted(name)} = {_quoted(scene_toml)}\n"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
