"""The inputs of a result, and what each is in words that lead to bytes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.tables.design import condition, study
from data_schema.tables.equipment import robot
from data_schema.tables.files import LAST_READING, file, ingest
from data_schema.tables.journal import person
from data_schema.tables.runs import charge, decision, run
from data_schema.tables.signals import signal
from data_schema.vocabulary import ChargeState, IngestStatus


@dataclass(frozen=True, slots=True)
class InputRow:
    """One input of a result; `input_sha256` changes with whatever the result depends on of it."""

    role: str
    input_kind: str
    input_uid: str
    input_sha256: str


@dataclass(frozen=True, slots=True)
class Source:
    """An input by kind and uid, and what it is."""

    kind: str
    uid: str
    text: str


def describe_input(connection: sa.Connection, item: InputRow) -> Source:
    """Say what an input is; what has been removed since is named by its uid."""
    row = connection.execute(_QUERIES[item.input_kind], {"uid": item.input_uid}).first()
    if row is None:
        return Source(item.input_kind, item.input_uid, f"{item.input_uid} (not in the book any more)")
    parts = [f"{name} {value}" for name, value in row._mapping.items() if value is not None]
    if item.input_kind == "scene" and item.input_uid.endswith(".toml"):
        parts.append(f"sha256 {item.input_sha256}")  # of the file's bytes; of others it is that of what they stand for
    return Source(item.input_kind, item.input_uid, ", ".join(parts))


_UID: sa.BindParameter[str] = sa.bindparam("uid")
_ROBOT = robot.c.name.label("robot")
_QUERIES: dict[str, sa.Select[Any]] = {
    "run": sa.select(run.c.name.label("run"), run.c.duration_s, run.c.jumps_made, run.c.state).where(run.c.uid == _UID),
    "position": sa.select(run.c.name.label("run"), run.c.position_in_day).where(run.c.uid == _UID),
    "charge": sa.select(
        charge.c.charge_mah,
        charge.c.resolution_mah,
        charge.c.row_number.label("row"),
        sa.case((charge.c.state != ChargeState.COUNTED, charge.c.state)).label("now"),
        ingest.c.original_name.label("of file"),
        file.c.sha256,
    )
    .outerjoin(file, charge.c.file == file.c.id)
    .outerjoin(ingest, sa.and_(ingest.c.file == file.c.id, LAST_READING))
    .where(charge.c.uid == _UID),
    "signal": sa.select(
        signal.c.n_samples.label("samples"),
        signal.c.reader,
        signal.c.reader_version.label("version"),
        sa.case((ingest.c.status != IngestStatus.IMPORTED, ingest.c.status)).label("a reading now"),
        ingest.c.original_name.label("of file"),
        file.c.sha256,
    )
    .join(file, signal.c.file == file.c.id)
    .join(ingest, ingest.c.id == signal.c.ingest)
    .where(signal.c.sha256 == _UID)
    .order_by(ingest.c.id.desc()),
    "detection": sa.select(sa.type_coerce(_UID, sa.Text).label("jumps found by")),
    "decision": sa.select(
        decision.c.verdict,
        decision.c.at_s.label("apex at"),
        decision.c.reason_code.label("because"),
        person.c.name.label("by"),
        decision.c.at_utc,
    )
    .join(person, decision.c.person == person.c.id)
    .where(decision.c.uid == _UID),
    "robot": sa.select(_ROBOT, robot.c.rest_length_m).where(robot.c.uid == _UID),
    "robot_body": sa.select(
        _ROBOT, robot.c.body_mass_kg, robot.c.foot_mass_kg, robot.c.link_1_m, robot.c.link_2_m, robot.c.rest_length_m
    ).where(robot.c.uid == _UID),
    "idle_runs": sa.select(robot.c.name.label("all idle runs of robot")).where(robot.c.uid == _UID),
    "condition": sa.select(condition.c.key.label("condition")).where(condition.c.uid == _UID),
    "study": sa.select(study.c.name.label("study"), study.c.reference_voltage_v).where(study.c.uid == _UID),
    "scene": sa.select(sa.type_coerce(_UID, sa.Text).label("scene")),
    "result": sa.select(sa.type_coerce(_UID, sa.Text).label("result")),
}
"""What there is to say of an input, by its kind; a scene is the simulator's, or a file that labbook.toml names."""
