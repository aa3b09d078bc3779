"""The force-plate campaign as files in the instruments' formats, and as a book that has ingested them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from labbook.demo.files import MARK
from labbook.demo.studies.book import RUNS_TOML, StudyFiles, make_study_book
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
    text = RUNS_TOML.format(
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
    truth = {"runs": [_truth(run) for run in campaign if run.gain is not None]}
    files = StudyFiles(text + _FURTHER, _records(campaign), truth, campaign, ("k_gain",), VOLTAGE_V)
    return make_study_book(folder, files, step, say)


def _records(campaign: Sequence[PlateStudyRun]) -> Iterator[tuple[str, bytes]]:
    for run in campaign:
        if (plate := run.plate) is not None and run.log_ms is not None and run.channels is not None:
            record = bertec_text(plate.time_ms, plate.force_n, plate.moment_nm, plate.cop_m)
            yield f"force/{run.name}_bertec_{MARK}.txt", record
            yield f"logs/{run.name}_{MARK}.csv", string_pot_log(run.log_ms, run.channels, {"k_gain": 1})


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
