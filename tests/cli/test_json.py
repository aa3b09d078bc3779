"""With `--json` every command prints one JSON document and nothing else."""

from __future__ import annotations

import shlex
from pathlib import Path

from labbook.cli.main import application
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, small_book

IN_ORDER = {
    "init": ("init ../other --as Ada", {"book"}),
    "config": ("config", {"path", "sha256"}),
    "plan": ("plan --seed 1 --n 2 --per-day 8", {"runs", "days", "controls", "idle", "sheet", "printed"}),
    "runs import": (
        "runs import ../instruments/runs.csv",
        {"stated", "filled_in", "unchanged", "not_made", "remarks"},
    ),
    "ingest": ("ingest ../instruments/logs", {"status", "format", "runs", "sha256", "findings", "channels"}),
    "channels": ("channels", {"name", "unit", "meaning"}),
    "formats": ("formats", {"formats", "faults"}),
    "charge": ("charge r001 112", {"run", "charge", "charge_mah", "rig"}),
    "runs list": ("runs list", {"name", "state", "levels", "day"}),
    "runs inbox": ("runs inbox", set()),
    "assign": ("assign nameless.csv r007", {"files", "run", "said", "rig", "reports"}),
    "check": ("check rail_angle", {"day", "kind", "passed"}),
    "analysis": ("analysis", {"settings", "stated", "departures", "stated_utc", "stated_by"}),
    "today": ("today", {"day", "planned_not_done", "log_without_charge", "checks_not_made", "inbox", "last_backup"}),
    "note": ("note r001 'left rail squeaked'", {"run", "text"}),
    "show": ("show r001", {"run", "files", "signals", "charges", "notes", "history"}),
    "plot": ("plot r001", {"run", "figure"}),
    "jumps list": ("jumps list r001", {"run", "signals", "detections", "jumps", "waiting"}),
    "jumps reject": ("jumps reject r001 1 --reason misfire", {"run", "jumps", "verdict", "reports"}),
    "jumps accept": ("jumps accept r001 1", {"run", "jumps", "verdict", "reports"}),
    "jumps clear": ("jumps clear r001 1", {"run", "jumps", "verdict", "reports"}),
    "correct": ("correct r002 duration_s=700 --why typed", {"target", "changed", "reports"}),
    "void": ("void r002 --reason 'foot came loose'", {"run", "reports"}),
    "backup": ("backup ../backup", {"last", "raw", "remarks"}),
    "restore": ("restore ../backup ../restored", {"folder", "entries", "raw", "differences", "moved"}),
    "db status": ("db status", {"database", "schema", "rows", "last_backup"}),
    "db prune": ("db prune", {"removed", "leftovers"}),
    "db check": ("db check", {"whole", "problems", "orphans"}),
    "rebuild": ("rebuild", {"entries", "old", "differences"}),
}
ELSEWHERE = {
    "report": "tests/cli/test_report.py",
    "why": "tests/cli/test_report.py",
    "reports list": "tests/labbook/actions/upkeep/test_report_differences.py",
    "reports show": "tests/labbook/actions/upkeep/test_report_differences.py",
    "reports diff": "tests/labbook/actions/upkeep/test_report_differences.py",
    "files list": "tests/cli/test_files.py",
    "files show": "tests/cli/test_files.py",
    "files reread": "tests/cli/test_files.py",
    "files withdraw": "tests/cli/test_files.py",
    "files restore": "tests/cli/test_files.py",
    "runs dismiss": "tests/cli/test_files.py",
    "runs restore": "tests/cli/test_files.py",
    "merge": "tests/cli/test_merge.py",
    "calibrate-sensor": "tests/cli/test_calibrated_logs.py",
    "calibrate": "tests/labbook/analysis/prediction/test_calibrating.py",
    "compare": "tests/labbook/analysis/prediction/test_predicting.py",
    "demo": "makes a whole campaign: `make demo` runs it",
    "sim run": "tests/cli/test_sim_run.py",
    "sim sweep": "tests/cli/test_sim_sweep.py",
    "sim effects": "tests/cli/test_sim.py",
    "sim accuracy": "tests/cli/test_sim.py",
    "sim figures": "tests/cli/test_sim.py",
    "sim parts": "tests/cli/test_sim.py",
    "sim published": "tests/cli/test_sim.py",
    "sim warm": "tests/cli/test_sim_run.py",
    "study bed": "tests/cli/test_study_bed.py",
    "study emulator": "tests/cli/test_study_emulator.py",
    "study force-plate": "tests/cli/test_study_force_plate.py",
    "study field": "tests/cli/test_study_field.py",
    "study characterisation": "tests/cli/test_study_characterisation.py",
    "study compaction": "tests/cli/test_study_compaction.py",
    "study all": "tests/cli/test_study_sheets.py",
    "stats compare": "tests/cli/test_stats.py",
    "stats anova": "tests/cli/test_stats.py",
    "stats savings": "tests/cli/test_stats.py",
    "stats equivalence": "tests/cli/test_stats.py",
    "power": "tests/cli/test_power.py",
}


def commands() -> set[str]:
    root = application()
    return {
        f"{name} {below}".strip()
        for name, command in getattr(root, "commands", {}).items()
        for below in getattr(command, "commands", {"": None})
    }


def test_every_command_is_looked_at() -> None:
    assert commands() == set(IN_ORDER) | set(ELSEWHERE)


def test_every_command_prints_one_json_document(tmp_path: Path) -> None:
    book: SmallBook = small_book(tmp_path, runs=False, ingested=False)
    (book.folder / "nameless.csv").write_bytes(book.log("r003").read_bytes())
    book.log("r003").unlink()
    for name, (words, keys) in IN_ORDER.items():
        if name == "assign":
            good(labbook("ingest", "nameless.csv", at=book.folder))
        found = good(labbook(*shlex.split(words), "--json", at=book.folder)).json
        if isinstance(found, list):
            assert all(keys <= set(item) for item in found), name
            assert found or not keys, name
        else:
            assert keys <= set(found), name
