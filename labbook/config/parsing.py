"""Read `labbook.toml`: the study, its people, factors, protocol, equipment and column profiles.

The file is a proposal; what is in force is in the book, and every command compares the two. A key that is not known
is refused, because a typing error must not become a default. All faults are reported at once.
"""

from __future__ import annotations

import hashlib
import tomllib
import zoneinfo
from collections.abc import Mapping
from pathlib import Path

from data_schema.errors import InputRefused, unknown_name
from data_schema.vocabulary import StudyKind
from labbook.config.analysis import read_analysis, read_hypotheses
from labbook.config.factors import read_factors, read_gains
from labbook.config.model import (
    JUMP_RULES,
    LIMITS,
    BatterySettings,
    Configuration,
    Detector,
    FileSettings,
    InstrumentSettings,
    Onset,
    ProtocolSettings,
    RobotSettings,
    StudySettings,
    TakeOff,
)
from labbook.config.profiles import read_profiles
from labbook.config.run_names import DEFAULT, RunNames, scheme_fault
from labbook.config.simulation import read_simulation, with_own_scene
from labbook.config.studies import read_studies
from labbook.config.tables import TableReader, as_number, is_plain
from labbook.config.template import template

__all__ = ["Configuration", "parse_configuration", "template"]


def parse_configuration(text: str, source: str, folder: Path | None = None) -> Configuration:
    """Read a configuration; `source` names the file in messages.

    `folder`: where the file of a scene of one's own is looked for; None for a text that is stored with it and was in
    force: the channels that its profiles name stand, also where they would be refused now.
    Raises `InputRefused` with one sentence a fault, all faults at once.
    """
    faults: list[str] = []
    top = TableReader(_toml(text, source), "", faults)
    factors = read_factors(top)
    simulation = read_simulation(top, factors, folder)
    if folder is not None and simulation is not None and simulation.scene_toml is not None:
        text = with_own_scene(text, simulation.scene, simulation.scene_toml)
    configuration = Configuration(
        study=_study(top.table("study", required=True)),
        people=_people(top.table("people")),
        factors=factors,
        protocol=_protocol(top.table("protocol")),
        gains=read_gains(top, factors),
        robots={name: _robot(table) for name, table in top.tables("robots")},
        batteries={name: _battery(table) for name, table in top.tables("batteries")},
        instruments={name: _instrument(table) for name, table in top.tables("instruments")},
        files=_files(top.table("files"), in_force=folder is None),
        profiles=read_profiles(top, in_force=folder is None),
        simulation=simulation,
        analysis=read_analysis(top, factors),
        hypotheses=read_hypotheses(top, factors),
        studies=read_studies(top),
        database_url=_database(top.table("database")),
        store_path=_store(top.table("store")),
        text=text,
        sha256=hashlib.sha256(text.encode("utf-8")).hexdigest(),
    )
    top.finish()
    if len(faults) == 1:
        raise InputRefused(f"{source}: {faults[0]}")
    if faults:
        listed = "".join(f"\n  {fault}" for fault in faults)
        raise InputRefused(f"{source} has {len(faults)} faults, correct each of them and try again:{listed}")
    return configuration


def _toml(text: str, source: str) -> Mapping[str, object]:
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise InputRefused(f"{source} has brackets too deep inside each other: write it flatter.") from error
    except ValueError as error:  # also numbers of thousands of digits
        raise InputRefused(f"{source} is not TOML, {error}: correct that place and try again.") from error


def _study(table: TableReader) -> StudySettings:
    settings = StudySettings(
        name=table.text("name"),
        kind=table.word("kind", StudyKind),
        reference_voltage_v=table.number("reference_voltage_v", above=0.0, most=1000.0),
        jumps_nominal=table.whole("jumps_nominal", least=1),
        time_zone=table.text("time_zone"),
        run_names=_run_names(table),
    )
    try:
        zoneinfo.ZoneInfo(settings.time_zone or "UTC")
    except (zoneinfo.ZoneInfoNotFoundError, ValueError, OSError):  # a folder of zones raises OSError
        known = zoneinfo.available_timezones()
        table.fault("time_zone", str(unknown_name("time zone", settings.time_zone, known)))
    table.finish()
    return settings


def _run_names(table: TableReader) -> RunNames:
    scheme = table.optional_text("run_names")
    fault = scheme_fault(scheme) if scheme else None
    if fault is not None:
        table.fault("run_names", fault)
    return RunNames(scheme if scheme and fault is None else DEFAULT)


def _people(table: TableReader) -> dict[str, str]:
    people = {name: table.text(name) for name in table.names()}
    shorts = list(people.values())
    for name, initials in people.items():
        if initials and (shorts.count(initials) > 1 or (initials in people and initials != name)):
            table.fault(name, f"the initials {initials!r} also stand for someone else: choose others.")
    return people


def _protocol(table: TableReader) -> ProtocolSettings:
    minutes: list[float] = []
    for given in table.items("idle_minutes", "minutes"):
        number = as_number(given)
        if number is None or number <= 0:
            table.fault("idle_minutes", f"{given!r} is not a time in minutes: write numbers greater than 0.")
        else:
            minutes.append(number)
    checks: list[str] = []
    for given in table.items("checks", "names in quotes"):
        if not isinstance(given, str) or not is_plain(given) or given in checks:
            table.fault("checks", f"{given!r} is no name of a check, or there twice: write each once, in quotes.")
        else:
            checks.append(given)
    settings = ProtocolSettings(
        run_duration_s=table.optional_number("run_duration_s", above=0.0),
        detector=table.word("detector", Detector, Detector.ROBUST),
        exclude_first_jumps=table.whole("exclude_first_jumps", 0, least=0),
        exclude_gap_jumps=table.flag("exclude_gap_jumps", True),
        onset=table.word("onset", Onset, Onset.SDS_BACK_30MS),
        take_off=table.word("take_off", TakeOff, TakeOff.FLIGHT_SDS),
        charger_resolution_mah=table.optional_number("charger_resolution_mah", above=0.0),
        idle_minutes=tuple(minutes),
        checks=tuple(checks),
        rules_given=frozenset(key for key in JUMP_RULES if table.value(key) is not None),
    )
    table.finish()
    return settings


def _robot(table: TableReader) -> RobotSettings:
    settings = RobotSettings(
        body_mass_kg=table.number("body_mass_kg", above=0.0),
        foot_mass_kg=table.number("foot_mass_kg", above=0.0),
        link_1_m=table.number("link_1_m", above=0.0),
        link_2_m=table.number("link_2_m", above=0.0),
        rest_length_m=table.number("rest_length_m", above=0.0),
        leg_min_m=table.number("leg_min_m", above=0.0),
        leg_max_m=table.number("leg_max_m", above=0.0),
    )
    if settings.leg_min_m >= settings.leg_max_m:
        table.fault("leg_min_m", f"{settings.leg_min_m:g} is not less than leg_max_m: exchange or correct them.")
    table.finish()
    return settings


def _battery(table: TableReader) -> BatterySettings:
    settings = BatterySettings(table.whole("cells", least=1), table.number("capacity_mah", above=0.0))
    table.finish()
    return settings


def _instrument(table: TableReader) -> InstrumentSettings:
    settings = InstrumentSettings(
        kind=table.text("kind"),
        make=table.optional_text("make"),
        model=table.optional_text("model"),
        serial=table.optional_text("serial"),
    )
    table.finish()
    return settings


def _files(table: TableReader, in_force: bool) -> FileSettings:
    if in_force:
        table.value("run_pattern")  # what a book's files stated by it is stored with them
    bounds = table.table("limits")
    limits = {name: bounds.whole(name, least=1) for name in LIMITS if bounds.value(name) is not None}
    bounds.finish()
    table.finish()
    return FileSettings(limits)


def _database(table: TableReader) -> str | None:
    url = table.optional_text("url")
    if url is not None and not url.startswith("postgresql+psycopg://"):
        example = "postgresql+psycopg://user@host/labbook"
        table.fault("url", f"{url!r} is no address of a PostgreSQL database: write one such as {example!r}.")
    table.finish()
    return url


def _store(table: TableReader) -> str | None:
    path = table.optional_text("path")
    table.finish()
    return path
