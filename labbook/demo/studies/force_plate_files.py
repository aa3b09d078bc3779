"""The force-plate campaign as files in the instruments' formats, and as a book that has ingested them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from labbook.demo.files import MARK
from labbook.demo.studies.book import StudyFiles, StudyRun, configuration, make_study_book
from labbook.demo.studies.force_plate import GAINS, HOPS, IDLE_S, VOLTAGE_V, PlateStudyRun
from labbook.demo.writers import bertec_text, string_pot_log

_FURTHER = """\
[simulation]
scene = "force_plate"
factors = { k_gain = "k_extension" }
"""
_PROTOCOL = """\
[protocol]
run_duration_s = 65
exclude_first_jumps = 0"""


def make_plate_book(
    folder: Path, campaign: Sequence[PlateStudyRun], step: Callable[[str], None], say: Callable[[str], None]
) -> Path:
    """Write the campaign's files and ingest them into a new book; returns the book's folder."""
    text = configuration(
        _FURTHER,
        study="force-plate",
        section="3.2.2",
        name="force plate",
        kind="force_plate",
        voltage_v=VOLTAGE_V,
        jumps=HOPS,
        gains=sorted(GAINS),
        protocol=_PROTOCOL,
        idle_minutes=[seconds / 60 for seconds in IDLE_S],
        body_mass_kg=1.825,
        rest_length_m=0.27,
        capacity_mah=6600,
    )
    jumped = [run for run in campaign if run.gain is not None]

    def write_records(instruments: Path, step: Callable[[str], None]) -> None:
        for part in ("force", "logs"):
            (instruments / part).mkdir()
        for number, run in enumerate(jumped, start=1):
            step(f"writing run {number} of {len(jumped)}")
            if run.plate is None or run.log_ms is None or run.channels is None:
                continue
            record = bertec_text(run.plate.time_ms, run.plate.force_n, run.plate.moment_nm, run.plate.cop_m)
            (instruments / "force" / f"{run.name}_bertec_{MARK}.txt").write_bytes(record)
            log = string_pot_log(run.log_ms, run.channels, {"k_gain": 1})
            (instruments / "logs" / f"{run.name}_{MARK}.csv").write_bytes(log)

    truth = {"runs": list(map(_truth, jumped))}
    files = StudyFiles(text, VOLTAGE_V, ("k_gain",), list(map(_run, campaign)), write_records, truth)
    return make_study_book(folder, files, step, say)


def _run(run: PlateStudyRun) -> StudyRun:
    levels = {} if run.gain is None else {"k_gain": run.gain}
    return StudyRun(run.name, run.date, run.position, levels, run.hops, run.duration_s, run.charge_mah)


def _truth(run: PlateStudyRun) -> dict[str, object]:
    offset_s, drift = run.clocks
    return {
        "run": run.name,
        "k_gain": run.gain,
        "joules_per_jump": run.cost_j,
        "joules_in_stance": run.stance_j,
        "clock_offset_s": offset_s,
        "clock_drift": drift,
    }
