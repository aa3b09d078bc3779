"""What a stand-alone script is made of: rows of a table, the functions that compute a number of them, settings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any

from data_schema.frozen import frozen
from data_schema.outcomes import Outcome

Cell = str | float | int
Row = Mapping[str, Cell]


@frozen
class Script:
    """A number's script.

    Parameters
    ----------
    rows : of the table, whose columns `labbook.scripts.tables.COLUMNS` describes
    steps : functions of templates, each applied to what the one before returns; the first takes
        the table's rows, the last returns the number
    settings : values of the templates' constants, by name
    table : the name of the table's file
    """

    rows: Sequence[Row]
    steps: Sequence[str]
    settings: Mapping[str, object] = field(default_factory=dict)
    table: str = "csv"


@frozen
class Asked:
    """A number that a script is asked for: its name, and the scope of its result."""

    name: str
    scope: Mapping[str, Any]

    @property
    def outcome(self) -> Outcome:
        """The outcome that it is of: joules where the result names none, as of savings."""
        return {str(each): each for each in Outcome}.get(str(self.scope.get("quantity")), Outcome.JOULES)

    @property
    def variant(self) -> str:
        """The variant of the analysis that it is of, "" of the report's own."""
        return str(self.scope.get("variant", ""))
