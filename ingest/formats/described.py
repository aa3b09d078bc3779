"""What each format is and by what it is recognised, for people."""

from __future__ import annotations

import inspect
import sys
from dataclasses import dataclass

from ingest.formats.format import Format
from ingest.formats.plugins import all_formats


@dataclass(frozen=True, slots=True)
class Described:
    """A format: `what` its files are, `evidence` by what one is recognised, `plugin` where it comes from."""

    name: str
    version: int
    what: str
    evidence: str
    plugin: str | None


def described_formats() -> tuple[Described, ...]:
    """Describe all formats, in the order of the registry; those without words of their own by their module's."""
    return tuple(
        Described(each.name, each.version, each.what or _of_module(each), _of_recognise(each), each.plugin)
        for each in all_formats()
    )


def _of_module(format_: Format) -> str:
    module = sys.modules.get(format_.read.__module__)
    return _first_sentence(inspect.getdoc(module) or "")


def _of_recognise(format_: Format) -> str:
    return _first_sentence(inspect.getdoc(format_.recognise) or "")


def _first_sentence(text: str) -> str:
    words = " ".join(text.partition("\n\n")[0].split())
    return words.partition(". ")[0].rstrip(".") + "." if words else ""
