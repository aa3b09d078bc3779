"""Libraries that only sweeps need, and that may be absent."""

from __future__ import annotations

import importlib
from typing import Any

from data_schema.errors import UsageError


def optional(module: str, what_for: str) -> Any:
    """Import a library; raises `UsageError` with the command that installs it where it is absent."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is not None and error.name.partition(".")[0] != module.partition(".")[0]:
            raise
        raise UsageError(
            f"{what_for} needs {module}, which is not installed: run `pip install 'robot-labbook[sweeps]'`."
        ) from error
