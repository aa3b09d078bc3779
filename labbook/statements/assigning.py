"""A file, or a row of a charger sheet, belongs to a run."""

from __future__ import annotations

from data_schema.journal import Entry
from data_schema.queries.facts import insert_fact, update_fact
from data_schema.queries.imports import parts_of_file, unassigned_charges_of_file
from data_schema.queries.results import mark_stale
from data_schema.vocabulary import FileRole
from labbook.statements.scene import Scene, around_run, derived_uid


def apply_assign(scene: Scene, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Link the file or charge; results on the run become stale."""
    values = entry.new or {}
    if entry.entity_kind == "charge":
        assign_charge(scene, entry.entity_uid, values["run"])
    else:
        assign_file(scene, entry.entity_uid, values["run"], FileRole(values["role"]))
    return mark_stale(scene.connection, [*around_run(scene, values["run"]), (entry.entity_kind, entry.entity_uid)])


def assign_file(scene: Scene, file_uid: str, run_uid: str, role: FileRole) -> None:
    """Link every part of a file to a run; a file with one unassigned charge gives it to the run too."""
    for part in parts_of_file(scene.connection, file_uid):
        insert_fact(
            scene.connection,
            "run_file",
            derived_uid("run_file", run_uid, file_uid, part),
            {"run": run_uid, "file": file_uid, "part": part, "role": str(role)},
        )
    charges = unassigned_charges_of_file(scene.connection, file_uid)
    if role is FileRole.CHARGE and len(charges) == 1:
        assign_charge(scene, charges[0], run_uid)


def assign_charge(scene: Scene, charge_uid: str, run_uid: str) -> None:
    """Say after which run a pack took this charge."""
    update_fact(scene.connection, "charge", charge_uid, {"run": run_uid})
