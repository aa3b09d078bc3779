"""A file, or a row of a charger sheet, belongs to a run, or to none any more."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.journal import Entry
from data_schema.queries.facts import fact_exists, insert_fact, update_fact
from data_schema.queries.files import (
    links_of_file,
    links_of_run,
    parts_of_file,
    recorded_parts,
    unassigned_charges_of_file,
    unlink_file,
)
from data_schema.queries.history import statements_about
from data_schema.queries.runs import list_runs
from data_schema.vocabulary import Action, FileRole
from labbook.statements.apply_context import ApplyContext, derived_uid, missing_row, run_named
from labbook.statements.counted_charges import state_of_charge


def apply_assign(context: ApplyContext, entry: Entry, _prepared: object) -> None:
    """Link the file, or take it off its run; the only charge of a file goes with it."""
    values, uid = entry.new or {}, entry.entity_uid
    if values["run"] is None:
        unlink_file(context.connection, uid, values.get("part"))
    else:
        role, part = FileRole(values["role"]), values.get("part")
        if part is not None and part not in parts_of_file(context.connection, uid):
            missing_row(context, entry)
            return
        assign_file(context, uid, values["run"], role, part)
        charges = unassigned_charges_of_file(context.connection, uid)
        if part is None and role is FileRole.CHARGE and len(charges) == 1:
            state_of_charge(context.connection, charges[0], {"run": values["run"]})


def apply_link(context: ApplyContext, entry: Entry, _prepared: object) -> None:
    """Let a part of a file belong to another run."""
    uid, uids = entry.entity_uid, [entry.entity_uid]
    if not fact_exists(context.connection, "run_file", uid):
        uids = resolve_links(context, uid, (entry.old or {}).get("run"))
    if not uids:
        missing_row(context, entry)
    for each in uids:
        update_fact(context.connection, "run_file", each, entry.new or {})


def assign_file(
    context: ApplyContext,
    file_uid: str,
    run_uid: str,
    role: FileRole,
    part: str | None = None,
    *,
    parts: Sequence[str] = (),
) -> None:
    """Link every part of a file to a run, or one; `parts` are those of the reading that is being made."""
    for name in (parts or parts_of_file(context.connection, file_uid)) if part is None else [part]:
        unlink_file(context.connection, file_uid, name)
        link_part(context, file_uid, run_uid, role, name)


def link_part(context: ApplyContext, file_uid: str, run_uid: str, role: FileRole, part: str) -> None:
    """Link a part of a file that belongs to no run."""
    insert_fact(
        context.connection,
        "run_file",
        derived_uid("run_file", run_uid, file_uid, part),
        {"run": run_uid, "file": file_uid, "part": part, "role": str(role)},
    )


def link_parts_again(
    context: ApplyContext,
    file_uid: str,
    role: FileRole,
    stated_run: str | None,
    before: Sequence[str],
    parts: Sequence[str],
) -> None:
    """Let the parts of a new reading belong to runs as those of the reading `before` did.

    A part keeps its run, or that it has none. Where all parts belonged to one run, so do new ones; a file that belongs
    to none goes to the run that its name states, unless a person has decided where it belongs.
    """
    links = links_of_file(context.connection, file_uid)
    if not links:
        run_uid = run_named(context, stated_run)
        if run_uid is not None and not statements_about(context.connection, file_uid, Action.SET):
            assign_file(context, file_uid, run_uid, role, parts=parts)
    for link in links:
        if link.part not in parts:
            unlink_file(context.connection, file_uid, link.part)
        elif link.role != role:
            update_fact(context.connection, "run_file", link.uid, {"role": str(role)})
    runs = {link.run_uid for link in links}
    if len(runs) == 1 and {link.part for link in links}.issuperset(before):
        for part in parts:
            if part not in before:
                link_part(context, file_uid, links[0].run_uid, role, part)


def resolve_links(context: ApplyContext, link_uid: str, run_uid: str | None) -> list[str]:
    """Return the links to a run that a statement means by one which is not there under that uid.

    A link is named after its file, part and first run. Where the reading in force calls the parts otherwise, the links
    of those that no earlier reading knew are meant.
    """
    runs = [run.uid for run in list_runs(context.connection)]
    links = [] if run_uid is None else links_of_run(context.connection, run_uid)
    for file_uid in dict.fromkeys(link.file_uid for link in links):
        recorded = recorded_parts(context.connection, file_uid)
        named = [part for part in recorded for run in runs if derived_uid("run_file", run, file_uid, part) == link_uid]
        if named:
            of_file = [link for link in links if link.file_uid == file_uid]
            same = [link.uid for link in of_file if link.part == named[0]]
            return same or [link.uid for link in of_file if link.part not in recorded]
    return []
