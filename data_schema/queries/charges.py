"""Charges: those of runs, which count, and those that the rows of files say, in whatever state they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.tables.base import columns_of, in_chunks
from data_schema.tables.equipment import battery
from data_schema.tables.files import file
from data_schema.tables.runs import charge, run
from data_schema.vocabulary import ChargeState


@dataclass(frozen=True, slots=True)
class ChargeOfRun:
    """What the charger put back after one run; `run_uid` is empty where it belongs to none.

    `added`: it is a further part of what was put back, beside another charge of the run.
    """

    uid: str
    run_uid: str
    charge_mah: float
    resolution_mah: float
    recharge_s: float | None
    end_voltage_v: float | None
    mode: str
    stated_pack: str | None
    ended_utc: str | None
    ended_original: str | None
    added: bool


def charges_by_run(connection: sa.Connection) -> dict[str, list[ChargeOfRun]]:
    """Return all charges that belong to a run, by the run's uid."""
    found: dict[str, list[ChargeOfRun]] = {}
    for row in connection.execute(_of_runs()):
        found.setdefault(row[1], []).append(ChargeOfRun(*row))
    return found


def every_charge(connection: sa.Connection) -> list[ChargeOfRun]:
    """Return all charges, also those that belong to no run or do not count."""
    return [ChargeOfRun(*row) for row in connection.execute(_charges())]


def charges_of_run(connection: sa.Connection, run_uid: str) -> list[ChargeOfRun]:
    """Return the charges of one run."""
    return [ChargeOfRun(*row) for row in connection.execute(_of_runs().where(charge.c.run == _key(run_uid)))]


def charges_of_runs(connection: sa.Connection, run_uids: Sequence[str]) -> dict[str, list[ChargeOfRun]]:
    """Return the charges of some runs, by the run's uid."""
    found: dict[str, list[ChargeOfRun]] = {}
    for some in in_chunks(run_uids):
        keys = sa.select(run.c.id).where(run.c.uid.in_(some))
        for row in connection.execute(_of_runs().where(charge.c.run.in_(keys))):
            found.setdefault(row[1], []).append(ChargeOfRun(*row))
    return found


def _key(run_uid: str) -> sa.ScalarSelect[int]:
    return sa.select(run.c.id).where(run.c.uid == run_uid).scalar_subquery()


def _of_runs() -> sa.Select[Any]:
    return _charges().where(charge.c.run.is_not(None), _COUNTED)


_COUNTED = charge.c.state == ChargeState.COUNTED
_ADDED = charge.c.added == 1


def _charges() -> sa.Select[Any]:
    return (
        sa.select(
            *columns_of(
                ChargeOfRun,
                charge,
                run_uid=sa.func.coalesce(run.c.uid, ""),
                recharge_s=charge.c.duration_s,
                stated_pack=sa.func.coalesce(battery.c.name, charge.c.stated_pack),
                added=_ADDED,
            )
        )
        .outerjoin(run, charge.c.run == run.c.id)
        .outerjoin(battery, charge.c.battery == battery.c.id)
        .order_by(charge.c.id)
    )


@dataclass(frozen=True, slots=True)
class SheetRow:
    """A charge of a file, or a typed one; `repeats` is the uid of the equal charge that there was when this one came.

    `order` rises from the charges that came first to the last. `added`: see `ChargeOfRun`.
    """

    order: int
    uid: str
    row_number: int
    line: int | None
    stated_run: str | None
    state: ChargeState
    charge_mah: float
    resolution_mah: float
    duration_s: float | None
    end_voltage_v: float | None
    mode: str
    stated_pack: str | None
    ended_utc: str | None
    ended_original: str | None
    run_uid: str | None = None
    run_name: str | None = None
    repeats: str | None = None
    added: bool = False

    @property
    def contents(self) -> tuple[object, ...]:
        """What the row says, and whose it is; not where it stands, nor whether it counts."""
        stated = (self.stated_run, self.stated_pack, self.ended_utc, self.ended_original, self.run_uid)
        return (self.charge_mah, self.resolution_mah, self.duration_s, self.end_voltage_v, self.mode, *stated)


def rows_of_file(connection: sa.Connection, file_uid: str) -> list[SheetRow]:
    """Return all charges that a file ever held, by row number."""
    return _rows(connection, file.c.uid == file_uid)


def repeating(connection: sa.Connection, uids: Sequence[str], state: ChargeState) -> dict[str, list[SheetRow]]:
    """Return the charges in a state that repeat an earlier one, by the uid of that one."""
    found: dict[str, list[SheetRow]] = {uid: [] for uid in uids}
    for some in in_chunks(uids):
        for row in _rows(connection, sa.and_(charge.c.repeats.in_(some), charge.c.state == str(state))):
            found[row.repeats or ""].append(row)
    return found


def rows_with_uids(connection: sa.Connection, uids: Sequence[str]) -> list[SheetRow]:
    """Return the charges with these uids, those that came first before the others."""
    found = [row for some in in_chunks(uids) for row in _rows(connection, charge.c.uid.in_(some))]
    return sorted(found, key=lambda row: row.order)


def rows_about(connection: sa.Connection, run_uids: Sequence[str], run_names: Sequence[str]) -> list[SheetRow]:
    """Return the charges that belong to some runs, then those that name one and belong to none; dismissed ones too."""
    counted, dismissed = ChargeState.COUNTED, ChargeState.DISMISSED
    found = []
    for some in in_chunks(run_uids):
        keys = sa.select(run.c.id).where(run.c.uid.in_(some))
        found += _rows(connection, sa.and_(charge.c.run.in_(keys), charge.c.state == counted))
    for some in in_chunks(run_names):
        standing = charge.c.state.in_((counted, dismissed))
        found += _rows(connection, sa.and_(charge.c.run.is_(None), charge.c.stated_run.in_(some), standing))
    return found


def _rows(connection: sa.Connection, wanted: sa.ColumnElement[Any]) -> list[SheetRow]:
    query = (
        sa.select(
            *columns_of(SheetRow, charge, order=charge.c.id, run_uid=run.c.uid, run_name=run.c.name, added=_ADDED)
        )
        .outerjoin(run, charge.c.run == run.c.id)
        .outerjoin(file, charge.c.file == file.c.id)
        .where(wanted)
        .order_by(charge.c.row_number, charge.c.id)
    )
    rows = connection.execute(query).mappings()
    return [SheetRow(**{**row, "state": ChargeState(row["state"])}) for row in rows]
