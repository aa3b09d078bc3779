"""The emulator campaign as files in the instruments' formats, and as a book that has ingested them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

from labbook.demo.files import MARK
from labbook.demo.studies.book import RUNS_TOML, StudyFiles, StudyRun, make_study_book
from labbook.demo.studies.emulator import GAINS, IDLE_S, REST_LENGTH_M, VOLTAGE_V, EmulatorRun, dampings, truths
from labbook.demo.writers import string_pot_log

_FACTORS = ("k_gain", "b_ad_gain")
_FURTHER = """\
[factors.b_ad_gain]
kind = "number"
title = "active-damping coefficient"
levels = {dampings}
control = 0

[gains.b_ad_gain]
symbol = "d"
slope = 3.32
offset = 0
unit = "kg/s"
zero = 0

[analysis]
primary_outcome = "joules"
family = "each"
apex_bounds_percent = [-6, 6]
unit_of_analysis = "shared_days"

[simulation]
scene = "emulator"
factors = {{ k_gain = "k_extension", b_ad_gain = "b_ad" }}

[hypotheses.saves]
text = "Active damping saves energy at every gain"
source = "thesis 4.3"
published = "in all conditions"
claim = "saves"

[hypotheses.no_lower_apex]
text = "It costs less than 6 % of the apex height"
source = "thesis 4.3.3"
published = "less than 6 %"
claim = "not_lower"
outcome = "apex"
within_percent = 6

[hypotheses.torque_limit]
text = "The apex is the same at gains 400 and 500"
source = "thesis 4.3.3"
published = "no appreciable difference"
claim = "same"
side = "control"
outcome = "apex"
between = "k_gain"
levels = [400, 500]
within_percent = 2
"""
_PROTOCOL = """\
# The first two jumps, and those with a dropped packet in flight, are left out (thesis 4.3.3).
[protocol]
exclude_first_jumps = 2"""


def make_emulator_book(
    folder: Path, campaign: Sequence[EmulatorRun], step: Callable[[str], None], say: Callable[[str], None]
) -> Path:
    """Write the campaign's files and ingest them into a new book; returns the book's folder."""
    jumps = max(run.jumps for run in campaign)
    further = _FURTHER.format(dampings=sorted({damping for gain in GAINS for damping in dampings(gain)}))
    text = RUNS_TOML.format(
        study="emulator",
        section="4.3",
        name="ground emulator",
        kind="emulator",
        voltage_v=VOLTAGE_V,
        jumps=jumps,
        gains=list(GAINS),
        protocol=_PROTOCOL,
        idle_minutes=[seconds // 60 for seconds in IDLE_S],
        body_mass_kg=1.575,
        rest_length_m=REST_LENGTH_M,
        capacity_mah=7200,
    )
    truth = {"conditions": [asdict(one) for one in truths(jumps)]}
    files = StudyFiles(text + further, _logs(campaign), truth, list(map(_run, campaign)), _FACTORS, VOLTAGE_V)
    return make_study_book(folder, files, step, say)


def _logs(campaign: Sequence[EmulatorRun]) -> Iterator[tuple[str, bytes]]:
    for run in campaign:
        if run.log_ms is not None and run.channels is not None:
            yield f"logs/{run.name}_{MARK}.csv", string_pot_log(run.log_ms, run.channels, dict.fromkeys(_FACTORS, 1))


def _run(run: EmulatorRun) -> StudyRun:
    levels = {} if run.condition is None else dict(zip(_FACTORS, run.condition, strict=True))
    return StudyRun(run.name, run.date, run.position, levels, run.jumps, run.duration_s, run.charge_mah)
