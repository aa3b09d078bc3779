"""Which part of the journal need not be played back to know what should stand in suspected rows."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from data_schema.journal import Entry
from data_schema.row_hashes import Altered
from data_schema.tables import FACTS
from data_schema.vocabulary import Action
from labbook.statements.apply_context import derived_uid

WITHOUT_LOGS = (FACTS.keys() | {"ingest"}) - {"file", "run_file", "report"}
"""The kinds of rows that neither samples of other files nor reports have a part in."""


def needless_entries(entries: Sequence[Entry], suspected: Iterable[Altered]) -> frozenset[int]:
    """Return the numbers of the entries without which a replay gives the same suspected rows.

    These are reports, and all that is said of files which gave samples and no charges, but for the suspected ones.
    Nothing is needless where jumps, results, reports or links of files are suspected.
    """
    suspected = list(suspected)
    if any(item.kind not in WITHOUT_LOGS for item in suspected):
        return frozenset()
    read = {item.uid for item in suspected if item.kind == "ingest"}
    logs = _logs(entries) - {(entry.new or {})["sha256"] for entry in entries if entry.entity_uid in read}
    uids = {derived_uid("file", sha256) for sha256 in logs}
    return frozenset(entry.seq for entry in entries if _is_needless(entry, logs, uids))


def _logs(entries: Iterable[Entry]) -> set[str]:
    """Return the SHA-256 of the files of which no reading gave a charge."""
    gave_charges: dict[str, bool] = {}
    for entry in entries:
        if entry.action in (Action.INGEST, Action.READ):
            new = entry.new or {}
            # an earlier labbook did not say whether there were any
            gave_charges[new["sha256"]] = gave_charges.get(new["sha256"], False) or new.get("charge_lines") != []
    return {sha256 for sha256, charges in gave_charges.items() if not charges}


def _is_needless(entry: Entry, logs: Collection[str], uids: Collection[str]) -> bool:
    if entry.action in (Action.INGEST, Action.READ):
        return (entry.new or {})["sha256"] in logs
    return entry.action is Action.REPORT or (entry.entity_kind == "file" and entry.entity_uid in uids)
