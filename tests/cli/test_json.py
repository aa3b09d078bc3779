"""With `--json` every command prints one JSON document and nothing else; `watch` one a line, as things happen."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, small_book

IN_ORDER = {
    "init": ("init ../other --as Ada", {"book"}),
    "config": ("config", {"path", "sha256"}),
    "plan": ("plan --seed 1 --n 2 --per-day 8", {"runs", "days", "controls", "idle", "sheet", "printed"}),
    "runs import": ("runs import ../instruments/runs.csv", {"stated", "filled_in", "unchanged", "not_made", "remarks"}),
    "ingest": ("ingest ../instruments/logs", {"status", "format", "runs", "sha256", "findings", "channels"}),
    "watch": ("watch ../instruments/logs --once", {"event"}),
    "channels": ("channels", {"name", "unit", "meaning"}),
    "formats": ("formats", {"formats", "faults"}),
    "charge": ("charge r001 112", {"run", "charge", "charge_mah", "rig"}),
    "runs list": ("runs list", {"name", "state", "levels", "day"}),
    "runs diff": (
        "runs diff r001 r002 --out both.svg",
        {"first", "second", "facts", "files", "channels", "charges", "numbers", "verdicts", "figure"},
    ),
    "runs inbox": ("runs inbox", set()),
    "assign": ("assign nameless.csv r007", {"files", "run", "said", "rig", "reports"}),
    "check": ("check rail_angle", {"day", "kind", "passed"}),
    "analysis": ("analysis", {"settings", "stated", "departures", "stated_utc", "stated_by"}),
    "attention": ("attention", {"day", "where", "runs", "void", "findings", "by_day"}),
    "today": ("today", {"day", "runs", "void", "findings", "by_day", "last_backup"}),
    "note": ("note r001 'left rail squeaked'", {"run", "text"}),
    "show": ("show r001", {"run", "files", "signals", "charges", "notes", "history"}),
    "plot": ("plot r001", {"run", "figure"}),
    "jumps list": ("jumps list r001", {"run", "signals", "detections", "jumps", "waiting"}),
    "jumps queue": ("jumps queue --order shuffled --seed 7", {"order", "seed", "jumps", "left_out"}),
    "jumps reject": ("jumps reject r001 1 --reason misfire", {"run", "jumps", "verdict", "reports"}),
    "jumps accept": ("jumps accept r001 1", {"run", "jumps", "verdict", "reports"}),
    "jumps move": ("jumps move r001 1 --at 2.3", {"run", "jumps", "verdict", "jump", "reports"}),
    "jumps add": ("jumps add r001 --at 1.8", {"run", "jumps", "verdict", "jump", "reports"}),
    "jumps clear": ("jumps clear r001 1", {"run", "jumps", "verdict", "reports"}),
    "jumps agreement": ("jumps agreement", set()),
    "correct": ("correct r002 duration_s=700 --why typed", {"target", "changed", "reports"}),
    "void": ("void r002 --reason 'foot came loose'", {"run", "reports"}),
    "backup": ("backup ../backup", {"last", "raw", "remarks"}),
    "restore": ("restore ../backup ../restored", {"folder", "entries", "raw", "differences", "moved"}),
    "db status": ("db status", {"database", "schema", "rows", "last_backup"}),
    "db prune": ("db prune", {"removed", "leftovers"}),
    "db check": ("db check", {"whole", "problems", "orphans"}),
    "rebuild": ("rebuild", {"entries", "old", "differences"}),
}


def test_every_command_prints_one_json_document(tmp_path: Path) -> None:
    book: SmallBook = small_book(tmp_path, runs=False, ingested=False)
    (book.folder / "nameless.csv").write_bytes(book.log("r003").read_bytes())
    book.log("r003").unlink()
    for name, (words, keys) in IN_ORDER.items():
        if name == "assign":
            good(labbook("ingest", "nameless.csv", at=book.folder))
        answer = good(labbook(*shlex.split(words), "--json", at=book.folder))
        found = [json.loads(line) for line in answer.out.splitlines()] if name == "watch" else answer.json
        if isinstance(found, list):
            assert all(keys <= set(item) for item in found), name
            assert found or not keys, name
        else:
            assert keys <= set(found), name
