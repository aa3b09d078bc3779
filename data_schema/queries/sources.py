"""What an input of a result is, in words that lead to bytes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.results import InputRow
from data_schema.tables.design import condition, study
from data_schema.tables.equipment import robot
from data_schema.tables.files import LAST_READING, file, ingest
from data_schema.tables.journal import person
from data_schema.tables.runs import charge, decision, run
from data_schema.tables.signals import detection, signal
from data_schema.vocabulary import ChargeState, IngestStatus


@dataclass(frozen=True, slots=True)
class Source:
    """An input by kind and uid, and what it is."""

    kind: str
    uid: str
    text: str


def describe_input(connection: sa.Connection, item: InputRow) -> Source:
    """Say what an input is; what has been removed since is named by its uid."""
    query = _QUERIES[item.input_kind](item.input_uid)
    row = connection.execute(query).first()
    if row is None:
        return Source(item.input_kind, item.input_uid, f"{item.input_uid} (not in the book any more)")
    parts = [f"{name} {value}" for name, value in row._mapping.items() if value is not None]
    if item.input_kind == "scene" and item.input_uid.endswith(".toml"):
        parts.append(f"sha256 {item.input_sha256}")  # of the file's bytes; of others it is that of what they stand for
    return Source(item.input_kind, item.input_uid, ", ".join(parts))


def _run(uid: str) -> sa.Select[tuple[object, ...]]:
    return sa.select(run.c.name.label("run"), run.c.duration_s, run.c.jumps_made, run.c.state).where(run.c.uid == uid)


def _position(uid: str) -> sa.Select[tuple[object, ...]]:
    return sa.select(run.c.name.label("run"), run.c.position_in_day).where(run.c.uid == uid)


def _charge(uid: str) -> sa.Select[tuple[object, ...]]:
    return (
        sa.select(
            charge.c.charge_mah,
            charge.c.resolution_mah,
            charge.c.row_number.label("row"),
            sa.case((charge.c.state != str(ChargeState.COUNTED), charge.c.state)).label("now"),
            ingest.c.original_name.label("of file"),
            file.c.sha256,
        )
        .outerjoin(file, charge.c.file == file.c.id)
        .outerjoin(ingest, sa.and_(ingest.c.file == file.c.id, LAST_READING))
        .where(charge.c.uid == uid)
    )


def _signal(sha256: str) -> sa.Select[tuple[object, ...]]:
    return (
        sa.select(
            signal.c.n_samples.label("samples"),
            signal.c.reader,
            signal.c.reader_version.label("version"),
            sa.case((ingest.c.status != str(IngestStatus.IMPORTED), ingest.c.status)).label("a reading now"),
            ingest.c.original_name.label("of file"),
            file.c.sha256,
        )
        .join(file, signal.c.file == file.c.id)
        .join(ingest, ingest.c.id == signal.c.ingest)
        .where(signal.c.sha256 == sha256)
        .order_by(ingest.c.id.desc())
    )


def _detection(uid: str) -> sa.Select[tuple[object, ...]]:
    return sa.select(
        detection.c.algorithm.label("detector"), detection.c.version, detection.c.n_jumps.label("jumps")
    ).where(detection.c.uid == uid)


def _decision(uid: str) -> sa.Select[tuple[object, ...]]:
    return (
        sa.select(
            decision.c.verdict, decision.c.reason_code.label("because"), person.c.name.label("by"), decision.c.at_utc
        )
        .join(person, decision.c.person == person.c.id)
        .where(decision.c.uid == uid)
    )


def _robot(uid: str) -> sa.Select[tuple[object, ...]]:
    return sa.select(robot.c.name.label("robot"), robot.c.rest_length_m).where(robot.c.uid == uid)


def _robot_body(uid: str) -> sa.Select[tuple[object, ...]]:
    columns = (robot.c.body_mass_kg, robot.c.foot_mass_kg, robot.c.link_1_m, robot.c.link_2_m, robot.c.rest_length_m)
    return sa.select(robot.c.name.label("robot"), *columns).where(robot.c.uid == uid)


def _idle_runs(robot_uid: str) -> sa.Select[tuple[object, ...]]:
    return sa.select(robot.c.name.label("all idle runs of robot")).where(robot.c.uid == robot_uid)


def _condition(uid: str) -> sa.Select[tuple[object, ...]]:
    return sa.select(condition.c.key.label("condition")).where(condition.c.uid == uid)


def _study(uid: str) -> sa.Select[tuple[object, ...]]:
    return sa.select(study.c.name.label("study"), study.c.reference_voltage_v).where(study.c.uid == uid)


def _scene(name: str) -> sa.Select[tuple[object, ...]]:
    """A scene is one of the simulator's, or a file that the book's configuration names."""
    return sa.select(sa.literal(name).label("scene"))


def _result(uid: str) -> sa.Select[tuple[object, ...]]:
    return sa.select(sa.literal(uid).label("result"))


_QUERIES: dict[str, Callable[[str], sa.Select[tuple[object, ...]]]] = {
    "run": _run,
    "position": _position,
    "charge": _charge,
    "signal": _signal,
    "detection": _detection,
    "decision": _decision,
    "robot": _robot,
    "robot_body": _robot_body,
    "idle_runs": _idle_runs,
    "condition": _condition,
    "study": _study,
    "scene": _scene,
    "result": _result,
}
