"""A file, or a row of a charger sheet, belongs to a run, or to none any more."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.journal import Entry
from data_schema.queries.charges import charges_of_run
from data_schema.queries.facts import fact_exists, insert_fact, read_fact, update_fact
from data_schema.queries.imported_files import (
    links_of_file,
    parts_of_file,
    signals_of_file,
    unassigned_charges_of_file,
    unlink_file,
)
from data_schema.queries.readings import said_about, waiting_files
from data_schema.queries.results import mark_stale
from data_schema.queries.runs import list_runs
from data_schema.queries.signals import signals_of_runs
from data_schema.vocabulary import Action, FileRole
from labbook.statements.scene import Scene, around_run, derived_uid, refuse_unless_deferred, run_named


def apply_assign(scene: Scene, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Link the file or charge, or take it off its run; results that used it, or may use it now, become stale."""
    values = entry.new or {}
    kind, uid = entry.entity_kind, entry.entity_uid
    if kind == "charge" and not fact_exists(scene.connection, "charge", uid):
        refuse_unless_deferred(scene, kind, uid)
        return []
    if values["run"] is None:
        changed = _take_charge_off(scene, uid) if kind == "charge" else _take_file_off(scene, uid, values.get("part"))
        return mark_stale(scene.connection, changed)
    if kind == "charge":
        assign_charge(scene, uid, values["run"])
    else:
        assign_file(scene, uid, values["run"], FileRole(values["role"]), values.get("part"))
    return mark_stale(scene.connection, [*around_run(scene, values["run"]), (kind, uid)])


def assign_file(scene: Scene, file_uid: str, run_uid: str, role: FileRole, part: str | None = None) -> None:
    """Link every part of a file to a run, or one; a file with one unassigned charge gives it to the run too."""
    for name in parts_of_file(scene.connection, file_uid) if part is None else [part]:
        _link(scene, file_uid, run_uid, role, name)
    charges = unassigned_charges_of_file(scene.connection, file_uid)
    if part is None and role is FileRole.CHARGE and len(charges) == 1:
        assign_charge(scene, charges[0], run_uid)


def _link(scene: Scene, file_uid: str, run_uid: str, role: FileRole, part: str) -> None:
    insert_fact(
        scene.connection,
        "run_file",
        derived_uid("run_file", run_uid, file_uid, part),
        {"run": run_uid, "file": file_uid, "part": part, "role": str(role)},
    )


def link_parts_again(
    scene: Scene, file_uid: str, role: FileRole, stated_run: str | None, before: Sequence[str]
) -> list[str]:
    """Let the parts of a new reading belong to runs as those of the reading `before` did; returns the runs concerned.

    A part keeps its run, or that it has none. Where all parts belonged to one run, so do new ones; a file that belongs
    to none goes to the run that its name states, unless a person has decided where it belongs.
    """
    links = links_of_file(scene.connection, file_uid)
    if not links:
        run_uid = run_named(scene, stated_run)
        if run_uid is None or said_about(scene.connection, file_uid, [Action.ASSIGN]):
            return []
        assign_file(scene, file_uid, run_uid, role)
        return [run_uid]
    parts = parts_of_file(scene.connection, file_uid)
    for link in links:
        if link.part not in parts:
            unlink_file(scene.connection, file_uid, link.part)
        elif link.role != role:
            update_fact(scene.connection, "run_file", link.uid, {"role": str(role)})
    runs = list(dict.fromkeys(link.run_uid for link in links))
    if len(runs) == 1 and {link.part for link in links}.issuperset(before):
        for part in parts:
            if part not in before:
                _link(scene, file_uid, runs[0], role, part)
    return runs


def assign_charge(scene: Scene, charge_uid: str, run_uid: str) -> None:
    """Say after which run a pack took this charge."""
    update_fact(scene.connection, "charge", charge_uid, {"run": run_uid})


def _take_file_off(scene: Scene, file_uid: str, part: str | None) -> list[tuple[str, str]]:
    """Unlink a file or a part; a run that keeps other signals may be usable again: its condition counts as changed."""
    links = links_of_file(scene.connection, file_uid)
    runs = {link.run_uid for link in links if part is None or link.part == part}
    unlink_file(scene.connection, file_uid, part)
    changed = [("file", file_uid), *(("signal", sha256) for sha256 in signals_of_file(scene.connection, file_uid))]
    for run_uid in sorted(runs):
        if signals_of_runs(scene.connection, run_uid=run_uid):
            changed += around_run(scene, run_uid)
    return changed


def move_waiting(scene: Scene, link_uid: str, run_uid: str) -> None:
    """Move a waiting file to another run, where a statement is about a link of its parts.

    While a file waits it has no parts, so that the links which were stated for them are not there: one stands for all.
    """
    runs = [run.uid for run in list_runs(scene.connection)]
    for file in waiting_files(scene.connection):
        for link in links_of_file(scene.connection, file.file_uid):
            first = [run for run in runs if derived_uid("run_file", run, file.file_uid, link.part) == link.uid]
            if link_uid in [derived_uid("run_file", run, file.file_uid, part) for run in first for part in _PARTS]:
                update_fact(scene.connection, "run_file", link.uid, {"run": run_uid})
                return


_PARTS = ("", "log", "force", "charge", "channel_1", *(f"log_segment_{number}" for number in range(2, 10)))
"""Names of parts by readers; a waiting file's are not known."""


def _take_charge_off(scene: Scene, charge_uid: str) -> list[tuple[str, str]]:
    """Let a charge belong to no run; a run that keeps another charge may be usable again."""
    run_uid = read_fact(scene.connection, "charge", charge_uid, ["run"])["run"]
    update_fact(scene.connection, "charge", charge_uid, {"run": None})
    changed = [("charge", charge_uid)]
    if charges_of_run(scene.connection, run_uid):
        changed += around_run(scene, run_uid)
    return changed
