"""What the tables of `labbook.toml` must be beyond their types: one with another, and with what labbook knows."""

from __future__ import annotations

import importlib.resources
import zoneinfo
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.vocabulary import ContrastKind, FactorKind
from labbook.config.model import (
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
from labbook.config.reading import Faults, below
from labbook.config.run_names import scheme_fault
from labbook.config.studies import STUDIES

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


def check(configuration: Configuration, given: Mapping[str, Any], faults: Faults) -> None:
    """Add a fault for all that no study can mean; `given` is the TOML, for which keys it has."""
    _check_study(configuration, faults)
    _check_factors(configuration, faults)
    for name, profile in configuration.profiles.items():
        check_profile(profile, below("profiles", name), faults)
    _check_simulation(configuration, faults)
    _check_analysis(configuration, given, faults)
    for name, hypothesis in configuration.hypotheses.items():
        path = below("hypotheses", name)
        needed = _CLAIM_KEYS[hypothesis.claim]
        allowed = (*needed, "levels") if "between" in needed else needed
        if _has_its_keys(path, given["hypotheses"][name], needed, allowed, _CLAIM_KEYS, faults):
            _check_hypothesis(hypothesis, configuration.factors, path, faults)
    for study in configuration.studies:
        if study not in STUDIES:
            faults.append(f"{below('studies', study)}: {unknown_name('study', study, STUDIES)}")
            continue
        for key in given["studies"][study].keys() - set(STUDIES[study].keys):
            faults.append(f"{below('studies', study)}.{key}: {unknown_name('key', key, STUDIES[study].keys)}")


def _check_study(configuration: Configuration, faults: Faults) -> None:
    study, people, checks = configuration.study, configuration.people, configuration.protocol.checks
    try:
        zoneinfo.ZoneInfo(study.time_zone)
    except (zoneinfo.ZoneInfoNotFoundError, ValueError, OSError):  # a folder of zones raises OSError
        known = zoneinfo.available_timezones()
        faults.append(f"study.time_zone: {unknown_name('time zone', study.time_zone, known)}")
    scheme = scheme_fault(study.run_names)
    if scheme is not None:
        faults.append(f"study.run_names: {scheme}")
    for name, initials in people.items():
        if list(people.values()).count(initials) > 1 or (initials in people and initials != name):
            faults.append(
                f"{below('people', name)}: the initials {initials!r} also stand for someone else: choose others."
            )
    _check_once(checks, "protocol.checks", faults)
    for name, robot in configuration.robots.items():
        if robot.leg_min_m >= robot.leg_max_m:
            faults.append(
                f"{below('robots', name)}.leg_min_m: {robot.leg_min_m:g} is not less than leg_max_m: exchange or "
                "correct them."
            )


def _check_once(items: Iterable[object], path: str, faults: Faults) -> None:
    for one, times in Counter(items).items():
        if times > 1:
            faults.append(f"{path}: {str(one)!r} is there {times} times: keep one.")


def _check_factors(configuration: Configuration, faults: Faults) -> None:
    factors = configuration.factors
    folded = Counter(name.casefold() for name in factors)
    for name, factor in factors.items():
        path = below("factors", name)
        if not name.isidentifier() or name.casefold() in RESERVED_NAMES or folded[name.casefold()] > 1:
            faults.append(f"{path}: {name!r} is no name for a factor, or is taken: use other letters, digits and _.")
        labels = list(factor.given_levels)
        if not labels:
            example = "[300, 400]" if factor.kind is FactorKind.NUMBER else '["small", "large"]'
            faults.append(f"{path}.levels: there are none: write for example levels = {example}.")
        _check_once(labels, f"{path}.levels", faults)
        if factor.kind is FactorKind.NUMBER and (
            isinstance(factor.given_levels, dict) or not all(map(_is_number_label, labels))
        ):
            faults.append(f'{path}.levels: not all are numbers: write numbers in square brackets, or kind = "label".')
        elif labels and factor.control is not None:
            _check_levels([factor.control], name, factors, f"{path}.control", faults)
    swept = [name for name, factor in factors.items() if factor.control is not None]
    if len(swept) > 1:
        faults.append(
            f"factors.{swept[1]}.control: [factors.{swept[0]}] names a control already: keep one, for one factor is "
            "swept."
        )
    numbers = [name for name, factor in factors.items() if factor.kind is FactorKind.NUMBER]
    for name, gain in configuration.gains.items():
        if name not in numbers:
            faults.append(f"{below('gains', name)}: {_unknown_factor(name, numbers, FactorKind.NUMBER)}")
        if gain.slope == 0:
            faults.append(f"{below('gains', name)}.slope: 0 makes every gain the same: give another slope.")


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


def _check_factor(name: str, factors: Collection[str], path: str, faults: Faults) -> bool:
    if name not in factors:
        faults.append(f"{path}: {_unknown_factor(name, factors)}")
    return name in factors


def _check_levels(
    labels: Iterable[str], factor: str, factors: Mapping[str, FactorSettings], path: str, faults: Faults
) -> None:
    known = list(factors[factor].given_levels)
    faults += [f"{path}: {unknown_name(f'level of {factor}', label, known)}" for label in labels if label not in known]


def check_profile(profile: ProfileSettings, path: str, faults: Faults) -> None:
    """Add a fault for what a profile, or what is declared of a file, cannot mean."""
    if profile.files is None and not profile.recognise:
        faults.append(
            f"{path}.recognise: names no column: list one or more that only this logger has, or give `files`."
        )
    if profile.time is not None and profile.rate_hz is not None:
        faults.append(f"{path}.rate_hz: stands beside a time column: leave one of the two out.")
    _check_words(profile, path, faults)
    if profile.encoding is not None:
        try:
            if "a1;".encode(profile.encoding) != b"a1;":
                raise LookupError
        except (LookupError, UnicodeError):
            faults.append(
                f"{path}.encoding: {profile.encoding!r} is not known, or does not hold plain letters as bytes: give "
                "for example cp1252 or cp1250."
            )
    if profile.time is not None and profile.time.unit is not None:
        _try(f"{path}.time.unit", faults, check_unit, profile.time.unit, None)
    _check_once((one.channel for one in profile.columns.values() if one.channel), f"{path}.columns", faults)
    for name, column in profile.columns.items():
        _check_column(column, below(f"{path}.columns", name), faults)


def _check_words(profile: ProfileSettings, path: str, faults: Faults) -> None:
    """Check the keys whose words the readers define; their modules are loaded only where such a key stands."""
    if profile.date_format is None and profile.clock_format is None and profile.axes is None:
        return
    from ingest.channels.forces import AXES
    from ingest.timebase.clock_formats import CLOCK_FORMATS, DATE_FORMATS

    for key, given, words in (
        ("date", profile.date_format, DATE_FORMATS),
        ("clock", profile.clock_format, CLOCK_FORMATS),
        ("axes", profile.axes, AXES),
    ):
        if given is not None and given not in words:
            faults.append(f"{path}.{key}: {unknown_name(key, given, words)}")


def _check_column(column: ProfileColumn, path: str, faults: Faults) -> None:
    channel = column.channel
    if channel is not None and not _try(f"{path}.channel", faults, declared_channel, channel):
        return
    if column.unit is not None:
        _try(f"{path}.unit", faults, check_unit, column.unit, channel and declared_channel(channel))
    for place, keys in ((path, column), *((f"{path}.calibrations", each) for each in column.listed)):
        if not _try(place, faults, keys.calibration):
            return
    if column.calibrations and column.unit is None:
        faults.append(f"{path}.unit: is missing: give the unit of the calibrated value.")
    if len(column.calibrations) > max(1, len(column.listed)):
        faults.append(f"{path}.calibrations: stands beside keys of a calibration: list all of them there.")


def _try(path: str, faults: Faults, checked: Any, *given: Any) -> bool:
    """Call a check, and add its refusal to the faults."""
    try:
        checked(*given)
    except (UsageError, InputRefused) as error:
        faults.append(f"{path}: {error}")
        return False
    return True


def _check_simulation(configuration: Configuration, faults: Faults) -> None:
    simulation, factors = configuration.simulation, configuration.factors
    if simulation is None:
        return
    if simulation.scene_toml is None:
        scenes = (importlib.resources.files("simulator") / "scenes").iterdir()
        shipped = [entry.name.removesuffix(".toml") for entry in scenes if entry.name.endswith(".toml")]
        if simulation.scene not in shipped:
            own = "A scene of your own is given by its file, NAME.toml, relative to labbook.toml."
            faults.append(f"simulation.scene: {unknown_name('scene', simulation.scene, shipped, own)}")
    for name in simulation.factors:
        _check_factor(name, factors, below("simulation.factors", name), faults)
    for name, levels in simulation.levels.items():
        path = below("simulation.levels", name)
        if _check_factor(name, factors, path, faults):
            _check_levels(levels, name, factors, path, faults)


def _check_analysis(configuration: Configuration, given: Mapping[str, Any], faults: Faults) -> None:
    analysis = configuration.analysis
    if analysis is None:
        return
    for key, bounds in (
        ("apex_bounds_m", analysis.apex_bounds_m),
        ("apex_bounds_percent", analysis.apex_bounds_percent),
    ):
        if bounds is not None and not bounds[0] < 0.0 < bounds[1]:
            faults.append(
                f"analysis.{key}: {list(bounds)} are no bounds round no difference: write one below 0 and one above."
            )
    if analysis.apex_bounds_m is not None and analysis.apex_bounds_percent is not None:
        faults.append("analysis.apex_bounds_m: stands beside apex_bounds_percent: leave one of the two out.")
    path = "analysis.contrasts"
    for contrast, keys in zip(analysis.contrasts, given["analysis"].get("contrasts", ()), strict=True):
        needed = _CONTRAST_KEYS[contrast.kind]
        allowed = needed if contrast.kind is ContrastKind.LEVELS_OFF else (*needed, "levels")
        if _has_its_keys(path, keys, needed, allowed, _CONTRAST_KEYS, faults):
            _check_contrast(contrast, configuration.factors, path, faults)
    _check_once(analysis.contrasts, path, faults)


def _has_its_keys(
    path: str,
    given: Collection[str],
    needed: Collection[str],
    allowed: Collection[str],
    of_kinds: Mapping[Any, Iterable[str]],
    faults: Faults,
) -> bool:
    """Add a fault for a key that is missing for what is asked, or that belongs to what is not asked."""
    others = {"levels", *(key for keys in of_kinds.values() for key in keys)} - set(allowed)
    missing = [f"{path}.{key}: is missing: give it, or ask something else." for key in needed if key not in given]
    beside = [f"{path}.{key}: {unknown_name('key of what is asked', key, allowed)}" for key in others & set(given)]
    faults += missing + beside
    return not missing and not beside


def _check_contrast(
    contrast: ContrastSettings, factors: Mapping[str, FactorSettings], path: str, faults: Faults
) -> None:
    swept = _swept(factors)
    named = bool(contrast.factor)
    factor = contrast.factor or swept or ""
    if not _check_factor(factor, [name for name in factors if not named or name != swept], f"{path}.factor", faults):
        return
    control = factors[factor].control
    _check_levels(contrast.levels, factor, factors, f"{path}.levels", faults)
    if contrast.kind is ContrastKind.TREND and control in contrast.levels:
        faults.append(f"{path}.levels: {control} is the control, which saves nothing: leave it out.")
    _check_several(contrast.levels, path, faults)
    rises = contrast.kind in (ContrastKind.TREND, ContrastKind.LEVELS_OFF)
    if rises and factors[factor].kind is not FactorKind.NUMBER:
        faults.append(f"{path}.kind: the levels of {factor} are no numbers, so nothing rises with them: compare them.")


def _check_several(levels: Collection[str], path: str, faults: Faults) -> None:
    if len(set(levels)) == 1:
        (one, *_) = levels
        faults.append(f"{path}.levels: {one} alone is compared with nothing: name two or more, or leave levels out.")


def _check_hypothesis(
    found: HypothesisSettings, factors: Mapping[str, FactorSettings], path: str, faults: Faults
) -> None:
    """Add a fault for a hypothesis that no runs of these factors could test."""
    swept = _swept(factors)
    saves = found.claim not in (ClaimKind.SAME, ClaimKind.NOT_LOWER)
    if saves and not found.outcome.has_savings:
        saved = [outcome.key for outcome in type(found.outcome) if outcome.has_savings]
        faults.append(f"{path}.outcome: {unknown_name('outcome of a saving', found.outcome.key, saved)}")
    if found.between and _check_factor(found.between, factors, f"{path}.between", faults):
        control = factors[found.between].control
        _check_levels(found.levels, found.between, factors, f"{path}.levels", faults)
        _check_several(found.levels, path, faults)
        if found.between == swept and found.side is Side.CONTROL:
            faults.append(
                f"{path}.side: the control has one level of {swept}: compare another factor, or the treated side."
            )
        elif found.between == swept and control in found.levels:
            faults.append(f"{path}.levels: {control} is the control, which is not on the treated side: leave it out.")
    for name, label in found.group.items():
        if _check_factor(name, factors, f"{path}.group", faults):
            _check_levels([label], name, factors, f"{path}.group.{name}", faults)
    others = [name for name in factors if name != swept]
    if swept is not None and found.group and set(found.group) != set(others):
        faults.append(f"{path}.group: a group has one level of each of {', '.join(others)}: name just these.")


def _swept(factors: Mapping[str, FactorSettings]) -> str | None:
    """Return the factor that has a control."""
    return next((name for name, factor in factors.items() if factor.control is not None), None)
