"""Stating a charge that was read off a display; and one rule for a second charge of one run, by whatever command."""

from __future__ import annotations

import math
from decimal import Decimal

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.queries.charges import charges_of_run
from data_schema.queries.facts import find_uid
from data_schema.queries.files import charges_of_file, place_of_charge
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import ChargeMode, ChargeState, FileRole
from labbook.book.naming import run_named
from labbook.book.write_session import WriteSession
from labbook.config.parsing import Configuration


def state_charge(
    session: WriteSession,
    configuration: Configuration,
    name: str,
    charge_mah: float,
    minutes: float | None,
    end_voltage_v: float | None,
    *,
    add: bool = False,
) -> str:
    """State what a charger put back after a run, beside what the run has where `add`; returns the charge's uid."""
    from ingest.formats.chargers.sheet import MOST_OF_CAPACITY  # with readers of files, which others need not load

    run = run_named(session.connection, name)
    if not (math.isfinite(charge_mah) and charge_mah >= 0):
        raise UsageError(f"MAH {charge_mah:g} is not possible: give what the charger put back, 0 or more.")
    for what, value in (("--minutes", minutes), ("--end-voltage", end_voltage_v)):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise UsageError(f"{what} {value:g} is not possible: give a number above 0.")
    most = (
        MOST_OF_CAPACITY * configuration.batteries[run.battery].capacity_mah
        if run.battery in configuration.batteries
        else math.inf
    )
    if charge_mah > most:
        raise UsageError(
            f"{charge_mah:g} mAh is more than pack {run.battery} can take ({most:g} mAh): check number and unit."
        )
    if add:
        refuse_added_to_nothing(session.connection, run)
    else:
        refuse_second_charge(session.connection, run.uid, name)
    return session.declare(
        "charge",
        row_number=1,
        run=run.uid,
        battery=find_uid(session.connection, "battery", name=run.battery),
        charge_mah=charge_mah,
        resolution_mah=_last_digit(charge_mah),
        duration_s=None if minutes is None else minutes * 60.0,
        end_voltage_v=end_voltage_v,
        mode=str(ChargeMode.CHARGE),
        **({"added": 1} if add else {}),
    )


def _last_digit(number: float) -> float:
    """Return the step of the last digit of a number as it was typed, at most 1."""
    exponent = Decimal(repr(number)).normalize().as_tuple().exponent
    assert isinstance(exponent, int)  # noqa: S101 - of a finite number
    return 10.0 ** min(0, exponent)


def refuse_added_to_nothing(connection: sa.Connection, run: RunRow) -> None:
    """Raise `UsageError` where a run has no charge that another one could be added to."""
    if all(charge.added or charge.mode != ChargeMode.CHARGE for charge in charges_of_run(connection, run.uid)):
        raise UsageError(f"run {run.name} has no charge yet that this one could be added to: leave --add out.")


def refuse_second_of_file(connection: sa.Connection, file_uid: str, role: str | None, run: RunRow) -> None:
    """Raise `UsageError` where a file that comes to a run brings its only charge along, and the run has one."""
    charges = charges_of_file(connection, file_uid)
    waiting = [charge for charge in charges if charge.run_uid is None and charge.state is ChargeState.COUNTED]
    if role == FileRole.CHARGE and len(waiting) == 1:
        refuse_second_charge(connection, run.uid, run.name, charge_uid=waiting[0].uid, mode=waiting[0].mode)


def refuse_second_charge(
    connection: sa.Connection,
    run_uid: str,
    run_name: str,
    *,
    charge_uid: str | None = None,
    mode: str = ChargeMode.CHARGE,
) -> None:
    """Raise `UsageError`, which names the first, where a run has a charge other than this one already.

    `charge_uid` is None for one that is being typed in.
    """
    if mode != ChargeMode.CHARGE:
        return
    for first in charges_of_run(connection, run_uid):
        if first.uid == charge_uid or first.added or first.mode != ChargeMode.CHARGE:
            continue
        place = place_of_charge(connection, first.uid)
        where = "typed in" if place is None else place
        off = f"`labbook assign {place} none --why ...`" if place else f"`labbook correct charge:{first.uid} run=none`"
        add = "give it with --add" if charge_uid is None else f"`labbook assign charge:{charge_uid} {run_name} --add`"
        raise UsageError(
            f"run {run_name} has a charge already, {first.charge_mah:g} mAh ({where}, charge:{first.uid}): correct "
            f"that one with `labbook correct charge:{first.uid} charge_mah=VALUE`, or take it off first with {off}; if "
            f"the pack was charged in parts, {add}; a row of the inbox that is no charge of a run goes with `labbook "
            "runs dismiss NAME#ROW --why ...`."
        )
