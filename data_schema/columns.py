"""What a column means that people read outside labbook, in a view of the database, a frame or a file."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class ValueKind(StrEnum):
    """What the values of a column are."""

    TEXT = "text"
    NUMBER = "number"
    COUNT = "count"
    FLAG = "flag"
    DATE = "date"
    TIME = "time"


@dataclass(frozen=True, slots=True)
class Column:
    """A column: what it means, its unit, what a missing value means, which values there are, and where it is from.

    A missing value means nothing where `missing` is "": there is none.
    """

    meaning: str
    kind: ValueKind = ValueKind.TEXT
    unit: str = ""
    missing: str = ""
    allowed: str = ""
    source: str = ""

    @property
    def text(self) -> str:
        """Everything but the source, in a line."""
        unit = f", {self.unit}" if self.unit else ""
        allowed = f" ({self.allowed})" if self.allowed else ""
        missing = f"; missing: {self.missing}" if self.missing else ""
        return f"{self.meaning}{allowed}{unit}{missing}"
