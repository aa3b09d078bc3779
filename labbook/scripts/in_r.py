"""The same computation as a file in R, of functions that are called as those of the templates in Python."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path

from labbook.scripts.assembling import needed_by
from labbook.scripts.script import Script

FOLDER = Path(__file__).parent / "r"


def assemble_in_r(script: Script, heading: str, last_line: str) -> str:
    """Return the text of a file in R that reads the table beside it and prints the number.

    Parameters
    ----------
    script : what is computed, of which table
    heading : what stands at the head, as a comment
    last_line : what stands at the end, as a comment
    """
    parts = [(FOLDER / f"{name}.R").read_text(encoding="utf-8").rstrip() for name in needed_by(script.steps)]
    used = [name for name in script.settings if any(re.search(rf"\b{name}\b", part) for part in parts)]
    settings = {"LEVEL": 0.95, **script.settings}
    named = [f"{name} <- {_in_r(settings[name])}" for name in dict.fromkeys([*used, "LEVEL"])]
    comment = "\n".join(f"# {line}".rstrip() for line in heading.rstrip().splitlines())
    return "\n\n".join([comment, "\n".join(named), *parts, _main(script), f"# {last_line}"]) + "\n"


def _main(script: Script) -> str:
    text = f'read("{script.table}")'
    for step in script.steps:
        text = f"{step.split('.')[1]}({text})"
    return f"show({text})"


def _in_r(value: object) -> str:
    """Write the value of a setting."""
    if isinstance(value, bool):
        return str(value).upper()
    if isinstance(value, float) and math.isinf(value):
        return "Inf" if value > 0.0 else "-Inf"
    if isinstance(value, Mapping):
        return f"list({', '.join(f'{_in_r(key)} = {_in_r(each)}' for key, each in value.items())})"
    if isinstance(value, tuple):
        kind = "c" if all(isinstance(each, str) for each in value) else "list"
        return f"{kind}({', '.join(map(_in_r, value))})"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return repr(value)
