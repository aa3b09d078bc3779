"""What the journal says of the first measurement, and of every configuration taken over before and after it.

A measurement is an imported file, whatever it holds and whichever run it turns out to belong to, or a charge read off a
display: from then on somebody may have seen a number. A refused file leaves none.
"""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.tables.people import config, journal, person
from data_schema.vocabulary import Action


@dataclass(frozen=True, slots=True)
class FirstMeasurement:
    """The entry of the journal with which the first measurement came into the book."""

    seq: int
    at_utc: str
    person: str


@dataclass(frozen=True, slots=True)
class StatedConfiguration:
    """A text of labbook.toml, and the entry of the journal that took it over."""

    seq: int
    at_utc: str
    person: str
    text: str


def first_measurement(connection: sa.Connection) -> FirstMeasurement | None:
    """Return the first measurement; None before it."""
    typed_charge = sa.and_(journal.c.action == str(Action.DECLARE), journal.c.entity_kind == "charge")
    row = connection.execute(
        sa.select(journal.c.seq, journal.c.at_utc, person.c.name)
        .join(person, journal.c.person == person.c.id)
        .where(sa.or_(journal.c.action == str(Action.INGEST), typed_charge))
        .order_by(journal.c.seq)
        .limit(1)
    ).first()
    return None if row is None else FirstMeasurement(*row)


def stated_configurations(connection: sa.Connection) -> list[StatedConfiguration]:
    """List every configuration that was taken over, in the order of the journal."""
    query = (
        sa.select(journal.c.seq, journal.c.at_utc, person.c.name, config.c.text)
        .join(person, journal.c.person == person.c.id)
        .join(config, config.c.uid == journal.c.entity_uid)
        .where(journal.c.entity_kind == "config", journal.c.action == str(Action.DECLARE))
        .order_by(journal.c.seq)
    )
    return [StatedConfiguration(*row) for row in connection.execute(query)]
