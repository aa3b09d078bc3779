"""`[study] run_names`: what a run is called, so that a plan can name new ones and a file's name can state its run."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection
from dataclasses import dataclass

DEFAULT = "r{:03d}"
_SCHEME = re.compile(r"(?P<before>[^{}]*)\{(?::0(?P<digits>[1-9])d)?\}(?P<after>[^{}]*)")


@dataclass(frozen=True, slots=True)
class RunNames:
    """Names of runs by number: `r{:03d}` is r001, r002 and so on, `LOG{:04d}` is LOG0001, `trial {}` is trial 1.

    A book may have runs of other names, too: these are then not made by a plan.
    """

    scheme: str = DEFAULT

    def name(self, number: int) -> str:
        """Return the name of a run by its number."""
        return composed(self.scheme.format(number))

    def number(self, name: str) -> int | None:
        """Return the number in a run's name, None for a name that the scheme does not make."""
        found = re.fullmatch(self._pattern(), name)
        return None if found is None else int(found["number"])

    def stated_in(self, text: str, known: Collection[str] = ()) -> str | None:
        """Return the run that a file's name, or another text, states; None where it states none, or several.

        Names of the scheme may stand anywhere in it, the longest of the `known` ones where it begins; each with no
        letter or digit beside it.
        """
        begun = [name for name in known if text.startswith(name) and not text[len(name) :][:1].isalnum()]
        found = {max(begun, key=len)} if begun else set()
        rest = text[max(map(len, found), default=0) :]
        found |= {match["name"] for match in re.finditer(rf"(?<![^\W_])(?P<name>{self._pattern()})(?![^\W_])", rest)}
        return found.pop() if len(found) == 1 else None

    def _pattern(self) -> str:
        """Return the regular expression of a name; more digits than the scheme has do not begin with 0."""
        parts = _SCHEME.fullmatch(composed(self.scheme))
        assert parts is not None  # noqa: S101 - `scheme_fault` has looked
        digits = int(parts["digits"] or 1)
        number = rf"(?P<number>[0-9]{{{digits}}}|[1-9][0-9]{{{digits},8}})"
        return f"{re.escape(parts['before'])}{number}{re.escape(parts['after'])}"


def composed(name: str) -> str:
    """Return a name with its letters composed (NFC): file names of macOS have `ü` as a u and a dieresis."""
    return unicodedata.normalize("NFC", name)


def scheme_fault(scheme: str) -> str | None:
    """Return what is wrong with a scheme of names, None where it is one."""
    if _SCHEME.fullmatch(scheme):
        return None
    return (
        f"{scheme!r} does not say how runs are numbered: write the number once, in braces, such as "
        "'r{:03d}' for r001 or 'LOG{:04d}' for LOG0001."
    )
