"""Says what each column of a table became, and where its unit and the rate come from."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from ingest.channels.columns import ColumnPlan, Plan, TimePlan
from ingest.channels.declared import declared_columns
from ingest.channels.synonyms import UNIT_OF_NAME
from ingest.explanation import ColumnUse, TableUse
from ingest.instruments import Instrument
from ingest.model import Declarations
from ingest.tables.header_cells import normal_unit, parse_header, squash
from ingest.tables.table import CellKind, Table

LEFT_OUT = {
    CellKind.TEXT: "it holds text",
    CellKind.CLOCK: "it holds dates or times",
    CellKind.EMPTY: "it is empty",
}


def table_use(
    table: Table,
    plan: Plan,
    columns: Sequence[ColumnPlan],
    declared: Declarations,
    instrument: Instrument,
    trial_column: int | None,
) -> TableUse:
    """Say what became of a table whose final columns are `columns`."""
    by_position = {column.position: column for column in columns}
    origin = _UnitOrigin(table, declared, instrument)
    uses = []
    for position, name in enumerate(table.names):
        use = ColumnUse(position + 1, name, None)
        found = by_position.get(position)
        if plan.time is not None and position == plan.time.position:
            unit = plan.time.unit or ("clock" if plan.time.kind is CellKind.CLOCK else None)
            use = dataclasses.replace(use, holds="time", unit=unit, unit_from=origin.of_time(plan.time))
        elif plan.time is not None and position == plan.time.date_position:
            use = dataclasses.replace(use, holds="date")
        elif found is not None:
            use = ColumnUse(
                position + 1,
                name,
                found.channel,
                found.source_unit,
                found.unit,
                origin.of(position, found.source_unit),
                found.sign,
                found.assumed,
            )
        elif position == trial_column:
            use = dataclasses.replace(use, holds="trial")
        else:
            use = dataclasses.replace(use, left_out=LEFT_OUT.get(table.kinds[position], "nothing is known of it"))
        uses.append(use)
    return TableUse(table.text, tuple(uses), _rate_from(table, plan, declared, instrument))


@dataclasses.dataclass(frozen=True, slots=True)
class _UnitOrigin:
    table: Table
    declared: Declarations
    instrument: Instrument

    def of(self, position: int, unit: str | None) -> str | None:
        """Return where the unit of a column was found; None where it is nowhere."""
        name = self.table.names[position]
        directly = dataclasses.replace(self.declared, profile_columns={})
        for declared, where in ((directly, "declared"), (self.declared, f"profile {self.declared.profile}")):
            said = declared_columns(declared, self.table.names).get(position)
            if said is not None and said.unit and normal_unit(said.unit) == unit:
                return where
        cell = parse_header(name)
        row = self.table.units[position]
        if unit is None:
            return None
        if unit in (cell.unit, cell.suffix_unit):
            return "header"
        if row is not None and normal_unit(row) == unit:
            return "header" if self.table.text is None else "row of units"
        if UNIT_OF_NAME.get(squash(cell.base)) == unit:
            return "name"
        return self.instrument.convention.maker or None

    def of_time(self, time: TimePlan) -> str | None:
        """Return where the unit of the time column was found."""
        if time.unit is not None and self.declared.time_unit is not None:
            return "declared" if self.declared.profile is None else f"declared, or profile {self.declared.profile}"
        return self.of(time.position, time.unit)


def _rate_from(table: Table, plan: Plan, declared: Declarations, instrument: Instrument) -> str | None:
    if plan.time is not None:
        fixed = f", or {instrument.fixed_rate_hz:g} Hz fixed by the maker" if instrument.fixed_rate_hz else ""
        return f"the stamps in column {plan.time.source_name!r}{fixed}"
    if declared.rate_hz is not None:
        return "declared" if declared.profile is None else f"declared, or profile {declared.profile}"
    if table.preamble.rate_hz is not None:
        return "the file's header" if table.preamble.rate_line is None else f"the line {table.preamble.rate_line!r}"
    return None
