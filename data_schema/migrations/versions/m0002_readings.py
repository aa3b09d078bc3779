"""A file may be read again, charges have a state, and samples know the reading that made them.

Rows that the first revision has are kept as they are: the reading that was imported is the one in force, and every
charge counts. What the journal and the raw copies say beyond that comes with the rebuild that follows an upgrade.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import sqlalchemy as sa
from alembic import op
from alembic.operations import BatchOperations
from sqlalchemy.util import OrderedSet

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None

WHOLE = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
TEXT = sa.Text()

STATUS = "status IN ('imported', 'duplicate', 'refused', 'superseded', 'withdrawn', 'waiting')"
ACTION = (
    "action IN ('declare', 'correct', 'void', 'assign', 'decide', 'note', 'ingest', 'refuse', 'report', 'read', "
    "'withdraw', 'restore', 'dismiss')"
)
STATE = "state IN ('counted', 'known', 'gone', 'dismissed')"


def upgrade() -> None:
    with _altering("journal") as batch:
        batch.drop_constraint(op.f("ck_journal_action_known"), type_="check")
        batch.create_check_constraint(op.f("ck_journal_action_known"), ACTION)
    with _altering("ingest") as batch:
        batch.add_column(sa.Column("declared_json", TEXT, nullable=True))
        batch.drop_constraint(op.f("ck_ingest_status_known"), type_="check")
        batch.create_check_constraint(op.f("ck_ingest_status_known"), STATUS)
    _charges()
    _signals()


@contextlib.contextmanager
def _altering(name: str) -> Iterator[BatchOperations]:
    """Alter a table; where SQLite has it made anew, its rules stand in one order, and its triggers are made again."""
    triggers = "SELECT sql FROM sqlite_master WHERE type = 'trigger' AND tbl_name = :name"
    sqlite = op.get_bind().dialect.name == "sqlite"
    recreated = op.get_bind().execute(sa.text(triggers), {"name": name}).scalars().all() if sqlite else ()
    table = sa.Table(name, sa.MetaData(), autoload_with=op.get_bind())
    table.constraints = OrderedSet(sorted(table.constraints, key=lambda rule: str(rule.name)))
    table.indexes = OrderedSet(sorted(table.indexes, key=lambda index: str(index.name)))
    with op.batch_alter_table(name, copy_from=table) as batch:
        yield batch
    for trigger in recreated:
        op.execute(trigger)


def _charges() -> None:
    with _altering("charge") as batch:
        batch.add_column(sa.Column("line", WHOLE, nullable=True))
        batch.add_column(sa.Column("state", TEXT, nullable=True))
        batch.add_column(sa.Column("repeats", TEXT, nullable=True))
    op.execute("UPDATE charge SET state = 'counted'")
    with _altering("charge") as batch:
        batch.alter_column("state", existing_type=TEXT, nullable=False)
        batch.create_check_constraint(op.f("ck_charge_state_known"), STATE)


def _signals() -> None:
    with _altering("signal") as batch:
        batch.add_column(sa.Column("ingest", WHOLE, nullable=True))
        batch.add_column(sa.Column("time_sha256", TEXT, nullable=True))
        batch.add_column(sa.Column("recorded_sha256", TEXT, nullable=True))
    op.execute(
        "UPDATE signal SET ingest = (SELECT ingest.id FROM ingest "
        "WHERE ingest.file = signal.file AND ingest.status = 'imported')"
    )
    with _altering("signal") as batch:
        batch.alter_column("ingest", existing_type=WHOLE, nullable=False)
        batch.drop_constraint(op.f("uq_signal_file_part_reader_version"), type_="unique")
        batch.create_unique_constraint(op.f("uq_signal_ingest_part"), ["ingest", "part"])
        batch.create_foreign_key(
            op.f("fk_signal_ingest"), "ingest", ["ingest"], ["id"], onupdate="RESTRICT", ondelete="RESTRICT"
        )
        batch.create_index(op.f("ix_signal_ingest"), ["ingest"], unique=False)
