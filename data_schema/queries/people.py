"""People, and the configuration in force."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True, slots=True)
class ConfigRow:
    """A configuration as labbook.toml stood when it was taken over; an earlier text may be taken over again."""

    uid: str
    sha256: str
    text: str


def config_in_force(connection: sa.Connection) -> ConfigRow | None:
    """Return the newest configuration; None before the first."""
    newest = sa.select(config.c.uid, config.c.sha256, config.c.text).order_by(config.c.id.desc()).limit(1)
    row = connection.execute(newest).first()
    return ConfigRow(*row) if row else None
