"""One rule for a second charge of one run, by whatever command it comes."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.queries.charges import charges_of_run
from data_schema.queries.imported_files import charges_of_file, place_of_charge
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import ChargeMode, ChargeState, FileRole


def refuse_second_of_file(connection: sa.Connection, file_uid: str, role: str | None, run: RunRow) -> None:
    """Raise `UsageError` where a file that comes to a run brings its only charge along, and the run has one."""
    charges = charges_of_file(connection, file_uid)
    waiting = [charge for charge in charges if charge.run_uid is None and charge.state is ChargeState.COUNTED]
    if role == FileRole.CHARGE and len(waiting) == 1:
        refuse_second_charge(connection, run.uid, run.name, mode=waiting[0].mode)


def refuse_second_charge(
    connection: sa.Connection,
    run_uid: str,
    run_name: str,
    *,
    charge_uid: str | None = None,
    mode: str = ChargeMode.CHARGE,
) -> None:
    """Raise `UsageError`, which names the first, where a run has a charge other than this one already."""
    if mode != ChargeMode.CHARGE:
        return
    for first in charges_of_run(connection, run_uid):
        if first.uid == charge_uid or first.mode != ChargeMode.CHARGE:
            continue
        place = place_of_charge(connection, first.uid)
        where = "typed in" if place is None else place
        off = f"`labbook assign {place} none --why ...`" if place else f"`labbook correct charge:{first.uid} run=none`"
        raise UsageError(
            f"run {run_name} has a charge already, {first.charge_mah:g} mAh ({where}, charge:{first.uid}): correct "
            f"that one with `labbook correct charge:{first.uid} charge_mah=VALUE`, or take it off first with {off}; a "
            "row of the inbox that is no charge of a run goes with `labbook runs dismiss NAME#ROW --why ...`."
        )
