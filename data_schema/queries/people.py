"""People, and the configuration in force."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables.people import config, person


def person_uid(connection: sa.Connection, name: str) -> str | None:
    """Return the uid of a person by name."""
    uid: str | None = connection.execute(sa.select(person.c.uid).where(person.c.name == name)).scalar()
    return uid


def people(connection: sa.Connection) -> dict[str, str]:
    """Return everyone's initials by name."""
    rows = connection.execute(sa.select(person.c.name, person.c.initials).order_by(person.c.id))
    return {row.name: row.initials for row in rows}


def config_in_force(connection: sa.Connection) -> tuple[str, str] | None:
    """Return (sha256, text) of the newest configuration; None before the first."""
    row = connection.execute(sa.select(config.c.sha256, config.c.text).order_by(config.c.id.desc()).limit(1)).first()
    return (row.sha256, row.text) if row else None
