"""Read a TOML table key by key and collect every fault on the way, so that a person sees all of them at once."""

from __future__ import annotations

import json
import math
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from enum import StrEnum
from typing import Any, TypeVar

from data_schema.errors import unknown_name

_Word = TypeVar("_Word", bound=StrEnum)
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def is_plain(text: str) -> bool:
    """Tell whether a text can be shown, typed and stored: not empty, not padded with spaces, nothing unprintable."""
    return text != "" and text == text.strip() and not any(unicodedata.category(sign) in ("Cc", "Cs") for sign in text)


def as_number(given: Any) -> float | None:
    """Return a finite float, or None for anything that is not a finite number (true and false are none)."""
    if isinstance(given, bool) or not isinstance(given, int | float):
        return None
    try:
        number = float(given)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


class TableReader:
    """One table of a configuration.

    A fault is added to `faults`, and reading goes on with a value of the right type (NaN for a number); what was read
    may be used only if `faults` is empty in the end. A key with a default may be absent.
    """

    def __init__(self, table: Mapping[str, Any], path: str, faults: list[str]) -> None:
        self._table = table
        self._path = path
        self._faults = faults
        self._known: set[str] = set()

    def fault(self, key: str, sentence: str) -> None:
        """Add a fault of `key`."""
        self._faults.append(f"{self._path}.{key}: {sentence}" if self._path else f"{key}: {sentence}")

    def value(self, key: str) -> Any:
        """Return the value as TOML gave it, None where absent."""
        self._known.add(key)
        return self._table.get(key)

    def names(self) -> Iterator[str]:
        """Go through the keys of a table whose keys are names that a person chose."""
        for name in self._table:
            self._known.add(name)
            if is_plain(name):
                yield name
            else:
                self.fault(repr(name), "a name is not empty, padded with spaces or unprintable: change it.")

    def text(self, key: str) -> str:
        """Read a text."""
        given = self._required(key, "a text in quotes")
        return "" if given is None else self._checked_text(key, given)

    def optional_text(self, key: str) -> str | None:
        """Read a text, or None where absent."""
        given = self.value(key)
        return None if given is None else self._checked_text(key, given)

    def number(
        self, key: str, default: float | None = None, *, above: float = -math.inf, most: float = math.inf
    ) -> float:
        """Read a finite number greater than `above`, `most` at most."""
        given = self._required(key, "a number such as 1.5") if default is None else self.value(key)
        if given is None:
            return math.nan if default is None else default
        return self._checked_number(key, given, above, most)

    def optional_number(self, key: str, *, above: float = -math.inf) -> float | None:
        """Read a finite number greater than `above`, or None where absent."""
        given = self.value(key)
        return None if given is None else self._checked_number(key, given, above)

    def whole(self, key: str, default: int | None = None, *, least: int) -> int:
        """Read a whole number of `least` or more."""
        given = self._required(key, f"a whole number of {least} or more") if default is None else self.value(key)
        if given is None:
            return least if default is None else default
        if not isinstance(given, int) or isinstance(given, bool) or not least <= given < 2**63:
            self.fault(key, f"{given!r} is not a whole number of {least} or more: write one, without quotes.")
            return least
        return given

    def flag(self, key: str, default: bool) -> bool:
        """Read true or false."""
        given = self.value(key)
        if given is not None and not isinstance(given, bool):
            self.fault(key, f"{given!r} is neither true nor false: write one of them, without quotes.")
        return default if given is None else bool(given)

    def word(self, key: str, words: type[_Word], default: _Word | None = None) -> _Word:
        """Read one word of a closed list."""
        listed = [str(word) for word in words]
        given = self._required(key, f"one of {', '.join(listed)}") if default is None else self.value(key)
        if given is None:
            return next(iter(words)) if default is None else default
        return words(self.known(key, given, listed, key.replace("_", " ")))

    def known(self, key: str, given: Any, allowed: Iterable[str], what: str) -> str:
        """Return `given` if it is one of the `allowed` texts, else add a fault that names the nearest."""
        options = list(allowed)
        if given in options:
            return str(given)
        self.fault(key, str(unknown_name(what, str(given), options)))
        return options[0] if options else ""

    def items(self, key: str, what: str) -> list[Any]:
        """Read a list, empty where absent; `what` says of what."""
        given = self.value(key)
        if given is not None and not isinstance(given, list):
            self.fault(key, f"{given!r} is not a list: write {what} in square brackets with commas between.")
            return []
        return given or []

    def list_of_tables(self, key: str) -> list[TableReader]:
        """Open each table of a list, empty where absent."""
        given = self.items(key, "tables in braces")
        if not all(isinstance(item, dict) for item in given):
            self.fault(key, f"{given!r} is no list of tables: write them in braces, with commas between.")
            return []
        path = f"{self._path}.{key}" if self._path else key
        return [TableReader(item, path, self._faults) for item in given]

    def table(self, key: str, *, required: bool = False, text_key: str | None = None) -> TableReader:
        """Open a table below this one, empty where absent; `text_key` is its key for a text in its place."""
        given = self.value(key)
        name = key if _BARE_KEY.fullmatch(key) else json.dumps(key, ensure_ascii=False)
        path = f"{self._path}.{name}" if self._path else name
        if isinstance(given, dict) or (given is None and not required):
            return TableReader(given or {}, path, self._faults)
        found = "is missing" if given is None else f"{given!r} is not a table"
        advice = f"[{path}] on a line of its own and its keys below."
        if text_key is not None and isinstance(given, str):
            advice = f"{name} = {{ {text_key} = {json.dumps(given, ensure_ascii=False)} }}"
        self.fault(key, f"{found}: write {advice}")
        return TableReader({}, path, [])  # one fault is enough

    def tables(self, key: str, *, text_key: str | None = None) -> Iterator[tuple[str, TableReader]]:
        """Open each table whose name a person chose, such as `[robots.hopper]`."""
        parent = self.table(key)
        for name in parent.names():
            yield name, parent.table(name, required=True, text_key=text_key)

    def finish(self) -> None:
        """Add a fault for every key that was not read: a typing error must not become a default."""
        for key in self._table:
            if key not in self._known:
                self.fault(key, str(unknown_name("key", key, self._known)))

    def _required(self, key: str, what: str) -> Any:
        given = self.value(key)
        if given is None:
            self.fault(key, f"is missing: give {what}.")
        return given

    def _checked_text(self, key: str, given: Any) -> str:
        if isinstance(given, str) and is_plain(given):
            return given
        self.fault(key, f"{given!r} is not a text, or empty, padded or unprintable: write a plain text in quotes.")
        return ""

    def _checked_number(self, key: str, given: Any, above: float, most: float = math.inf) -> float:
        number = as_number(given)
        if number is not None and above < number <= most:
            return number
        least = "" if above == -math.inf else f" greater than {above:g}"
        least += "" if most == math.inf else f", {most:g} at most"
        self.fault(key, f"{given!r} is not a number{least}: write one such as 1.5, without quotes.")
        return math.nan
