"""Read `labbook.toml`: the study, its people, factors, protocol, equipment and column profiles.

The file is a proposal; what is in force is in the book, and every command compares the two. A key that is not known
is refused, because a typing error must not become a default. The faults of a file are reported together.

A scene of one's own: `[simulation]` names its file, relative to the book. A configuration is stored with the file's
text below its own, under `[scene_files]`, so that each prediction can be made again from the journal alone.

Also what its tables must be beyond their types, one with another and with what labbook knows; the file that
`labbook init` writes; and which of its settings the numbers of a report depend on.
"""

from __future__ import annotations

import hashlib
import importlib.resources
import json
import tomllib
import zoneinfo
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec

from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.vocabulary import ContrastKind, FactorKind
from labbook.config.model import (
    AnalysisSettings,
    ClaimKind,
    Configuration,
    ContrastSettings,
    FactorSettings,
    HypothesisSettings,
    ProfileColumn,
    ProfileSettings,
    Side,
    number_label,
)
from labbook.config.profiles import check_unit, declared_channel
from labbook.config.reading import Faults, below, is_plain, read_model
from labbook.config.run_names import scheme_fault
from labbook.config.studies import STUDIES

__all__ = ["Configuration", "parse_configuration", "template"]

_SCENE_FILES = "scene_files"


def parse_configuration(text: str, source: str, folder: Path | None = None) -> Configuration:
    """Read a configuration; `source` names the file in messages.

    `folder`: where the file of a scene of one's own is looked for; None for a text that is stored with it.
    Raises `InputRefused` with one sentence a fault.
    """
    given = _toml(text, source)
    faults: Faults = []
    stored = given.pop(_SCENE_FILES, {}) if folder is None else {}
    simulation = given.get("simulation")
    scene = simulation.get("scene") if isinstance(simulation, dict) else None
    scene_toml = None
    if isinstance(scene, str) and scene.endswith(".toml"):
        scene_toml = stored.get(scene) if folder is None else _scene_file(folder / scene, scene, faults)
        if folder is None and scene_toml is None:
            faults.append(
                f"simulation.scene: the text of {scene} is not kept with it: put that under [{_SCENE_FILES}]."
            )
        elif folder is not None and scene_toml is not None:
            text += _scene_below(scene, scene_toml)
    configuration = read_model(Configuration, given, faults)
    if configuration is not None:
        simulation = configuration.simulation and replace(configuration.simulation, scene_toml=scene_toml)
        hypotheses = {name: replace(one, name=name) for name, one in configuration.hypotheses.items()}
        configuration = replace(configuration, simulation=simulation, hypotheses=hypotheses, text=text)
        faults += check(configuration, given)
    if configuration is None or faults:
        if len(faults) == 1:
            raise InputRefused(f"{source}: {faults[0]}")
        listed = "".join(f"\n  {fault}" for fault in faults)
        raise InputRefused(f"{source} has {len(faults)} faults, correct each of them and try again:{listed}")
    return configuration


def _scene_below(scene: str, scene_toml: str) -> str:
    """Return what stands below a file's text where it is stored with its scene."""
    return f"\n\n[{_SCENE_FILES}]\n{_quoted(scene)} = {_quoted(scene_toml)}\n"


def own_text(configuration: Configuration) -> str:
    """Return the text of labbook.toml alone, without that of a scene of one's own that is stored below it."""
    simulation = configuration.simulation
    if simulation is None or simulation.scene_toml is None:
        return configuration.text
    return configuration.text.removesuffix(_scene_below(simulation.scene, simulation.scene_toml))


def _toml(text: str, source: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise InputRefused(f"{source} has brackets too deep inside each other: write it flatter.") from error
    except ValueError as error:  # also numbers of thousands of digits
        raise InputRefused(f"{source} is not TOML, {error}: correct that place and try again.") from error


def _scene_file(path: Path, name: str, faults: Faults) -> str | None:
    try:
        return path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        faults.append(f"simulation.scene: {name} is not text in UTF-8: save it as such.")
    except OSError as error:
        message = error.strerror or str(error)
        faults.append(
            f"simulation.scene: {path} cannot be read ({message}): put the scene there, or name one that is shipped."
        )
    return None


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


RESERVED_NAMES = frozenset(
    {
        *("run", "date", "day", "position", "kind", "state", "battery", "robot", "started", "duration_s"),
        *("jumps_made", "starts", "note", "study", "levels", "and", "or", "not", "in"),
    }
)
"""Names that mean something else in a run sheet or in `--where`, so that no factor can have them."""

_CONTRAST_KEYS: Mapping[ContrastKind, tuple[str, ...]] = {
    ContrastKind.DIFFERENCE: ("factor", "side"),
    ContrastKind.INTERACTION: ("factor",),
    ContrastKind.TREND: (),
    ContrastKind.LEVELS_OFF: ("at",),
}
_CLAIM_KEYS: Mapping[ClaimKind, tuple[str, ...]] = {
    ClaimKind.SAME: ("between", "side", "within_percent"),
    ClaimKind.NOT_LOWER: ("within_percent",),
    ClaimKind.SAVES: (),
    ClaimKind.LARGEST_SAVING: ("group",),
    ClaimKind.SMALLEST_SAVING: ("group",),
}
"""The keys that a contrast or a claim needs, and that no other has."""


def check(configuration: Configuration, given: Mapping[str, Any]) -> Iterator[str]:
    """Give a fault for all that no study can mean; `given` is the TOML, for which keys it has."""
    yield from _check_study(configuration)
    yield from _check_factors(configuration)
    for name, profile in configuration.profiles.items():
        yield from check_profile(profile, below("profiles", name))
    yield from _check_simulation(configuration)
    yield from _check_analysis(configuration, given)
    for name, hypothesis in configuration.hypotheses.items():
        path = below("hypotheses", name)
        needed = _CLAIM_KEYS[hypothesis.claim]
        allowed = (*needed, "levels") if "between" in needed else needed
        other = _other_keys(path, given["hypotheses"][name], needed, allowed, _CLAIM_KEYS)
        yield from other or _check_hypothesis(hypothesis, configuration.factors, path)
    for study in configuration.studies:
        if study not in STUDIES:
            yield f"{below('studies', study)}: {unknown_name('study', study, STUDIES)}"
            continue
        for key in given["studies"][study].keys() - set(STUDIES[study].keys):
            yield f"{below('studies', study)}.{key}: {unknown_name('key', key, STUDIES[study].keys)}"


def _check_study(configuration: Configuration) -> Iterator[str]:
    study, people, protocol = configuration.study, configuration.people, configuration.protocol
    try:
        zoneinfo.ZoneInfo(study.time_zone)
    except (zoneinfo.ZoneInfoNotFoundError, ValueError, OSError):  # a folder of zones raises OSError
        known = zoneinfo.available_timezones()
        yield f"study.time_zone: {unknown_name('time zone', study.time_zone, known)}"
    scheme = scheme_fault(study.run_names)
    if scheme is not None:
        yield f"study.run_names: {scheme}"
    for name, initials in people.items():
        if list(people.values()).count(initials) > 1 or (initials in people and initials != name):
            yield f"{below('people', name)}: the initials {initials!r} also stand for someone else: choose others."
    yield from _check_once(protocol.checks, "protocol.checks")
    yield from _check_once(protocol.reject_reasons, "protocol.reject_reasons")
    yield from _check_once(configuration.privacy.leave_out, "privacy.leave_out")
    for name, robot in configuration.robots.items():
        if robot.leg_min_m >= robot.leg_max_m:
            yield (
                f"{below('robots', name)}.leg_min_m: {robot.leg_min_m:g} is not less than leg_max_m: exchange or "
                "correct them."
            )


def _check_once(items: Iterable[object], path: str) -> Iterator[str]:
    for one, times in Counter(items).items():
        if times > 1:
            yield f"{path}: {str(one)!r} is there {times} times: keep one."


def _check_factors(configuration: Configuration) -> Iterator[str]:
    factors = configuration.factors
    folded = Counter(name.casefold() for name in factors)
    for name, factor in factors.items():
        path = below("factors", name)
        if not name.isidentifier() or name.casefold() in RESERVED_NAMES or folded[name.casefold()] > 1:
            yield f"{path}: {name!r} is no name for a factor, or is taken: use other letters, digits and _."
        labels = list(factor.given_levels)
        if not labels:
            example = "[300, 400]" if factor.kind is FactorKind.NUMBER else '["small", "large"]'
            yield f"{path}.levels: there are none: write for example levels = {example}."
        yield from _check_once(labels, f"{path}.levels")
        if factor.kind is FactorKind.NUMBER and (
            isinstance(factor.given_levels, dict) or not all(map(_is_number_label, labels))
        ):
            yield f'{path}.levels: not all are numbers: write numbers in square brackets, or kind = "label".'
        elif labels and factor.control is not None:
            yield from _check_levels([factor.control], name, factors, f"{path}.control")
    swept = [name for name, factor in factors.items() if factor.control is not None]
    if len(swept) > 1:
        yield (
            f"factors.{swept[1]}.control: [factors.{swept[0]}] names a control already: keep one, for one factor is "
            "swept."
        )
    numbers = [name for name, factor in factors.items() if factor.kind is FactorKind.NUMBER]
    for name, gain in configuration.gains.items():
        if name not in numbers:
            yield f"{below('gains', name)}: {_unknown_factor(name, numbers, FactorKind.NUMBER)}"
        if gain.slope == 0:
            yield f"{below('gains', name)}.slope: 0 makes every gain the same: give another slope."


def _is_number_label(label: str) -> bool:
    try:
        return number_label(float(label)) == label
    except ValueError:
        return False


def _unknown_factor(name: str, factors: Iterable[str], kind: FactorKind | None = None) -> str:
    """Return the sentence for a factor that is none of `factors`, of some kind, with the section to write."""
    of_kind, keys = ("", "kind") if kind is None else (f" of kind {kind}", f'kind = "{kind}"')
    known = list(factors)
    remedy = f"{'Or write' if known else 'Write'} [factors.{name}] with {keys} and levels."
    return str(unknown_name(f"factor{of_kind}", name, known, remedy))


def _check_factor(name: str, factors: Collection[str], path: str) -> Faults:
    return [] if name in factors else [f"{path}: {_unknown_factor(name, factors)}"]


def _check_levels(labels: Iterable[str], factor: str, factors: Mapping[str, FactorSettings], path: str) -> Faults:
    known = list(factors[factor].given_levels)
    return [f"{path}: {unknown_name(f'level of {factor}', label, known)}" for label in labels if label not in known]


def check_profile(profile: ProfileSettings, path: str) -> Iterator[str]:
    """Give a fault for what a profile, or what is declared of a file, cannot mean."""
    if profile.files is None and not profile.recognise:
        yield f"{path}.recognise: names no column: list one or more that only this logger has, or give `files`."
    if profile.time is not None and profile.rate_hz is not None:
        yield f"{path}.rate_hz: stands beside a time column: leave one of the two out."
    yield from _check_words(profile, path)
    if profile.encoding is not None:
        try:
            if "a1;".encode(profile.encoding) != b"a1;":
                raise LookupError
        except (LookupError, UnicodeError):
            yield (
                f"{path}.encoding: {profile.encoding!r} is not known, or does not hold plain letters as bytes: give "
                "for example cp1252 or cp1250."
            )
    if profile.time is not None and profile.time.unit is not None:
        yield from _refusal(f"{path}.time.unit", check_unit, profile.time.unit, None)
    yield from _check_once((one.channel for one in profile.columns.values() if one.channel), f"{path}.columns")
    for name, column in profile.columns.items():
        yield from _check_column(column, below(f"{path}.columns", name))


def _check_words(profile: ProfileSettings, path: str) -> Iterator[str]:
    """Check the keys whose words the readers define; their modules are loaded only where such a key stands."""
    if profile.date_format is None and profile.clock_format is None and profile.axes is None:
        return
    from ingest.channels.forces import AXES
    from ingest.timebase.clock import CLOCK_FORMATS, DATE_FORMATS

    for key, given, words in (
        ("date", profile.date_format, DATE_FORMATS),
        ("clock", profile.clock_format, CLOCK_FORMATS),
        ("axes", profile.axes, AXES),
    ):
        if given is not None and given not in words:
            yield f"{path}.{key}: {unknown_name(key, given, words)}"


def _check_column(column: ProfileColumn, path: str) -> Iterator[str]:
    channel = column.channel
    if channel is not None and (unknown := _refusal(f"{path}.channel", declared_channel, channel)):
        yield from unknown
        return
    if column.unit is not None:
        yield from _refusal(f"{path}.unit", check_unit, column.unit, channel and declared_channel(channel))
    for place, keys in ((path, column), *((f"{path}.calibrations", each) for each in column.listed)):
        if refused := _refusal(place, keys.calibration):
            yield from refused
            return
    if column.calibrations and column.unit is None:
        yield f"{path}.unit: is missing: give the unit of the calibrated value."
    if len(column.calibrations) > max(1, len(column.listed)):
        yield f"{path}.calibrations: stands beside keys of a calibration: list all of them there."


def _refusal(path: str, checked: Any, *given: Any) -> Faults:
    """Call a check, and return what it refuses."""
    try:
        checked(*given)
    except (UsageError, InputRefused) as error:
        return [f"{path}: {error}"]
    return []


def _check_simulation(configuration: Configuration) -> Iterator[str]:
    simulation, factors = configuration.simulation, configuration.factors
    if simulation is None:
        return
    if simulation.scene_toml is None:
        scenes = (importlib.resources.files("simulator") / "scenes").iterdir()
        shipped = [entry.name.removesuffix(".toml") for entry in scenes if entry.name.endswith(".toml")]
        if simulation.scene not in shipped:
            own = "A scene of your own is given by its file, NAME.toml, relative to labbook.toml."
            yield f"simulation.scene: {unknown_name('scene', simulation.scene, shipped, own)}"
    for name in simulation.factors:
        yield from _check_factor(name, factors, below("simulation.factors", name))
    for name, levels in simulation.levels.items():
        path = below("simulation.levels", name)
        yield from _check_factor(name, factors, path) or _check_levels(levels, name, factors, path)


def _check_analysis(configuration: Configuration, given: Mapping[str, Any]) -> Iterator[str]:
    analysis = configuration.analysis
    if analysis is None:
        return
    for key, bounds in (
        ("apex_bounds_m", analysis.apex_bounds_m),
        ("apex_bounds_percent", analysis.apex_bounds_percent),
    ):
        if bounds is not None and not bounds[0] < 0.0 < bounds[1]:
            yield (
                f"analysis.{key}: {list(bounds)} are no bounds round no difference: write one below 0 and one above."
            )
    if analysis.apex_bounds_m is not None and analysis.apex_bounds_percent is not None:
        yield "analysis.apex_bounds_m: stands beside apex_bounds_percent: leave one of the two out."
    path = "analysis.contrasts"
    for contrast, keys in zip(analysis.contrasts, given["analysis"].get("contrasts", ()), strict=True):
        needed = _CONTRAST_KEYS[contrast.kind]
        allowed = needed if contrast.kind is ContrastKind.LEVELS_OFF else (*needed, "levels")
        other = _other_keys(path, keys, needed, allowed, _CONTRAST_KEYS)
        yield from other or _check_contrast(contrast, configuration.factors, path)
    yield from _check_once(analysis.contrasts, path)


def _other_keys(
    path: str,
    given: Collection[str],
    needed: Collection[str],
    allowed: Collection[str],
    of_kinds: Mapping[Any, Iterable[str]],
) -> Faults:
    """Return a fault for a key that is missing for what is asked, or that belongs to what is not asked."""
    others = {"levels", *(key for keys in of_kinds.values() for key in keys)} - set(allowed)
    missing = [f"{path}.{key}: is missing: give it, or ask something else." for key in needed if key not in given]
    return missing + [
        f"{path}.{key}: {unknown_name('key of what is asked', key, allowed)}" for key in others & set(given)
    ]


def _check_contrast(contrast: ContrastSettings, factors: Mapping[str, FactorSettings], path: str) -> Iterator[str]:
    swept = _swept(factors)
    named = bool(contrast.factor)
    factor = contrast.factor or swept or ""
    others = [name for name in factors if not named or name != swept]
    if unknown := _check_factor(factor, others, f"{path}.factor"):
        yield from unknown
        return
    control = factors[factor].control
    yield from _check_levels(contrast.levels, factor, factors, f"{path}.levels")
    if contrast.kind is ContrastKind.TREND and control in contrast.levels:
        yield f"{path}.levels: {control} is the control, which saves nothing: leave it out."
    yield from _check_several(contrast.levels, path)
    rises = contrast.kind in (ContrastKind.TREND, ContrastKind.LEVELS_OFF)
    if rises and factors[factor].kind is not FactorKind.NUMBER:
        yield f"{path}.kind: the levels of {factor} are no numbers, so nothing rises with them: compare them."


def _check_several(levels: Collection[str], path: str) -> Iterator[str]:
    if len(set(levels)) == 1:
        (one, *_) = levels
        yield f"{path}.levels: {one} alone is compared with nothing: name two or more, or leave levels out."


def _check_hypothesis(found: HypothesisSettings, factors: Mapping[str, FactorSettings], path: str) -> Iterator[str]:
    """Give a fault for a hypothesis that no runs of these factors could test."""
    swept = _swept(factors)
    saves = found.claim not in (ClaimKind.SAME, ClaimKind.NOT_LOWER)
    if saves and not found.outcome.has_savings:
        saved = [outcome.key for outcome in type(found.outcome) if outcome.has_savings]
        yield f"{path}.outcome: {unknown_name('outcome of a saving', found.outcome.key, saved)}"
    if found.between and (unknown := _check_factor(found.between, factors, f"{path}.between")):
        yield from unknown
    elif found.between:
        control = factors[found.between].control
        yield from _check_levels(found.levels, found.between, factors, f"{path}.levels")
        yield from _check_several(found.levels, path)
        if found.between == swept and found.side is Side.CONTROL:
            yield f"{path}.side: the control has one level of {swept}: compare another factor, or the treated side."
        elif found.between == swept and control in found.levels:
            yield f"{path}.levels: {control} is the control, which is not on the treated side: leave it out."
    for name, label in found.group.items():
        yield from _check_factor(name, factors, f"{path}.group") or _check_levels(
            [label], name, factors, f"{path}.group.{name}"
        )
    others = [name for name in factors if name != swept]
    if swept is not None and found.group and set(found.group) != set(others):
        yield f"{path}.group: a group has one level of each of {', '.join(others)}: name just these."


def _swept(factors: Mapping[str, FactorSettings]) -> str | None:
    """Return the factor that has a control."""
    return next((name for name, factor in factors.items() if factor.control is not None), None)


_TEMPLATE = """\
# The configuration of this book. Lines that start with "# " explain; lines that start with "#" and no space are
# examples: take the # away and put your own in. A key that labbook does not know is refused, with the nearest one.

[study]
name = NAME
# bed, emulator, force_plate or field
kind = "bed"
# Joules are charge times this voltage: the packs' storage voltage where they are recharged to that (4 x 3.85 V).
reference_voltage_v = 15.4
# How many jumps a run has by protocol.
jumps_nominal = 25
# Days and clock times are local to this zone, for example "America/New_York".
time_zone = ZONE
# How runs are called: the number in braces, of three digits. LOG{:04d} is LOG0001; a file belongs to the run that its
# name states.
run_names = "r{:03d}"

[people]
# Who may speak in this book: name = initials.
PERSON = INITIALS

# What is varied between runs. The level named as control makes a condition a control; without one, nothing can be
# compared: name it before the first run is made.
#[factors.foot]
#kind = "label"
#levels = { small = { radius_m = 0.038 }, large = { radius_m = 0.051 } }

#[factors.k_gain]
#kind = "number"
#title = "extension stiffness"
#levels = [300, 400]

#[factors.b_ad_gain]
#kind = "number"
#title = "active-damping coefficient"
#levels = [0, 50, 100, 150, 200, 250]
#control = 0
# What the control is called in text, and the other levels together; without these, by their labels.
#control_name = "CE"
#treatment = "active damping"

[protocol]
# Power on to power off, where all runs of jumps last as long.
#run_duration_s = 720
# robust, or published: the one of the thesis.
detector = "robust"
exclude_first_jumps = 0
# Leave out jumps with a dropped packet in flight.
exclude_gap_jumps = true
# By which published rules a single jump begins and leaves a force plate (docs/your-own-data.md has others).
onset = "5sd_back_30ms"
take_off = "flight_5sd"
# The step of the charger's mAh, where the charges themselves do not show it.
#charger_resolution_mah = 1
# Runs without jumps, from which the passive drain is fitted.
idle_minutes = [20, 24, 30, 40, 50, 60]
# What is looked at before a day's first run: `labbook today` asks for each.
#checks = ["rail_angle", "lubrication", "battery_conditioned", "sensor_zero"]
# For which reasons the page offers to reject a jump, in this order; "other", with a note, is always the last.
#reject_reasons = ["touched_by_hand", "misfire", "sensor_fault", "wrong_apex", "dropped_packet"]

# What a gain means: physical value = slope * gain + offset; at the gain zero, nothing is applied.
#[gains.k_gain]
#symbol = "k"
#slope = 2.56
#offset = 67.36
#unit = "N/m"

#[gains.b_ad_gain]
#symbol = "d"
#slope = 3.32
#offset = 19.67
#unit = "kg/s"
#zero = 0

# Robots and packs that runs are made with, weighed and measured before the first run: files are compared with them.
#[robots.hopper]
#body_mass_kg = 1.8
#foot_mass_kg = 0.2
#link_1_m = 0.1
#link_2_m = 0.2
#rest_length_m = 0.27
#leg_min_m = 0.1
#leg_max_m = 0.3

#[batteries.A]
#cells = 4
#capacity_mah = 6600

#[instruments.charger]
#kind = "charger"
#make = "Junsi"
#model = "iCharger 406 Duo"
#serial = "0001"

# What one file may ask for at most, so that a damaged or hostile one cannot fill memory or disk.
#[files.limits]
#largest_file_bytes = 8589934592
#most_columns = 4096
#longest_line_bytes = 1048576
#largest_expanded_bytes = 2147483648
#largest_expansion = 200
#most_members = 200
#deepest_nesting = 2
#most_cells = 20000000

# What is decided about the analysis before the first run: the book keeps it, and the report calls exploratory whatever
# departs from it. Comparisons of the primary outcome are corrected over the family: each (level against the control) or
# pooled. Apexes within the bounds count as no loss of height. exclusions: for which reasons jumps may be left out.
# alternative "one-sided" asks only whether there is a saving, of the claims and of hypotheses alike.
#[analysis]
#primary_outcome = "joules"
#family = "pooled"
#alpha = 0.05
#alternative = "two-sided"
#apex_bounds_percent = [-3, 3]
#exclusions = ["touched_by_hand", "misfire", "sensor_fault", "wrong_apex", "dropped_packet"]
#contrasts = [{ kind = "trend" }]

# What the simulator predicts each condition with: the report shows it beside what was measured. `factors` says which
# parameter a factor's physical value is; parameters without a source are varied by this part, for the error. A scene of
# your own is a file beside this one: scene = "own.toml".
#[simulation]
#scene = "bed"
#varied_by = 0.1
#factors = { foot = "foot_radius", k_gain = "k_extension", b_ad_gain = "b_ad" }

# What you expect: `labbook compare` and the report say whether it holds (docs/hypotheses.md).
#[hypotheses.foot_of_control]
#text = "A jump of the control costs the same with either foot"
#claim = "same"
#side = "control"
#between = "foot"
#within_percent = 10

# What the thesis's studies are asked with, where the command line does not say it (docs/studies.md).
#[studies.compaction]
#grain_mm = 3.4

# Any logger, without programming: recognise lists columns that only its files have. Without a time column, leave the
# line "time" out and write rate_hz = 300.
#[profiles.serial_logger]
#recognise = ["time", "leftEncoder"]
#time = { column = "time", unit = "ms" }
#columns = { leftEncoder = { channel = "own.left_encoder", unit = "1" }, h = { channel = "body_height", unit = "mm" } }

# A database that several people share, and the folder that they all reach.
#[database]
#url = "postgresql+psycopg://labbook@server/labbook"

#[store]
#path = "/mnt/lab/mybook"

# Under which licence others may use what is shared, an SPDX identifier or an address: a capsule states it.
#[sharing]
#license = "CC-BY-4.0"

# What a capsule --for-sharing leaves out: names (initials stand for them), texts of notes, paths of files.
#[privacy]
#leave_out = ["people", "notes", "paths"]
"""


def template(name: str, person: str, initials: str | None = None, time_zone: str = "UTC") -> str:
    """Write the configuration of a new book, ready to be read; `initials` default to the first letters of `person`.

    A name that cannot stand in a configuration (an odd folder's) becomes "study". Raises `UsageError` for a person
    whose name cannot.
    """
    if not is_plain(person):
        raise UsageError(f"{person!r} is not a name to sign with: give one such as --as 'Ada Nwosu'.")
    values = {
        "NAME": name if is_plain(name) else "study",
        "ZONE": time_zone,
        "PERSON": person,
        "INITIALS": initials or "".join(word[0] for word in person.split()).upper(),
    }
    lines = []
    for line in _TEMPLATE.split("\n"):
        words = [json.dumps(values[word], ensure_ascii=False) if word in values else word for word in line.split(" ")]
        lines.append(" ".join(words))
    return "\n".join(lines)


_TABLES = ("study", "factors", "protocol", "gains", "robots", "batteries", "simulation", "analysis", "hypotheses")
_NO_NUMBER = frozenset(
    {
        *("name", "title", "control_name", "treatment", "symbol", "text", "source", "published"),
        *("run_names", "checks", "idle_minutes", "reject_reasons"),
    }
)
"""Keys that no number rests on."""


def settings_of_numbers(configuration: Configuration) -> dict[str, Any]:
    """Return the settings that numbers rest on, `analysis.alpha` and the like, as JSON has them; defaults filled in.

    Of a scene of one's own it is the hash.
    """
    whole = replace(configuration, analysis=configuration.analysis or AnalysisSettings())
    tables = msgspec.json.decode(msgspec.json.encode(whole))
    found = dict(_flat({name: tables[name] for name in _TABLES}, ""))
    scene = found.get("simulation.scene_toml")
    if scene is not None:
        found["simulation.scene_toml"] = hashlib.sha256(scene.encode()).hexdigest()[:12]
    return found


def _flat(table: dict[str, Any], path: str) -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        name = f"{path}.{key}".lstrip(".")
        if isinstance(value, dict):
            yield from _flat(value, name)
        elif key not in _NO_NUMBER:
            yield name, value
