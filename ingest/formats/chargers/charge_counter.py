"""What a charger put into a pack or took out of it: its counter, held against the current integrated over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from data_schema.vocabulary import ChargeMode
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import BoolArray, ChargeRow, FloatArray

COUNTER_AGREES = 0.01
"""Of the charge counter, between it and the integral of the current."""

MOST_ROUNDING_MAH = 2.0
"""A difference that the counter's steps of 1 mAh explain."""

RESOLUTION_MAH = 1.0
COUNTER_ANEW = 0.1
"""Of what a counter showed: a counter that falls to less has begun anew."""

LEAST_RISE = 0.003
"""Of the pack's voltage, from which on it shows the direction of the current."""

LONGEST_INTERVAL = 3.0
"""Times the usual one; the current is not integrated over longer ones."""


@dataclass(frozen=True, slots=True, eq=False)
class CountedCharge:
    """One value a record, shape (n,), of a procedure of one direction: elapsed seconds, current and counter as written
    (A, mAh), voltage of the pack, and in which records the charger works. `signed` says that current and counter are
    negative while it discharges; `lines` may be empty.
    """

    lines: Sequence[int]
    seconds: FloatArray
    current_a: FloatArray
    counter_mah: FloatArray
    voltage_v: FloatArray
    active: BoolArray
    mode: ChargeMode
    signed: bool


def charge_row(row_number: int, counted: CountedCharge, findings: FindingCollector) -> ChargeRow:
    """Return the charge of one procedure; a counter that contradicts mode or current refuses the file."""
    sign = -1 if counted.signed and counted.mode is ChargeMode.DISCHARGE else 1
    counter = float(counted.counter_mah[-1])
    if counter * sign < 0:
        message = f"The counter ends at {counter:g} mAh in mode {counted.mode}: the sign contradicts the mode."
        findings.add(FILE, "charge_sign", message, lines=counted.lines[-1:], value=f"{counter:g}")
    _check_counter(counted, sign, findings)
    active = np.flatnonzero(counted.active)
    return ChargeRow(
        row_number,
        None,
        None,
        abs(counter),
        RESOLUTION_MAH,
        float(counted.seconds[active[-1]] - counted.seconds[active[0]]),
        float(counted.voltage_v[active[-1]]),
        counted.mode,
        None,
        None,
        counted.lines[0] if counted.lines else None,
    )


def _check_counter(counted: CountedCharge, sign: int, findings: FindingCollector) -> None:
    """Compare the counter with the current integrated over the intervals without a hole in the log."""
    rises = np.diff(counted.counter_mah)
    back = np.flatnonzero(rises * sign < 0)
    if back.size:
        lines = [counted.lines[row + 1] for row in back[:21].tolist()] if counted.lines else []
        findings.add(NOTE, "counter_backwards", "The charge counter runs backwards.", lines=lines)
    seconds = np.diff(counted.seconds)
    current = counted.current_a
    if not counted.signed and counted.mode is ChargeMode.DISCHARGE and float(current.sum()) < 0:
        current = -current  # such chargers count both directions upwards, and some give the current its sign
    integral = (current[1:] + current[:-1]) / 2 * 1000.0 * seconds / 3600.0
    forward = seconds > 0
    usual = float(np.median(seconds[forward])) if forward.any() else 0.0
    whole = forward & (seconds <= LONGEST_INTERVAL * usual)
    by_counter, by_current = float(rises[whole].sum()), float(integral[whole].sum())
    if abs(by_counter - by_current) > max(COUNTER_AGREES * abs(by_counter), MOST_ROUNDING_MAH):
        message = (
            f"The counter rises by {by_counter:.6g} mAh and the current integrates to {by_current:.6g} mAh, more than "
            "1 % apart: the scale of one of them is not what it should be, or, where `--rate` was declared, the rate."
        )
        findings.add(FILE, "charge_contradicts_current", message, lines=counted.lines[:1])


@dataclass(frozen=True, slots=True)
class Modes:
    """Which numbers a charger writes while it charges, discharges, and after an error."""

    charging: frozenset[int]
    discharging: frozenset[int]
    error: frozenset[int]


def direction_by_modes(
    modes: FloatArray, known: Modes, lines: Sequence[int], channel: int, findings: FindingCollector
) -> ChargeMode | None:
    """Return what a procedure did by its modes, shape (n,); None, noted, when it only watched or did both."""
    present = {int(mode) for mode in modes}
    if present & known.error:
        message = f"The charger stopped channel {channel} with an error: the charge may not be complete."
        rows = np.flatnonzero(np.isin(modes, list(known.error)))
        findings.add(NOTE, "charger_error", message, lines=[lines[row] for row in rows[:21].tolist()])
    charging, discharging = bool(present & known.charging), bool(present & known.discharging)
    if charging == discharging:
        what = "both charges and discharges" if charging else "neither charges nor discharges"
        message = f"Channel {channel} {what}: kept as a signal, no recharge is counted."
        findings.add(NOTE, "no_recharge", message)
        return None
    return ChargeMode.CHARGE if charging else ChargeMode.DISCHARGE


def direction_by_voltage(
    voltage_v: FloatArray, active: BoolArray, where: str, findings: FindingCollector
) -> ChargeMode | None:
    """Return what a procedure did by the pack's voltage, shape (n,), while current flowed, where the file says neither
    direction nor sign: a charge raises it, a discharge lowers it. None, noted, where it does not show.
    """
    working = voltage_v[active]
    tenth = max(1, len(working) // 10)
    if len(working) < 2:
        message = f"{where} neither charges nor discharges: kept as a signal, no recharge is counted."
        findings.add(NOTE, "no_recharge", message)
        return None
    first, last = float(np.median(working[:tenth])), float(np.median(working[-tenth:]))
    if abs(last - first) < LEAST_RISE * abs(first):
        message = f"The voltage of {where} goes from {first:.4g} to {last:.4g} V and the file says no direction: "
        findings.add(NOTE, "no_recharge", message + "kept as a signal, no recharge is counted.")
        return None
    mode = ChargeMode.CHARGE if last > first else ChargeMode.DISCHARGE
    message = f"The file says no direction; the voltage goes from {first:.4g} to {last:.4g} V: read as a {mode}."
    findings.add(NOTE, "direction_by_voltage", message)
    return mode
