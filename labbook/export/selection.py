"""The runs that tables are of, and what was measured of them, computed when a table first asks for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import sqlalchemy as sa

from data_schema.queries.runs import refuse_empty_selection
from ingest.store import Store
from labbook.analysis.measured import Measured, measure_study
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.results import Results
from labbook.analysis.study_data import StudyData, gather
from labbook.config.parsing import Configuration


@dataclass
class Selection:
    """The selected runs of an open book, all of them without `where`; `step` is called with what is being done.

    `known` is what was measured of them, if it was: now, or before in a book that has not changed since.
    """

    connection: sa.Connection
    store: Store
    configuration: Configuration
    where: str | None = None
    step: Callable[[str], None] = field(default=lambda _what: None)
    known: Measured | None = None

    @cached_property
    def data(self) -> StudyData:
        """The facts of the runs; raises `InputRefused` where no run fulfils `where`."""
        if self.known is not None:
            return self.known.evidence
        refuse_empty_selection(self.connection, self.where)
        return gather(self.connection, self.configuration, self.where)

    @property
    def measured(self) -> Measured:
        """What a report of these runs measures."""
        if self.known is None:
            detections = Detections(self.connection, self.store, self.step)
            self.known = measure_study(Results(), detections, self.data, self.step)
        return self.known

    @cached_property
    def places(self) -> dict[str, int]:
        """Where each selected run stands in the order of lists, by its name."""
        return {run.name: place for place, run in enumerate(self.data.selected)}
