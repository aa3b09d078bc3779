"""Charges: those of runs, which count, and those that the rows of files say, in whatever state they are."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sqlalchemy as sa

from data_schema.tables.base import columns_of, in_chunks
from data_schema.tables.equipment import battery
from data_schema.tables.files import file
from data_schema.tables.plain import fetch
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
    """A charge of a file, or a typed one: what its reading says, what people said of it, and where it stands.

    `order` rises from the charges that came first to the last. `named_run` is the run that it, or its file, names;
    `assigned_run` the one that a person gave it to, where `assigned` is not 0: a later assignment to a run has a higher
    number. `added`: see `ChargeOfRun`. `corrected` has what was read and what is right of each column that a person
    corrected. It counts for `run_uid`; `repeats` is the uid of the charge that says the same.
    """

    order: int
    uid: str
    row_number: int
    line: int | None
    stated_run: str | None
    charge_mah: float
    resolution_mah: float
    duration_s: float | None
    end_voltage_v: float | None
    mode: str
    stated_pack: str | None
    ended_utc: str | None
    ended_original: str | None
    file_uid: str | None = None
    named_run: str | None = None
    assigned: int = 0
    assigned_run: str | None = None
    added: bool = False
    dismissed: bool = False
    corrected: Mapping[str, tuple[Any, Any]] = field(default_factory=dict)
    state: ChargeState = ChargeState.COUNTED
    run_uid: str | None = None
    run_name: str | None = None
    repeats: str | None = None

    @property
    def contents(self) -> tuple[object, ...]:
        """What the row says, and whose it is; not whether it counts."""
        stated = (self.stated_run, self.stated_pack, self.ended_utc, self.ended_original)
        whose = self.assigned_run if self.assigned else self.named_run
        return (self.charge_mah, self.resolution_mah, self.duration_s, self.end_voltage_v, self.mode, *stated, whose)


def rows_of_file(connection: sa.Connection, file_uid: str) -> list[SheetRow]:
    """Return all charges that a file ever held, by row number."""
    return _rows(connection, file.c.uid == file_uid)


def rows_with_uids(connection: sa.Connection, uids: Sequence[str]) -> list[SheetRow]:
    """Return the charges with these uids."""
    return [row for some in in_chunks(uids) for row in _rows(connection, charge.c.uid.in_(some))]


def rows_about(connection: sa.Connection, run_uids: Sequence[str], names: Sequence[str] = ()) -> list[SheetRow]:
    """Return the charges that name some runs or were given to them, and those with names that no run has, in order.

    Those are left out that no reading in force has.
    """
    wanted = []
    for some in in_chunks(run_uids):
        keys = sa.select(run.c.id).where(run.c.uid.in_(some))
        wanted.append(sa.or_(charge.c.named_run.in_(keys), charge.c.assigned_run.in_(keys)))
    wanted += [sa.and_(charge.c.named_run.is_(None), charge.c.stated_run.in_(some)) for some in in_chunks(names)]
    found = {
        row.uid: row
        for some in wanted
        for row in _rows(connection, sa.and_(some, charge.c.state != str(ChargeState.GONE)))
    }
    return sorted(found.values(), key=lambda row: row.order)


def charges_naming(connection: sa.Connection, name: str) -> list[str]:
    """Return the uids of the charges with a name that no run had."""
    return [uid for (uid,) in fetch(connection, _NAMING, {"named": name})]


# Built once: a sheet states thousands of runs, and each is asked for what waits for it.
_NAMING = (
    sa.select(charge.c.uid)
    .where(charge.c.named_run.is_(None), charge.c.stated_run == sa.bindparam("named"))
    .order_by(charge.c.id)
)


def waiting_charges(connection: sa.Connection) -> list[str]:
    """Return the uids of the charges that would count and belong to no run."""
    query = sa.select(charge.c.uid).where(charge.c.run.is_(None), _COUNTED).order_by(charge.c.id)
    return list(connection.execute(query).scalars())


def assignments_to(connection: sa.Connection, run_uid: str) -> int:
    """Return how often charges were assigned to a run."""
    query = sa.select(sa.func.max(charge.c.assigned)).where(charge.c.assigned_run == _key(run_uid))
    most: int | None = connection.scalar(query)
    return most or 0


_NAMED, _ASSIGNED = run.alias(), run.alias()


def _rows(connection: sa.Connection, wanted: sa.ColumnElement[Any]) -> list[SheetRow]:
    runs = {"run_uid": run.c.uid, "run_name": run.c.name, "named_run": _NAMED.c.uid, "assigned_run": _ASSIGNED.c.uid}
    flags = {"added": charge.c.added == 1, "dismissed": charge.c.dismissed == 1}
    query = (
        sa.select(*columns_of(SheetRow, charge, order=charge.c.id, file_uid=file.c.uid, **runs, **flags))
        .outerjoin(run, charge.c.run == run.c.id)
        .outerjoin(_NAMED, charge.c.named_run == _NAMED.c.id)
        .outerjoin(_ASSIGNED, charge.c.assigned_run == _ASSIGNED.c.id)
        .outerjoin(file, charge.c.file == file.c.id)
        .where(wanted)
        .order_by(charge.c.row_number, charge.c.id)
    )
    return [
        SheetRow(**{**row, "state": ChargeState(row["state"]), "corrected": json.loads(row["corrected"] or "{}")})
        for row in connection.execute(query).mappings()
    ]
