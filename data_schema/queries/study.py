"""The study: what it is about, and its factors with their levels."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.tables.design import factor, level, study


@dataclass(frozen=True, slots=True)
class LevelRow:
    """One level of a factor."""

    uid: str
    label: str
    value: float | None
    attributes_json: str


@dataclass(frozen=True, slots=True)
class FactorRow:
    """A factor with its levels, in the order they were declared."""

    uid: str
    name: str
    kind: str
    levels: tuple[LevelRow, ...]


def factors(connection: sa.Connection) -> tuple[FactorRow, ...]:
    """Return all factors and levels in the order of their declaration."""
    rows = connection.execute(
        sa.select(
            factor.c.uid,
            factor.c.name,
            factor.c.kind,
            level.c.uid,
            level.c.label,
            level.c.value,
            level.c.attributes_json,
        )
        .join(level, level.c.factor == factor.c.id)
        .order_by(factor.c.id, level.c.id)
    ).all()
    found: dict[tuple[str, str, str], list[LevelRow]] = {}
    for factor_uid, name, kind, *of_level in rows:
        found.setdefault((factor_uid, name, kind), []).append(LevelRow(*of_level))
    return tuple(FactorRow(*key, tuple(levels)) for key, levels in found.items())


@dataclass(frozen=True, slots=True)
class StudyRow:
    """The study that a book is about."""

    uid: str
    name: str
    kind: str
    reference_voltage_v: float
    jumps_nominal: int
    time_zone: str


def the_study(connection: sa.Connection) -> StudyRow | None:
    """Return the book's study; a book has one."""
    row = connection.execute(
        sa.select(
            study.c.uid,
            study.c.name,
            study.c.kind,
            study.c.reference_voltage_v,
            study.c.jumps_nominal,
            study.c.time_zone,
        ).order_by(study.c.id)
    ).first()
    return None if row is None else StudyRow(*row)
