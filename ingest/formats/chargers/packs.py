"""Recharges against what is known of the packs: none takes much more than it holds.

A recharge above that is left out with its row, where it is one of a sheet; the log of one is refused.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from ingest.declared import flag_of
from ingest.model import FILE, ROW, ChargeRow, ColumnUse, FindingCollector, PackFacts, Reading

MOST_OF_CAPACITY = 1.3
"""More than this share of a pack's capacity is a typing error: no pack takes it."""
_IMPLAUSIBLE = "charge_implausible"
_MAH_PER_AH = 1e3


def check_packs(reading: Reading, packs: Sequence[PackFacts], findings: FindingCollector) -> Reading:
    """Return a reading without the recharges that their pack cannot take, each of them reported.

    A recharge without a pack of the book is compared with the largest. A column in mAh, by its heading, of nothing but
    numbers below a thousandth of that is refused: they may be Ah.
    """
    largest = max(packs, key=lambda pack: pack.capacity_mah)
    by_name = {pack.name: pack for pack in packs}
    of_charge = [by_name.get(charge.stated_pack or "", largest) for charge in reading.charges]
    column = next((use for table in findings.tables for use in table.columns if use.holds == "charge"), None)
    flag = "" if column is None else flag_of(findings.tables, column.name)
    remedy = _unit_remedy(column, flag) if column is not None and column.unit == "Ah" else ""  # in mAh it is less
    kept: list[ChargeRow] = []
    for charge, pack in zip(reading.charges, of_charge, strict=True):
        most_mah = MOST_OF_CAPACITY * pack.capacity_mah
        if charge.charge_mah <= most_mah:
            kept.append(dataclasses.replace(charge, row_number=len(kept) + 1))
            continue
        message = (
            f"{charge.charge_mah:g} mAh is more than pack {pack.name} can take ({most_mah:g} mAh): correct the number, "
            f"{remedy}or, if it is right, the pack's capacity, with `labbook correct "
            f"battery:{pack.name} capacity_mah=... --why ...` and in labbook.toml."
        )
        lines = [] if charge.line is None else [charge.line]
        value = f"{charge.charge_mah:g} mAh"
        findings.add(FILE if reading.parts else ROW, _IMPLAUSIBLE, message, lines=lines, value=value)
    _refuse_ah(reading, of_charge, column, flag, findings)
    left_out = len(reading.charges) - len(kept)
    return dataclasses.replace(reading, charges=tuple(kept), rows_rejected=reading.rows_rejected + left_out)


def _refuse_ah(
    reading: Reading, packs: Sequence[PackFacts], column: ColumnUse | None, flag: str, findings: FindingCollector
) -> None:
    if column is None or column.unit != "mAh" or column.unit_from != "header":
        return
    most = [MOST_OF_CAPACITY * pack.capacity_mah for pack in packs]
    charges = [charge.charge_mah for charge in reading.charges]
    if any(charges) and all(mah * _MAH_PER_AH <= top for mah, top in zip(charges, most, strict=True)):
        message = (
            f"All charges are {max(charges):g} mAh or less, as if in Ah: correct {_unit_remedy(column, flag)}or, if "
            f'they are mAh, say so: `--column "{flag}=charge:mAh"`.'
        )
        lines = [charge.line for charge in reading.charges if charge.line is not None]
        findings.add(FILE, _IMPLAUSIBLE, message, lines=lines, value=f"{max(charges):g} mAh")


def _unit_remedy(column: ColumnUse | None, flag: str) -> str:
    """Say how the other unit is declared, of a column whose heading has one."""
    if column is None or column.unit is None:
        return ""
    other = "mAh" if column.unit == "Ah" else "Ah"
    return f'the heading {column.name!r} if these are {other} (`--column "{flag}=charge:{other}" --override-units`), '
