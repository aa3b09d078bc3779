"""Libraries that only some uses need, each installed with an extra of the package."""

from __future__ import annotations

import importlib
from typing import Any

from data_schema.errors import UsageError


def optional(module: str, what_for: str, extra: str) -> Any:
    """Import a library; raises `UsageError` with the command that installs it where it is absent."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is not None and error.name.partition(".")[0] != module.partition(".")[0]:
            raise
        raise UsageError(
            f"{what_for} needs {module.partition('.')[0]}, which is not installed: "
            f"run `pip install 'robot-labbook[{extra}]'`."
        ) from error
