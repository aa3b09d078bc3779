"""The document `docs/statistics.md`: an introduction, and sections that are each written anew by themselves."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Mapping
from typing import cast

SECTIONS = ("meaning", "digits", "weaknesses", "sizes", "speed")
"""In the order of the document; each is `section()` of the module `section` in its folder, loaded when asked for."""

INTRODUCTION = """\
# Statistics

What the numbers of `stats` are worth: how many digits are right, where other programs fail, whether tests and intervals
keep what they state, and what that costs. Written by `python benchmarks/statistics_document.py`; do not edit. With
names of sections (`{names}`) only these are written anew. All but the times come out the
same on every run on one machine; on another the last digits of what other programs return may differ.
"""
_FIRST, _LAST = "<!-- section: {} -->", "<!-- end of {} -->"
_SECTION = re.compile(r"<!-- section: (\w+) -->\n(.*?)\n<!-- end of \1 -->", re.DOTALL)


def measured(name: str) -> str:
    """Make one section anew."""
    section = cast(
        Callable[[], list[str]], importlib.import_module(f"benchmarks.stats_evidence.{name}.section").section
    )
    return "\n".join(section()).strip()


def parts(text: str) -> dict[str, str]:
    """Take a document apart into its sections."""
    return dict(_SECTION.findall(text))


def together(sections: Mapping[str, str]) -> str:
    """Put a document together from those sections that there are."""
    texts = [INTRODUCTION.format(names=" ".join(SECTIONS))]
    texts += [
        f"{_FIRST.format(name)}\n{sections[name]}\n{_LAST.format(name)}\n" for name in SECTIONS if name in sections
    ]
    return "\n".join(texts)
