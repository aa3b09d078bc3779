"""Steady jumps on emulator and force plate as tables, what is published in brackets beside what is simulated."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from reports.display import decimal_text
from reports.tables.table import Cell, Column, Row, Table
from simulator.steady.emulator import EmulatorRow, EmulatorTable
from simulator.steady.force_plate import ESTIMATED_OVER_MEASURED, PlateRow, PlateTable
from simulator.steady.published_numbers import apex_between_m, published_numbers

R = TypeVar("R", EmulatorRow, PlateRow)
APEX = "apex"
_ON_THE_LINE = (200.0, 300.0)
"""Gains between the two whose apexes are published."""


@dataclass(frozen=True, slots=True)
class ShownColumn(Generic[R]):
    """A column: how a row's value, in the unit of `field`, is shown; `published` names what stands beside it."""

    title: str
    unit: str
    field: str
    value: Callable[[R], float]
    places: int = 0
    factor: float = 1.0
    published: str = ""

    def cell(self, row: R, beside: Mapping[tuple[str, float], str]) -> Cell:
        """Make the cell of a row: the simulated number, and in brackets the published one."""
        value = self.value(row)
        text = decimal_text(self.factor * value, self.places)
        known = beside.get((self.published, row.gain))
        return Cell(f"{text} ({known})" if known else text, (value,))


EMULATOR_COLUMNS: tuple[ShownColumn[EmulatorRow], ...] = (
    ShownColumn("gain", "", "gain", lambda row: row.gain),
    ShownColumn("apex CE", "m", "apex_height_m", lambda row: row.ce.apex_height_m, 3, published=APEX),
    ShownColumn("joules CE", "J", "cost_j", lambda row: row.ce.cost_j, 1),
    ShownColumn(
        "saving, scaled", "%", "scaled_saving", lambda row: row.scaled_saving, 1, 100.0, published="scaled_saving"
    ),
    ShownColumn(
        "saving, constant",
        "%",
        "constant_saving",
        lambda row: row.constant_saving,
        1,
        100.0,
        published="constant_saving",
    ),
    ShownColumn("apex lost, scaled", "%", "scaled_loss", lambda row: row.scaled_loss, 1, 100.0, published="loss"),
    ShownColumn("apex lost, constant", "%", "constant_loss", lambda row: row.constant_loss, 1, 100.0, published="loss"),
    ShownColumn("sink at switch", "mm", "switch_depth_m", lambda row: row.yielding.switch_depth_m, 0, 1e3),
    ShownColumn("deepest sink", "mm", "max_depth_m", lambda row: row.ce.max_depth_m, 0, 1e3),
    ShownColumn("period", "s", "period_s", lambda row: row.ce.period_s, 2),
    ShownColumn("capped", "ms", "capped_time_s", lambda row: row.ce.capped_time_s, 0, 1e3),
    ShownColumn("within reach", "J", "yielding_heat_j", lambda row: row.yielding.heat_j, 1),
)
PLATE_COLUMNS: tuple[ShownColumn[PlateRow], ...] = (
    ShownColumn("gain", "", "gain", lambda row: row.gain),
    ShownColumn("apex", "m", "apex_height_m", lambda row: row.jump.apex_height_m, 3),
    ShownColumn("heat", "J", "heat_j", lambda row: row.jump.heat_j, 1),
    ShownColumn("mechanical", "J", "mechanical_j", lambda row: row.jump.mechanical_j, 1),
    ShownColumn("drag", "J", "drag_j", lambda row: row.jump.drag_j, 1),
    ShownColumn("joules", "J", "cost_j", lambda row: row.jump.cost_j, 1),
    ShownColumn(f"joules / {ESTIMATED_OVER_MEASURED:g}", "J", "battery_j", lambda row: row.battery_j, 1),
    ShownColumn("touchdown", "m/s", "touchdown_velocity_m_s", lambda row: row.jump.touchdown_velocity_m_s, 2),
    ShownColumn("foot's loss", "J", "impact_loss_j", lambda row: row.jump.impact_loss_j, 2),
    ShownColumn("capped", "ms", "capped_time_s", lambda row: row.jump.capped_time_s, 0, 1e3),
    ShownColumn("shortest leg", "m", "min_leg_length_m", lambda row: row.jump.min_leg_length_m, 3),
)


def emulator_shown(table: EmulatorTable) -> Table:
    """Make the table of the ground emulator."""
    caption = (
        f"Jump {table.scene.jumps} of {table.scene.jumps} on the ground emulator; in brackets what the thesis says "
        "(4.3, 4.4), with ~ on the straight line between the two apexes that it gives. Savings and lost apex heights "
        "are those of active damping against compression-extension (CE): scaled, its gain a sixth of the extension "
        "gain, and constant, a gain of 50. Joules are heat and mechanical energy of a whole jump. Sink: of the "
        "platform under CE. Capped: at the motors' stall torque. Within reach: the heat under CE while the extending "
        "leg drives the platform down, where active damping acts."
    )
    return Table("emulator", caption, _heads(EMULATOR_COLUMNS), _rows(EMULATOR_COLUMNS, table.rows))


def plate_shown(table: PlateTable) -> Table:
    """Make the table of the force plate."""
    caption = (
        f"Jump {table.scene.jumps} of {table.scene.jumps} on the force plate, compression-extension. Of this "
        "experiment the thesis gives no apex and no joules, only the slope of the joules estimated from the plate's "
        f"forces over those of the battery, {ESTIMATED_OVER_MEASURED:g} (3.2.2): nothing stands beside these numbers. "
        "Touchdown: velocity of the body. Foot's loss: its kinetic energy when the plate stops it."
    )
    return Table("force_plate", caption, _heads(PLATE_COLUMNS), _rows(PLATE_COLUMNS, table.rows))


def _heads(columns: tuple[ShownColumn[R], ...]) -> tuple[Column, ...]:
    return tuple(Column(column.title, (column.field,), column.unit) for column in columns)


def _rows(columns: tuple[ShownColumn[R], ...], rows: tuple[R, ...]) -> tuple[Row, ...]:
    beside = _beside()
    return tuple(Row(tuple(column.cell(row, beside) for column in columns)) for row in rows)


def _beside() -> dict[tuple[str, float], str]:
    """Return the published words by column and gain."""
    found = {(number.column, gain): number.beside for number in published_numbers() for gain in number.gains}
    return found | {(APEX, gain): f"~{decimal_text(apex_between_m(gain), 3)}" for gain in _ON_THE_LINE}
