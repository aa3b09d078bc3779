"""What a force plate says of each run: peak force, contact time, jump heights, weight.

Single jumps out of quiet standing are measured one by one; of hops after each other, the contacts between flights are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache as once
from functools import partial

import numpy as np
from numpy.typing import NDArray

from data_schema.queries.signals import GapRow, SignalRow, gaps_by_signal
from data_schema.reasons import Reason
from data_schema.vocabulary import FileRole, Undefined
from ingest.store import Store
from labbook.analysis.outcomes.detection import Detections, gaps_for_detector
from labbook.analysis.outcomes.run_apexes import ApexVariant
from labbook.analysis.results import Algorithm, Results, RunResults, run_input, signal_input
from labbook.analysis.study_data import VERTICAL_FORCE, StudyData
from reports.numbers import Number, Result
from stats.compare.summary import describe
from stats.force_plate import Contact, find_contacts, jump_heights
from stats.single_jump import ONSETS, TAKE_OFFS, SingleJump, find_jumps, measure_jump

Record = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Times in s and vertical force in N, both of shape (n,)."""


@dataclass(frozen=True, slots=True)
class PushOffRules:
    """By which rules single jumps begin and leave the plate: names of `stats.single_jump.ONSETS` and `TAKE_OFFS`."""

    onset: str
    take_off: str

    def __str__(self) -> str:
        """Name both."""
        return f"onset {self.onset}, take-off {self.take_off}"


ALL_RULES = tuple(PushOffRules(onset, take_off) for onset in ONSETS for take_off in TAKE_OFFS)


@dataclass(frozen=True, slots=True)
class RunForce(Result):
    """Means over the single jumps of a run, or over its contacts, and the weight used for the heights, None without.

    `of_each` holds the values of the single contacts and jumps, by the name of the number; `single_jumps` counts the
    jumps out of quiet standing, 0 where contacts are what was measured.
    """

    peak_force: Number
    contact_time: Number
    impulse_height: Number
    flight_height: Number
    of_each: Mapping[str, tuple[float, ...]]
    weight: Number | None = None
    single_jumps: int = 0


ALGORITHM = Algorithm("run_force", 5)


_NO_RECORD = Undefined(Reason.NO_FORCE_RECORD)


def usable_force(forces: Sequence[SignalRow]) -> SignalRow | Undefined:
    """Return the one record of vertical force of a run, or why there is none; samples saved twice are one record.

    A plate's own record goes before what a log holds of it.
    """
    own = [signal for signal in forces if signal.role == FileRole.FORCE]
    distinct = list({signal.sha256: signal for signal in own or forces}.values())
    if not distinct:
        return _NO_RECORD
    return distinct[0] if len(distinct) == 1 else Undefined(Reason.SEVERAL_FORCE_RECORDS, n=len(distinct))


def push_off_rules(data: StudyData) -> PushOffRules:
    """Return the rules that the protocol names."""
    protocol = data.configuration.protocol
    return PushOffRules(protocol.onset, protocol.take_off)


def measured(computed: Results, detections: Detections, data: StudyData, _variant: ApexVariant) -> RunResults[RunForce]:
    """Compute the numbers from the force plate of every selected jump run that has one record of it."""
    missing: dict[str, Undefined] = {}
    signals: dict[str, SignalRow] = {}
    for run in data.runs:
        usable = usable_force(data.forces.get(run.uid, []))
        if isinstance(usable, Undefined):
            missing[run.uid] = usable
        else:
            signals[run.uid] = usable
    (found,) = _forces(computed, detections, data, signals, [push_off_rules(data)])
    return RunResults(found, missing)


def run_forces_by_rules(
    computed: Results, detections: Detections, data: StudyData, run_uids: Iterable[str]
) -> dict[PushOffRules, dict[str, RunForce]]:
    """Compute the numbers of runs of single jumps by every rule of onset with every rule of take-off."""
    usable = {uid: usable_force(data.forces.get(uid, [])) for uid in run_uids}
    signals = {uid: signal for uid, signal in usable.items() if not isinstance(signal, Undefined)}
    return dict(zip(ALL_RULES, _forces(computed, detections, data, signals, ALL_RULES), strict=True))


def _forces(
    computed: Results,
    detections: Detections,
    data: StudyData,
    signals: Mapping[str, SignalRow],
    by_rules: Sequence[PushOffRules],
) -> list[dict[str, RunForce]]:
    gaps = gaps_by_signal(detections.connection, [signal.uid for signal in signals.values()])
    runs = {run.uid: run for run in data.runs if run.uid in signals}
    reads = {uid: _reader(detections.store, signals[uid], gaps[signals[uid].uid]) for uid in runs}
    if len(by_rules) > 1:
        reads = {uid: once(read) for uid, read in reads.items()}
    found = []
    for rules in by_rules:
        by = {"onset": rules.onset, "take_off": rules.take_off}
        of_rules = {}
        for uid, run in runs.items():
            missing = [list(gap) for gap in gaps_for_detector(gaps[signals[uid].uid])]
            inputs = (run_input(run), signal_input(signals[uid], "force plate"))
            of_run = _run_force(*reads[uid](), rules)
            of_rules[uid] = computed.record(ALGORITHM, {"run": run.name, **by}, inputs, of_run, {"gaps": missing, **by})
        found.append(of_rules)
    return found


def _reader(store: Store, signal: SignalRow, gaps: Sequence[GapRow]) -> Callable[[], Record]:
    return partial(vertical_force, store, signal, gaps_for_detector(gaps))


def force_of_run(detections: Detections, forces: Sequence[SignalRow], rules: PushOffRules) -> RunForce | Undefined:
    """Compute the numbers of one run from its records of vertical force, without ids."""
    usable = usable_force(forces)
    if isinstance(usable, Undefined):
        return usable
    gaps = gaps_by_signal(detections.connection, [usable.uid])[usable.uid]
    return _run_force(*_reader(detections.store, usable, gaps)(), rules)


def vertical_force(store: Store, signal: SignalRow, missing: Sequence[tuple[float, float]]) -> Record:
    """Read the force on all plates together, NaN where samples are missing."""
    from ingest.channels.names import channel_kind  # here, for every report loads this file and few have a force plate

    plates = [name for name in signal.channels if channel_kind(name) == VERTICAL_FORCE]
    samples = store.samples(signal.store_path, plates)
    force_n = np.sum([samples[name] for name in plates], axis=0)
    for start_s, length_s in missing:
        force_n[(samples["time"] >= start_s) & (samples["time"] <= start_s + length_s)] = np.nan
    return samples["time"], force_n


def _run_force(time_s: NDArray[np.float64], force_n: NDArray[np.float64], rules: PushOffRules) -> RunForce:
    found = find_jumps(time_s, force_n)
    if isinstance(found, Undefined):
        return _of_contacts(find_contacts(time_s, force_n), found)
    measured = [measure_jump(jump, rules.onset, rules.take_off) for jump in found]
    jumps = [one for one in measured if isinstance(one, SingleJump)]
    if not jumps:
        why = next(one for one in measured if isinstance(one, Undefined))
        return RunForce(
            Number(why, "N"), Number(why, "s"), Number(why, "m"), Number(why, "m"), {}, single_jumps=len(found)
        )
    flights = [
        (one.flight_height_m, one.flight_height_se_m)
        for one in jumps
        if isinstance(one.flight_height_m, float) and isinstance(one.flight_height_se_m, float)
    ]
    of_each = {
        "peak_force": [(one.peak_n, one.peak_se_n) for one in jumps],
        "contact_time": [(one.push_off_s, one.push_off_se_s) for one in jumps],
        "impulse_height": [(one.height_m, one.height_se_m) for one in jumps],
        "flight_height": flights,
    }
    return RunForce(
        peak_force=_mean(of_each["peak_force"], "N"),
        contact_time=_mean(of_each["contact_time"], "s"),
        impulse_height=_mean(of_each["impulse_height"], "m"),
        flight_height=_mean(flights, "m") if flights else Number(Undefined(Reason.NO_LANDING), "m"),
        of_each={name: tuple(value for value, _se in several) for name, several in of_each.items()},
        weight=_mean([(one.weight_n, one.weight_se_n) for one in jumps], "N"),
        single_jumps=len(found),
    )


def _mean(of_each: Sequence[tuple[float, float]], unit: str) -> Number:
    """Return the mean of values with its standard error: by their scatter, or of a single one its own."""
    about = describe([value for value, _se in of_each])
    return Number(about.mean, unit, about.se if len(of_each) > 1 else of_each[0][1], n=about.n)


def _of_contacts(contacts: tuple[Contact, ...] | Undefined, no_single_jump: Undefined) -> RunForce:
    """Measure contacts between flights; `no_single_jump` says why there is no jump out of quiet standing."""
    flight_height = Number(no_single_jump, "m")
    if isinstance(contacts, Undefined) or not contacts:
        why = contacts if isinstance(contacts, Undefined) else Undefined(Reason.NO_CONTACT)
        height = why if isinstance(contacts, Undefined) else no_single_jump
        return RunForce(Number(why, "N"), Number(why, "s"), Number(height, "m"), flight_height, {})
    peaks_n, durations_s = [one.peak_n for one in contacts], [one.duration_s for one in contacts]
    peak, contact = (
        Number(about.mean, unit, about.se, n=about.n)
        for about, unit in ((describe(peaks_n), "N"), (describe(durations_s), "s"))
    )
    of_each = {"peak_force": tuple(peaks_n), "contact_time": tuple(durations_s)}
    jumps = jump_heights(contacts)
    if isinstance(jumps, Undefined):
        return RunForce(peak, contact, Number(no_single_jump, "m"), flight_height, of_each)
    n = len(jumps.heights_m)
    return RunForce(
        peak_force=peak,
        contact_time=contact,
        impulse_height=Number(jumps.mean_m, "m", jumps.se_m, n=n),
        flight_height=flight_height,
        of_each={**of_each, "impulse_height": tuple(jumps.heights_m)},
        weight=Number(jumps.weight_n, "N", n=n),
    )
