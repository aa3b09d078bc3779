"""What a force plate says of each run: peak force, contact time, jump height by impulse and momentum, weight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import GapRow, SignalRow, gaps_by_signal
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from ingest.channels.names import channel_kind
from ingest.store import Store
from labbook.analysis.outcomes.detection import Detections, gaps_for_detector
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.result_cache import Request, ResultCache, RunResults, run_input, signal_input
from labbook.analysis.study_data import VERTICAL_FORCE, StudyData
from reports.numbers import Number
from stats.compare.summary import describe
from stats.force_plate import Contact, find_contacts, jump_heights


@dataclass(frozen=True, slots=True)
class RunForce(StoredResult):
    """Means over the contacts of a run, and the weight used for the jump heights, None where there are none.

    `of_each` holds the values of the single contacts and jumps, by the name of the number.
    """

    peak_force: Number
    contact_time: Number
    impulse_height: Number
    of_each: Mapping[str, tuple[float, ...]]
    weight: Number | None = None


ALGORITHM = Algorithm("run_force", 3, RunForce)


def usable_force(forces: Sequence[SignalRow]) -> SignalRow | Undefined:
    """Return the one record of vertical force of a run, or why there is none; samples saved twice are one record."""
    distinct = list({signal.sha256: signal for signal in forces}.values())
    if not distinct:
        return Undefined(Reason.NO_FORCE_RECORD)
    return distinct[0] if len(distinct) == 1 else Undefined(Reason.SEVERAL_FORCE_RECORDS, n=len(distinct))


def run_forces(cache: ResultCache, detections: Detections, data: StudyData) -> RunResults[RunForce]:
    """Ensure the numbers from the force plate of every selected jump run that has one record of it."""
    missing: dict[str, Undefined] = {}
    signals: dict[str, SignalRow] = {}
    for run in data.runs:
        usable = usable_force(data.forces.get(run.uid, []))
        if isinstance(usable, Undefined):
            missing[run.uid] = usable
        else:
            signals[run.uid] = usable
    gaps = gaps_by_signal(detections.connection, [signal.uid for signal in signals.values()])
    requests = {
        run.uid: _request(detections.store, run, signals[run.uid], gaps[signals[run.uid].uid])
        for run in data.runs
        if run.uid in signals
    }
    return RunResults(dict(zip(requests, cache.ensure(list(requests.values())), strict=True)), missing)


def _request(store: Store, run: RunRow, signal: SignalRow, gaps: Sequence[GapRow]) -> Request[RunForce]:
    missing = gaps_for_detector(gaps)
    return Request(
        ALGORITHM,
        {"run": run.name},
        (run_input(run), signal_input(signal, "force plate")),
        {"gaps": [list(gap) for gap in missing]},
        lambda: _run_force(find_contacts(*vertical_force(store, signal, missing))),
    )


def vertical_force(
    store: Store, signal: SignalRow, missing: Sequence[tuple[float, float]]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Read the force on all plates together, NaN where samples are missing: times in s and N, both of shape (n,)."""
    plates = [name for name in signal.channels if channel_kind(name) == VERTICAL_FORCE]
    samples = store.samples(signal.store_path, plates)
    force_n = np.sum([samples[name] for name in plates], axis=0)
    for start_s, length_s in missing:
        force_n[(samples["time"] >= start_s) & (samples["time"] <= start_s + length_s)] = np.nan
    return samples["time"], force_n


def _run_force(contacts: tuple[Contact, ...] | Undefined) -> RunForce:
    if isinstance(contacts, tuple) and not contacts:
        contacts = Undefined(Reason.NO_CONTACT)
    if isinstance(contacts, Undefined):
        peak, contact, height = (
            Number(contacts, outcome.unit)
            for outcome in (Outcome.PEAK_FORCE, Outcome.CONTACT_TIME, Outcome.IMPULSE_HEIGHT)
        )
        return RunForce(peak, contact, height, {})
    peaks_n, durations_s = [one.peak_n for one in contacts], [one.duration_s for one in contacts]
    peak, contact = (
        Number(about.mean, unit, about.se, n=about.n)
        for about, unit in ((describe(peaks_n), "N"), (describe(durations_s), "s"))
    )
    of_each = {"peak_force": tuple(peaks_n), "contact_time": tuple(durations_s)}
    jumps = jump_heights(contacts)
    if isinstance(jumps, Undefined):
        return RunForce(peak, contact, Number(jumps, "m"), of_each)
    n = len(jumps.heights_m)
    return RunForce(
        peak_force=peak,
        contact_time=contact,
        impulse_height=Number(jumps.mean_m, "m", jumps.se_m, n=n),
        of_each={**of_each, "impulse_height": tuple(jumps.heights_m)},
        weight=Number(jumps.weight_n, "N", n=n),
    )
