"""Read `labbook.toml`: the study, its people, factors, protocol, equipment and column profiles.

The file is a proposal; what is in force is in the book, and every command compares the two. A key that is not known
is refused, because a typing error must not become a default. All faults are reported at once.

Patterns for the names of runs must end in bounded time. Python's matcher tries ways of matching one after the other. A
repeat inside a repeat, as in `(\\d+)*`, many optional letters or several wildcards in a row have more ways than anybody
waits for, on a name that does not match. The ways are bounded from above, as a number of bits, by the signs of the
pattern alone.
"""

from __future__ import annotations

import hashlib
import math
import re
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
    ProtocolSettings,
    RobotSettings,
    StudySettings,
)
from labbook.config.profiles import read_profiles
from labbook.config.simulation import read_simulation, with_own_scene
from labbook.config.studies import read_studies
from labbook.config.tables import TableReader, as_number
from labbook.config.template import template

__all__ = ["Configuration", "parse_configuration", "template"]


def parse_configuration(text: str, source: str, folder: Path | None = None) -> Configuration:
    """Read a configuration; `source` names the file in messages.

    `folder`: where the file of a scene of one's own is looked for; None for a text that is kept with it and was in
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
        analysis=read_analysis(top),
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
    )
    try:
        zoneinfo.ZoneInfo(settings.time_zone or "UTC")
    except (zoneinfo.ZoneInfoNotFoundError, ValueError, OSError):  # a folder of zones raises OSError
        known = zoneinfo.available_timezones()
        table.fault("time_zone", str(unknown_name("time zone", settings.time_zone, known)))
    table.finish()
    return settings


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
    settings = ProtocolSettings(
        run_duration_s=table.optional_number("run_duration_s", above=0.0),
        detector=table.word("detector", Detector, Detector.ROBUST),
        exclude_first_jumps=table.whole("exclude_first_jumps", 0, least=0),
        exclude_gap_jumps=table.flag("exclude_gap_jumps", True),
        charger_resolution_mah=table.number("charger_resolution_mah", 1.0, above=0.0),
        idle_minutes=tuple(minutes),
        stated=frozenset(key for key in JUMP_RULES if table.value(key) is not None),
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
    pattern = table.optional_text("run_pattern")
    fault = None if pattern is None else pattern_fault(pattern, in_force)
    if fault is not None:
        table.fault("run_pattern", fault)
    bounds = table.table("limits")
    limits = {name: bounds.whole(name, least=1) for name in LIMITS if bounds.value(name) is not None}
    bounds.finish()
    table.finish()
    return FileSettings(pattern, limits)


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


MOST_LETTERS = 500
LONGEST_NAME = 255
MOST_BITS = 26
"""Three wildcards in a row, and two choices: seconds on the longest name, where it does not match."""

_SIGN = re.compile(
    r"""\\.|\[\^?\]?(?:\\.|[^\]\\])*\]        # an escaped letter, a set of letters
    |\(\?[aiLmsu-]*\)                        # flags
    |\(\?P?<\w+>|\(\?(?:<?[=!]|[aiLmsu-]*:|>)|[()]  # groups
    |[*+?][?+]?|\{\d*,?\d*\}[?+]?           # repeats
    |.""",
    re.DOTALL | re.VERBOSE,
)
_REPEAT = re.compile(r"(?P<sign>[*+?])[?+]?|\{(?P<least>\d*)(?P<comma>,?)(?P<most>\d*)\}[?+]?")
_VERBOSE = re.compile(r"\(\?[aiLmsu]*x")
_NO_LETTER = re.compile(r"[|(^)]|\\[AbB0-9]|\(\?")
_LETTERS = "".join(map(chr, range(256))) + "\u03bb\u0416\u4e2d\u0663"


def pattern_fault(pattern: str, in_force: bool) -> str | None:
    """Return what is wrong with a pattern for a run's name, or None; one that is `in_force` may be slow."""
    try:
        if "run" not in re.compile(pattern).groupindex:
            return f"{pattern!r} has no group (?P<run>...): put one round the run's name."
    except (re.error, RecursionError, OverflowError) as error:
        return f"{pattern!r} is not a regular expression ({error}): correct it."
    if in_force:
        return None
    if len(pattern) > MOST_LETTERS:
        return f"the pattern has {len(pattern)} characters, more than {MOST_LETTERS}: shorten it."
    return _slow(pattern)


def _slow(pattern: str) -> str | None:
    if _VERBOSE.search(pattern):
        return f"{pattern!r} has the flag x: write it without, and without blanks between its signs."
    signs = _SIGN.findall(pattern)
    ways = [0.0]  # of each open group, in bits
    alternatives = [1]
    for place, sign in enumerate(signs):
        least, most = _counts(signs, place + 1)
        if sign.startswith("(") and not sign.endswith(")"):
            ways.append(0.0)
            alternatives.append(1)
        elif sign == ")" and len(ways) > 1:
            inside = ways.pop() + math.log2(alternatives.pop())
            ways[-1] += most * inside + math.log2(most - least + 1)
        elif sign == "|":
            alternatives[-1] += 1
        elif most > least and not _ends_in_one_way(signs, place):
            ways[-1] += math.log2(most - least + 1)
    bits = sum(ways) + sum(map(math.log2, alternatives))
    if bits > MOST_BITS:
        return (
            f"{pattern!r} can match a name in 2 to the power of {bits:.0f} ways, which takes too long: name the "
            "letters between its wildcards, and repeat no group that repeats or has alternatives itself."
        )
    return None


def _counts(signs: list[str], place: int) -> tuple[int, int]:
    """Return how often at least and at most the repeat at `place` takes what is before it; once where none is there."""
    found = _REPEAT.fullmatch(signs[place]) if place < len(signs) else None
    if found is None:
        return 1, 1
    if found["sign"]:
        return int(found["sign"] == "+"), 1 if found["sign"] == "?" else LONGEST_NAME
    least = int(found["least"] or 0)
    most = LONGEST_NAME if found["comma"] and not found["most"] else int(found["most"] or least)
    return min(least, LONGEST_NAME), min(most, LONGEST_NAME)


def _ends_in_one_way(signs: list[str], place: int) -> bool:
    """Whether what follows the repeat of a letter or set shows where it ends: the pattern's end, or another letter."""
    taken = _letters(signs[place])
    after = place + 2
    while after < len(signs) and signs[after] not in ("$", r"\Z"):
        least, most = _counts(signs, after + 1)
        if signs[after] == ")" and (least, most) == (1, 1):
            after += 1
        elif _NO_LETTER.match(signs[after]) or taken & _letters(signs[after]):
            return False
        elif least:
            return True
        else:
            after += 2
    return True


def _letters(sign: str) -> set[str]:
    """Return what a letter or set matches, whether or not letters of either case are one."""
    return {letter for flags in (re.DOTALL, re.DOTALL | re.IGNORECASE) for letter in re.findall(sign, _LETTERS, flags)}
