"""Charges of runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.chunks import in_chunks
from data_schema.tables.equipment import battery
from data_schema.tables.runs import charge, run
from data_schema.vocabulary import ChargeState


@dataclass(frozen=True, slots=True)
class ChargeOfRun:
    """What the charger put back after one run; `run_uid` is empty where it belongs to none."""

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


_COUNTED = charge.c.state == str(ChargeState.COUNTED)


def _charges() -> sa.Select[Any]:
    return (
        sa.select(
            charge.c.uid,
            sa.func.coalesce(run.c.uid, ""),
            charge.c.charge_mah,
            charge.c.resolution_mah,
            charge.c.duration_s,
            charge.c.end_voltage_v,
            charge.c.mode,
            sa.func.coalesce(battery.c.name, charge.c.stated_pack),
            charge.c.ended_utc,
            charge.c.ended_original,
        )
        .outerjoin(run, charge.c.run == run.c.id)
        .outerjoin(battery, charge.c.battery == battery.c.id)
        .order_by(charge.c.id)
    )
