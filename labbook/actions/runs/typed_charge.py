"""Stating a charge that was read off a display."""

from __future__ import annotations

import math

from data_schema.errors import UsageError
from data_schema.queries.facts import find_uid
from data_schema.vocabulary import ChargeMode
from labbook.actions.runs.second_charge import refuse_second_charge
from labbook.book.naming import run_named
from labbook.book.write_session import WriteSession
from labbook.config.parsing import Configuration

MOST_OF_CAPACITY = 1.3
"""More than this share of a pack's capacity is a typing error: no pack takes it."""


def state_charge(
    session: WriteSession,
    configuration: Configuration,
    name: str,
    charge_mah: float,
    minutes: float | None,
    end_voltage_v: float | None,
) -> str:
    """State what a charger put back after a run; returns the charge's uid."""
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
    refuse_second_charge(session.connection, run.uid, name)
    return session.declare(
        "charge",
        row_number=1,
        run=run.uid,
        battery=find_uid(session.connection, "battery", name=run.battery),
        charge_mah=charge_mah,
        resolution_mah=configuration.protocol.charger_resolution_mah,
        duration_s=None if minutes is None else minutes * 60.0,
        end_voltage_v=end_voltage_v,
        mode=str(ChargeMode.CHARGE),
    )
