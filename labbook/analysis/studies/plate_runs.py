"""The runs of a book that a force plate and the robot's log both recorded, with the joules that the battery gave."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import sqlalchemy as sa

from data_schema.errors import InputRefused, UsageError
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import SignalRow, gaps_by_signal, signals_of_runs
from data_schema.reasons import Reason
from data_schema.vocabulary import FileRole, Undefined
from ingest.store import Store
from labbook.analysis.outcomes.detection import gaps_for_detector
from labbook.analysis.outcomes.run_energy import RunEnergy, passive_drains, run_energies
from labbook.analysis.outcomes.run_force import usable_force, vertical_force
from labbook.analysis.prediction.condition_scenes import study_scene
from labbook.analysis.prediction.simulating import plain_predictions
from labbook.analysis.results.result_cache import ResultCache
from labbook.analysis.studies.force_plate import MOTOR_PARAMETERS, Drive, ForcePlateStudy, PlateRun, compare_joules
from labbook.analysis.study_data import StudyData, gather
from labbook.config.model import RobotSettings, SimulationSettings
from labbook.config.parsing import Configuration

LEG_LENGTH = "leg_length"
_FEWEST_CONDITIONS = 2


def force_plate_study(
    connection: sa.Connection,
    store: Store,
    configuration: Configuration,
    where: str | None,
    window: int | None,
    level: float,
    progress: Callable[[str], None],
) -> ForcePlateStudy:
    """Compare estimated and measured joules of the selected runs that have a force-plate record.

    Raises `InputRefused` as `compare_joules` does, and, with the line of labbook.toml to write, for a book without what
    it takes: records of the plate, leg lengths, joules, motors, and at least two conditions.
    """
    data = gather(connection, configuration, where)
    on_plate = [run for run in data.runs if data.forces.get(run.uid)]
    if not on_plate:
        raise InputRefused(
            f"none of {len(data.runs)} runs has a force-plate record: `labbook ingest` the plate's exports beside the "
            "logs, named after their runs."
        )
    legs = _leg_signals(connection)
    _check_study(configuration, on_plate, legs)
    cache = ResultCache(connection)
    energies = run_energies(cache, data, passive_drains(cache, data))
    missing = data.reasons(energies.missing, FileRole.CHARGE)
    left_out: dict[str, Undefined] = {}
    found = []
    for run in on_plate:
        progress(f"reading {run.name}")
        force, leg = usable_force(data.forces[run.uid]), _usable_leg(legs.get(run.uid, ()))
        energy = missing[run.uid] if run.uid in missing else energies.results[run.uid]
        if isinstance(force, Undefined) or isinstance(leg, Undefined) or isinstance(energy, Undefined):
            left_out[run.name] = next(one for one in (force, leg, energy) if isinstance(one, Undefined))
            continue
        measured_j = energy.joules_per_jump.value
        if isinstance(measured_j, float) and measured_j <= 0.0:
            measured_j = Undefined(Reason.JOULES_NOT_POSITIVE, joules=measured_j)
        if isinstance(measured_j, Undefined):
            left_out[run.name] = measured_j
            continue
        found.append(_plate_run(connection, store, data, run, (force, leg), energy, measured_j))
    if not found:
        name, why = next(iter(left_out.items()))
        raise InputRefused(
            f"no run on the plate has both a leg length and joules; {name}: {why.reason}. Joules need the recharge of "
            "each run, and idle runs of several durations."
        )
    conditions = {run.condition for run in found}
    if len(conditions) < _FEWEST_CONDITIONS:
        raise InputRefused(
            f"all runs on the plate are of one condition ({found[0].condition}), and a slope needs hops of different "
            "joules: run other extension gains too."
        )
    progress("estimating joules")
    study = compare_joules(found, window, level, left_out)
    simulated = plain_predictions(connection, data, progress)
    names = {run.condition_key: _condition(run) for run in data.runs}
    by_condition = {names[key]: values for key, values in simulated.values.items()}
    return replace(study, simulated=replace(simulated, values=by_condition))


def _check_study(configuration: Configuration, runs: Sequence[RunRow], legs: Mapping[str, Sequence[SignalRow]]) -> None:
    """Refuse a book that lacks what all runs need, with the line to write."""
    if not configuration.factors:
        raise UsageError(
            "labbook.toml has no factor, and the slope is over extension gains: write them as [factors.k_gain] with "
            'kind = "number" and levels = [300, 400, 500, 600].'
        )
    if configuration.simulation is None:
        raise UsageError(
            "labbook.toml does not say with which motors joules are estimated: write [simulation] with "
            'scene = "force_plate" (and your motors under parameters = { torque_constant = 0.0955, ... }).'
        )
    if not any(legs.get(run.uid) for run in runs):
        raise InputRefused(
            f"no log of the runs on the plate ({runs[0].name}, ...) has the channel leg_length: declare its column in "
            'labbook.toml, [profiles.NAME.columns] Leg = { channel = "leg_length", unit = "mm" }, and `labbook files '
            "reread` the logs."
        )


def _leg_signals(connection: sa.Connection) -> dict[str, list[SignalRow]]:
    found: dict[str, list[SignalRow]] = {}
    for signal in signals_of_runs(connection, FileRole.LOG):
        if LEG_LENGTH in signal.channels:
            found.setdefault(signal.run_uid, []).append(signal)
    return found


def _usable_leg(signals: Sequence[SignalRow]) -> SignalRow | Undefined:
    """Return the one log of a run's leg length; samples saved twice are one."""
    distinct = list({signal.sha256: signal for signal in signals}.values())
    if not distinct:
        return Undefined(Reason.NO_LEG_LENGTH)
    return distinct[0] if len(distinct) == 1 else Undefined(Reason.SEVERAL_LEG_LENGTHS, n=len(distinct))


def _plate_run(
    connection: sa.Connection,
    store: Store,
    data: StudyData,
    run: RunRow,
    signals: tuple[SignalRow, SignalRow],
    energy: RunEnergy,
    measured_j: float,
) -> PlateRun:
    force, leg = signals
    robot = data.configuration.robots.get(run.robot)
    if robot is None:
        raise UsageError(
            f"labbook.toml has no robot {run.robot!r}, whose links run {run.name} needs: write [robots.{run.robot}] "
            "with link_1_m and link_2_m."
        )
    gaps = gaps_by_signal(connection, [force.uid])[force.uid]
    plate_time_s, force_n = vertical_force(store, force, gaps_for_detector(gaps))
    samples = store.samples(leg.store_path, [LEG_LENGTH])
    known = np.isfinite(samples[LEG_LENGTH])
    return PlateRun(
        name=run.name,
        day=run.day,
        condition=_condition(run),
        title=", ".join(_level_words(data.configuration, factor, label) for factor, label in run.levels.items()),
        measured_j=measured_j,
        shared=energy.shared_error,
        hops=run.jumps_made,
        foot_mass_kg=robot.foot_mass_kg,
        drive=_drive(data.configuration.simulation, robot),
        plate_time_s=plate_time_s,
        force_n=force_n,
        leg_time_s=samples["time"][known],
        length_m=samples[LEG_LENGTH][known],
    )


def _condition(run: RunRow) -> str:
    return ", ".join(f"{factor} {label}" for factor, label in run.levels.items())


def _level_words(configuration: Configuration, factor: str, label: str) -> str:
    about = configuration.factors[factor]
    return f"{about.title or factor} {label}{f' {about.unit}' if about.unit else ''}"


def _drive(settings: SimulationSettings | None, robot: RobotSettings) -> Drive:
    assert settings is not None  # noqa: S101 - `_check_study` has asked
    scene = study_scene(settings)
    motors = {name: settings.parameters.get(name, scene[name]) for name in MOTOR_PARAMETERS}
    return Drive(upper_link=robot.link_1_m, lower_link=robot.link_2_m, **motors)
