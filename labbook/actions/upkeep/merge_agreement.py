"""Whether two books agree after all entries of the other are in: on verdicts, and on the logs and charge of a run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import sqlalchemy as sa

from data_schema.journal import Entry
from data_schema.queries.charges import ChargeOfRun, waiting_charges
from data_schema.queries.imported_files import Link, find_files
from data_schema.vocabulary import Action, ChargeMode
from labbook.actions.upkeep.merge_rules import display_name

Charges = Mapping[str, Sequence[ChargeOfRun]]
"""The charges that count, by the uid of their run."""


def second_charges(connection: sa.Connection, before: Charges, there: Charges, now: Charges) -> list[str]:
    """Say which runs would have a charge of each book, where neither has two; uids `there` are those of this book.

    The charge of this book waits then, for the other was given to the run later.
    """
    found, waiting = [], {*waiting_charges(connection)}
    for uid, charges in now.items():
        own_waiting = [row for row in before.get(uid, ()) if row.uid in waiting]
        some = [row for row in [*own_waiting, *charges] if row.mode == ChargeMode.CHARGE]
        if len(some) > max(1, len(before.get(uid, ())), len(there.get(uid, ()))):
            own = {row.uid for row in before.get(uid, ())}
            words = " and ".join(
                f"{row.charge_mah:g} mAh {'here' if row.uid in own else 'there'}, charge:{row.uid}" for row in some
            )
            name = display_name(connection, "run", uid)
            found.append(
                f"{name} has a charge in each book ({words}): take the wrong one off in its book, `labbook correct "
                "charge:UID run=none --why ...`."
            )
    return found


Logs = Mapping[str, Sequence[Link]]
"""The logs in use, by the uid of their run."""


def second_logs(connection: sa.Connection, before: Logs, there: Logs, now: Logs) -> list[str]:
    """Say which runs would have a log that only this book has and one that only the other has.

    Where one book took a log off and put another in its place, the run has one. Uids `there` are those of this book.
    """
    found = []
    for uid, logs in now.items():
        here, other, both = ({log.file_uid for log in some.get(uid, ())} for some in (before, there, now))
        if both <= other or both <= here:
            continue
        names = {log.file_uid: find_files(connection, log.file_uid)[0].name for log in logs}
        words = " and ".join(f"{name} {'here' if file in here else 'there'}" for file, name in names.items())
        run = logs[0].run_name
        found.append(
            f"run {run} has a log in each book ({words}): take the wrong one off in its book, `labbook assign FILE "
            f"none --why ...`; where both are of this run, have this book read the other too, `labbook ingest FILE "
            f"--run {run}`."
        )
    return found


SAME_JUMP_S = 0.05
"""Verdicts whose anchors lie closer than this are on the same jump, whichever detector found it."""


def verdicts_that_differ(connection: sa.Connection, here: Iterable[Entry], there: Iterable[Entry]) -> list[str]:
    """Say on what the last verdicts differ that people gave in two books without knowing of each other."""
    standing, found = _last_verdicts(here), []
    for place, other in _last_verdicts(there).items():
        for where, own in standing.items():
            one, two = ((entry.new or {})["verdict"] for entry in (own, other))
            if where[:3] == place[:3] and abs(where[3] - place[3]) < SAME_JUMP_S and one != two:
                kind, uid = place[:2]
                what = display_name(connection, "run" if kind == "jump" else kind, uid)
                what = f"the jump of {what} at {place[3]:.3f} s" if kind == "jump" else what
                found.append(
                    f"{what} has two verdicts: {one} here ({own.person}, {own.at_utc[:10]}), {two} there "
                    f"({other.person}, {other.at_utc[:10]}): agree, and give the same verdict in both books."
                )
    return found


def _last_verdicts(entries: Iterable[Entry]) -> dict[tuple[str, str, str, float], Entry]:
    found = {}
    for entry in entries:
        if entry.action is Action.DECIDE:
            new = entry.new or {}
            place = (new["target_kind"], new["target_uid"], new.get("signal_sha256") or "", new.get("anchor_s") or 0.0)
            found[place] = entry
    return found
