"""What a force plate says of each run: peak force, contact time, jump height by impulse and momentum, weight."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import GapRow, SignalRow, gaps_by_signal
from data_schema.vocabulary import FileRole, Undefined
from ingest.channels.names import channel_kind
from ingest.store import Store
from labbook.analysis.outcomes.detecting import heeded_gaps
from labbook.analysis.outcomes.detections import Detections
from labbook.analysis.outcomes.run_results import RunResults
from labbook.analysis.results.facts import run_input, signal_input
from labbook.analysis.results.result_cache import Algorithm, Computed, NewNumber, Request, ResultCache
from labbook.analysis.study_data import VERTICAL_FORCE, StudyData
from stats.compare.summary import describe
from stats.force_plate import Contact, find_contacts, jump_heights

ALGORITHM = Algorithm("run_force", 3)
_UNITS = {outcome.number_name: outcome.unit for outcome in Outcome if outcome.source is FileRole.FORCE}


def usable_force(forces: Sequence[SignalRow]) -> SignalRow | str:
    """Return the one record of vertical force of a run, or why there is none; samples saved twice are one record."""
    distinct = list({signal.sha256: signal for signal in forces}.values())
    if not distinct:
        return "no force-plate record"
    return distinct[0] if len(distinct) == 1 else f"{len(distinct)} force-plate records, and one is expected"


def run_forces(cache: ResultCache, detections: Detections, data: StudyData) -> RunResults:
    """Ensure the numbers from the force plate of every selected jump run that has one record of it."""
    missing: dict[str, str] = {}
    signals: dict[str, SignalRow] = {}
    for run in data.runs:
        usable = usable_force(data.forces.get(run.uid, []))
        if isinstance(usable, str):
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


def _request(store: Store, run: RunRow, signal: SignalRow, gaps: Sequence[GapRow]) -> Request:
    missing = heeded_gaps(gaps)
    return Request(
        ALGORITHM,
        {"run": run.name},
        (run_input(run), signal_input(signal, "force plate")),
        {"gaps": [list(gap) for gap in missing]},
        lambda: _computed(_contacts(store, signal, missing)),
    )


def _contacts(
    store: Store, signal: SignalRow, missing: Sequence[tuple[float, float]]
) -> tuple[Contact, ...] | Undefined:
    """Find the contacts in the force on all plates together."""
    plates = [name for name in signal.channels if channel_kind(name) == VERTICAL_FORCE]
    samples = store.samples(signal.store_path, plates)
    force_n = np.sum([samples[name] for name in plates], axis=0)
    for start_s, length_s in missing:
        force_n[(samples["time"] >= start_s) & (samples["time"] <= start_s + length_s)] = np.nan
    return find_contacts(samples["time"], force_n)


def _computed(contacts: tuple[Contact, ...] | Undefined) -> Computed:
    if isinstance(contacts, tuple) and not contacts:
        contacts = Undefined("no contact begins and ends within the record")
    if isinstance(contacts, Undefined):
        undefined = contacts
        return Computed(tuple(NewNumber(name, undefined, unit) for name, unit in _UNITS.items()), {})
    values = {
        "peak_force": [contact.peak_n for contact in contacts],
        "contact_time": [contact.duration_s for contact in contacts],
    }
    described = {name: describe(several) for name, several in values.items()}
    numbers = [NewNumber(name, about.mean, _UNITS[name], about.se, n=about.n) for name, about in described.items()]
    jumps = jump_heights(contacts)
    if isinstance(jumps, Undefined):
        numbers.append(NewNumber("impulse_height", jumps, "m"))
    else:
        n = len(jumps.heights_m)
        numbers.append(NewNumber("impulse_height", jumps.mean_m, "m", jumps.se_m, n=n))
        numbers.append(NewNumber("weight", jumps.weight_n, "N", n=n))
        values["impulse_height"] = list(jumps.heights_m)
    return Computed(tuple(numbers), dict(values))
