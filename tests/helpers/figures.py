"""What the long trials of losses counted, for docs/reliability.md."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

FIGURES = "LABBOOK_RELIABILITY"
"""Names a file to which each trial adds a line of JSON; `scripts/reliability_document.py` puts them on the page."""


@dataclass
class Count:
    """How often a command was killed or lost its power, on which engine.

    `written`: how many of the killed ones had their entry in the journal; `lost`: how often something was missing.
    """

    command: str
    trial: str
    engine: str
    tried: int = 0
    cut_off: int = 0
    written: int = 0
    lost: int = 0


def record(*counts: Count) -> None:
    """Add counts to the file that is asked for, if one is."""
    if FIGURES in os.environ:
        with Path(os.environ[FIGURES]).open("a", encoding="utf-8") as file:
            file.writelines(json.dumps(asdict(count)) + "\n" for count in counts)
