"""A file, or a row of a charger sheet, belongs to a run, or to none any more."""

from __future__ import annotations

from data_schema.journal import Entry
from data_schema.queries.charges import charges_of_run
from data_schema.queries.facts import insert_fact, read_fact, update_fact
from data_schema.queries.imported_files import (
    links_of_file,
    parts_of_file,
    signals_of_file,
    unassigned_charges_of_file,
    unlink_file,
)
from data_schema.queries.results import mark_stale
from data_schema.queries.signals import signals_of_runs
from data_schema.vocabulary import FileRole
from labbook.statements.scene import Scene, around_run, derived_uid


def apply_assign(scene: Scene, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Link the file or charge, or take it off its run; results that used it, or may use it now, become stale."""
    values = entry.new or {}
    kind, uid = entry.entity_kind, entry.entity_uid
    if values["run"] is None:
        changed = _take_charge_off(scene, uid) if kind == "charge" else _take_file_off(scene, uid)
        return mark_stale(scene.connection, changed)
    if kind == "charge":
        assign_charge(scene, uid, values["run"])
    else:
        assign_file(scene, uid, values["run"], FileRole(values["role"]))
    return mark_stale(scene.connection, [*around_run(scene, values["run"]), (kind, uid)])


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


def _take_file_off(scene: Scene, file_uid: str) -> list[tuple[str, str]]:
    """Unlink a file; a run that keeps other signals may be usable again, so that its condition counts as changed."""
    runs = {link.run_uid for link in links_of_file(scene.connection, file_uid)}
    unlink_file(scene.connection, file_uid)
    changed = [("file", file_uid), *(("signal", sha256) for sha256 in signals_of_file(scene.connection, file_uid))]
    for run_uid in sorted(runs):
        if signals_of_runs(scene.connection, run_uid=run_uid):
            changed += around_run(scene, run_uid)
    return changed


def _take_charge_off(scene: Scene, charge_uid: str) -> list[tuple[str, str]]:
    """Let a charge belong to no run; a run that keeps another charge may be usable again."""
    run_uid = read_fact(scene.connection, "charge", charge_uid, ["run"])["run"]
    update_fact(scene.connection, "charge", charge_uid, {"run": None})
    changed = [("charge", charge_uid)]
    if charges_of_run(scene.connection, run_uid):
        changed += around_run(scene, run_uid)
    return changed
