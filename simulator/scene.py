"""A scene: what is simulated. The robot, its leg and controller, the ground, the drive, the start, and the effects.

Also what must hold between the values of a scene, beyond each one's own box.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from data_schema.errors import UsageError, unknown_name
from simulator.declared import GROUNDS, all_parameters, parameters_read, readers
from simulator.effects.registry import EFFECTS
from simulator.parameter import GRAVITY_M_S2, HARD_GROUND_INSETS_M

MOST_JUMPS = 1_000_000


@dataclass(frozen=True, slots=True)
class Value:
    """A parameter's value in SI units, and where it is from.

    It has a source, or `why` says for what it was assumed, or the user of the scene set it, without a reason.
    An assumed value may have been fitted to the runs of a study, which `fitted_to` names.
    """

    value: float
    source: str = ""
    why: str = ""
    set_by_user: bool = False
    fitted_to: str = ""

    @property
    def assumed(self) -> bool:
        """Whether the scene has chosen the value without a source."""
        return not self.source and not self.set_by_user


@dataclass(frozen=True, slots=True)
class Scene:
    """A scene that can be simulated.

    Parameters
    ----------
    name, title : what it is called in lists and above figures
    effects : names of the effects that are on, in any order
    values : parameters by name, in SI units; those of effects that are off may be among them and are not read. One that
        is read and not given has the value that its `Parameter` assumes, where that has one
    jumps : number of jumps that follow each other; on grains each lands on fresh ground
    description : one or more sentences

    Raises
    ------
    UsageError for what cannot be simulated: an unknown effect or parameter, a value that is missing or outside its
    range, an effect without what it needs or beside what it excludes.
    """

    name: str
    title: str
    effects: frozenset[str]
    values: Mapping[str, Value]
    jumps: int = 1
    description: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "effects", frozenset(self.effects))
        _in_order(self.values)
        check_effects(self.effects)
        values = {**_assumed_values(self.effects), **self.values}
        object.__setattr__(self, "values", {name: values[name] for name in _in_order(values)})
        for name, value in self.values.items():
            _check_value(name, value.value)
        _check_jumps(self.jumps)
        check_given(self.effects, self.values)
        plain = {name: value.value for name, value in self.values.items()}
        for rule in RULES:
            fault = rule.fault(plain) if rule.effects <= self.effects and not rule.met(plain) else None
            if fault is not None:
                raise UsageError(fault)

    def __getitem__(self, name: str) -> float:
        """Return a parameter's value; raises `UnknownName` for one the scene does not have."""
        if name not in self.values:
            raise unknown_name("parameter of this scene", name, self.values)
        return self.values[name].value

    @property
    def read(self) -> tuple[str, ...]:
        """Names of the parameters that the effects in force read."""
        return tuple(parameters_read(self.effects))

    @property
    def assumed(self) -> tuple[str, ...]:
        """Names of the parameters that the effects in force read and the scene has chosen without a source."""
        return tuple(name for name in self.read if self.values[name].assumed)

    @property
    def set_by_user(self) -> tuple[str, ...]:
        """Names of the parameters that the effects in force read and that were set by who uses the scene."""
        return tuple(name for name in self.read if self.values[name].set_by_user)

    def changed(
        self,
        values: Mapping[str, float] | None = None,
        effects_on: Iterable[str] = (),
        effects_off: Iterable[str] = (),
        jumps: int | None = None,
    ) -> Scene:
        """Return the scene with other values, effects or number of jumps.

        Parameters
        ----------
        values : parameters in SI units by name; each is marked as set by the user
        effects_on, effects_off : names of effects; one that is on, or off, already may be named again
        jumps : number of jumps that follow each other, None for as many as before

        Raises
        ------
        UnknownName for an effect or parameter that does not exist; UsageError for a value that no effect of the new
        scene reads, and for what cannot be simulated.

        Examples
        --------
        >>> from simulator.scene_file import load_scene
        >>> load_scene("sim2").changed({"b_ad": 100.0}).set_by_user
        ('b_ad',)
        """
        on, off = frozenset(effects_on), frozenset(effects_off)
        for name in sorted(on | off):
            if name not in EFFECTS:
                raise unknown_name("effect", name, EFFECTS)
        if on & off:
            raise UsageError(f"{min(on & off)} is to be both on and off: name it once.")
        effects = (self.effects | on) - off
        given = dict(values or {})
        for name in given:
            _check_read(name, effects)
        new = {name: Value(float(number), set_by_user=True) for name, number in given.items()}
        return replace(
            self, effects=effects, values={**self.values, **new}, jumps=self.jumps if jumps is None else jumps
        )


def _in_order(names: Iterable[str]) -> list[str]:
    known = all_parameters()
    given = frozenset(names)
    for name in sorted(given):
        if name not in known:
            raise unknown_name("parameter", name, known)
    return [name for name in known if name in given]


def _assumed_values(effects: Iterable[str]) -> dict[str, Value]:
    """Return the values that parameters say of themselves, for scenes that give none."""
    read = parameters_read(effects).values()
    return {item.name: Value(item.assumed, why=item.why) for item in read if item.assumed is not None}


def check_effects(effects: Collection[str]) -> None:
    """Raise `UsageError` for effects that are none, or do not go together."""
    for name in sorted(effects):
        if name not in EFFECTS:
            raise unknown_name("effect", name, EFFECTS)
    on = [effect for effect in EFFECTS.values() if effect.name in effects]
    for effect in on:
        for other, sentence in effect.excludes.items():
            if other in effects:
                raise UsageError(f"{effect.name} and {other} cannot be on together, since {sentence}.")
    if not set(GROUNDS) & set(effects):
        raise UsageError(f"a scene without a ground has nothing to jump on: switch one of {', '.join(GROUNDS)} on.")
    for effect in on:
        for alternatives in effect.needs:
            if not set(alternatives) & set(effects):
                raise UsageError(
                    f"{effect.name} needs {' or '.join(alternatives)}, which is off: switch that on too, or "
                    f"{effect.name} off."
                )


def check_given(effects: Collection[str], given: Collection[str]) -> None:
    """Raise `UsageError`, with one sentence, where parameters that the effects read are not among those given."""
    wanted = []
    for name, one in parameters_read(effects).items():
        if name not in given:
            unit = "" if one.unit == "1" else f", {one.unit}"
            read_by = ", ".join(effect for effect in readers(name) if effect in effects) or "every scene"
            wanted.append(f"{name} in [{one.part}] ({one.meaning}{unit}; read by {read_by})")
    if wanted:
        what = "a parameter has" if len(wanted) == 1 else f"{len(wanted)} parameters have"
        raise UsageError(f"{what} no value: give {', '.join(wanted)}.")


def _check_value(name: str, number: object) -> None:
    parameter = all_parameters()[name]
    unit = parameter.unit_text
    allowed = f"{parameter.low:g} to {parameter.high:g}{unit}"
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise UsageError(f"{name} = {number!r} is not a number: give one from {allowed}.")
    if not math.isfinite(number):
        raise UsageError(f"{name} = {number!r} is not a finite number: give one from {allowed}.")
    if not parameter.low <= number <= parameter.high:
        raise UsageError(f"{name} = {number:g}{unit} is outside what can be simulated: give {allowed}.")


def _check_jumps(jumps: object) -> None:
    if isinstance(jumps, bool) or not isinstance(jumps, int) or not 1 <= jumps <= MOST_JUMPS:
        raise UsageError(f"jumps = {jumps!r} is not a number of jumps: give a whole number from 1 to {MOST_JUMPS}.")


def _check_read(name: str, effects: Collection[str]) -> None:
    if name not in all_parameters():
        raise unknown_name("parameter", name, all_parameters())
    if name in parameters_read(effects):
        return
    first, *others = readers(name)
    because, remedy = f"only {first} reads it and is off", "switch it on"
    if others:
        because = f"{', '.join((first, *others[:-1]))} and {others[-1]} read it and are off"
        remedy = "switch one of them on"
    raise UsageError(f"{name} would change nothing, because {because}: {remedy}, or leave {name} out.")


DEEPEST_M = 1.0
"""Depth down to which a granular ground must carry the grains that it adds to the foot."""

Values = Mapping[str, Any]
"""Numbers by name, or arrays of them."""


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule for scenes in which all of `effects` are on, on the parameters that it `reads`.

    Where `met` holds, of numbers or element by element of arrays, it is; elsewhere `fault` gives the sentence, or None
    where it is met after all.
    """

    effects: frozenset[str]
    reads: frozenset[str]
    met: Callable[[Values], Any]
    fault: Callable[[Values], str | None]


def _links(p: Values) -> str:
    return (
        f"upper_link = {p['upper_link']:g} m is not shorter than lower_link = {p['lower_link']:g} m, and such a leg "
        "cannot fold: give a shorter upper_link or a longer lower_link."
    )


def _within_reach(p: Values) -> Any:
    shortest, longest = p["lower_link"] - p["upper_link"], p["lower_link"] + p["upper_link"]
    # 0.1 + 0.2 is a little more than 0.3
    return (shortest * (1.0 + 1e-9) < p["rest_length"]) & (p["rest_length"] < longest * (1.0 - 1e-9))


def _rest_length(p: Values) -> str:
    shortest, longest = p["lower_link"] - p["upper_link"], p["lower_link"] + p["upper_link"]
    return (
        f"rest_length = {p['rest_length']:g} m is out of the leg's reach, which is between {shortest:g} m (folded) and "
        f"{longest:g} m (straight): give a length inside, or other links."
    )


def least_bearing_ratio(p: Values) -> float:
    """Return the least of K(z) / (m_a(z) g) over depths of 0 to 1 m.

    Below 1 the ground would neither hold a foot at rest nor let it sink: both conditions of a jammed foot fail at
    once. While the cone forms, w = V(z) / z is a parabola in z, and so K / z and m_a / z are polynomials; their
    ratio is least at an end or where its derivative's numerator, a quartic, has a root. Once the cone is complete the
    ratio is monotone.
    """
    import numpy as np

    radius, q = p["foot_radius"], p["mu"] / math.tan(p["cone_angle"])
    penetration, stress, recruited = _bearing_factors(p)
    area, complete = math.pi * radius**2, min(radius / q, DEEPEST_M)
    z = np.polynomial.Polynomial([0.0, 1.0])
    w = np.polynomial.Polynomial([area, -math.pi * q * radius, math.pi * q**2 / 3.0])
    resistance = penetration * w + stress * (area + z * w)
    weight = GRAVITY_M_S2 * (recruited * w + p["added_mass_constant"])
    level = resistance.deriv() * weight - resistance * weight.deriv()
    roots: list[float] = np.real(level.roots()).tolist()
    inside = [depth for depth in roots if 0.0 < depth < complete]
    ratios = [float(resistance(depth) / weight(depth)) for depth in (0.0, complete, *inside)]
    volume = complete * float(w(complete))
    deepest = penetration * volume + stress * DEEPEST_M * (area + volume)
    carried = GRAVITY_M_S2 * (recruited * volume + p["added_mass_constant"] * DEEPEST_M)
    return min(*ratios, float(deepest / carried))


def _bearing_factors(p: Values) -> tuple[Any, Any, Any]:
    """Return what multiplies V and z (area + V) in K, and V in m_a."""
    import numpy as np

    penetration = p["kg_scale"] * p["k_sh"] / (math.pi * p["foot_radius"] ** 2)
    return penetration, p["kg_scale"] * p["sigma"] / np.cos(p["cone_angle"]), p["phi"] * p["rho"] * p["mu"]


def _bears_each(p: Values) -> Any:
    """Whether each term of K carries its own of m_a, at any depth."""
    penetration, stress, recruited = _bearing_factors(p)
    area = math.pi * p["foot_radius"] ** 2
    return (penetration >= GRAVITY_M_S2 * recruited) & (stress * area >= GRAVITY_M_S2 * p["added_mass_constant"])


def _bearing(p: Values) -> str | None:
    ratio = least_bearing_ratio(p)
    if ratio >= 1.0:
        return None
    return (
        f"with kg_scale = {p['kg_scale']:g} the ground cannot carry the grains that the foot takes along (K < m_a g): "
        f"give at least kg_scale = {1.001 * p['kg_scale'] / ratio:.4g}, or leave out added_mass."
    )


def _release(p: Values) -> str:
    return (
        f"release_tolerance = {p['release_tolerance']:g} m is less than rest_tolerance = {p['rest_tolerance']:g} m, so "
        "the leg turns soft before the platform sees it stiff and is never released: give at least rest_tolerance."
    )


def _switching(p: Values) -> str:
    return (
        f"rest_tolerance = {p['rest_tolerance']:g} m is not less than switch_compression = "
        f"{p['switch_compression']:g} m, so the leg would turn stiff and soft without end: give a smaller "
        "rest_tolerance."
    )


def _guard(p: Values) -> str:
    longest = p["rest_length"] - p["rest_tolerance"]
    return (
        f"guard_length = {p['guard_length']:g} m is not less than rest_length - rest_tolerance = {longest:g} m, so the "
        "leg would turn stiff and soft without end: give a shorter guard_length."
    )


def _folded_m(p: Values) -> Any:
    return p["lower_link"] - p["upper_link"] + HARD_GROUND_INSETS_M[0]


def _guard_acts(p: Values) -> str:
    folded = _folded_m(p)
    return (
        f"guard_length = {p['guard_length']:g} m never acts, since on this ground the leg counts as folded at "
        f"{folded:g} m: give a longer guard_length, or leave out short_leg_guard."
    )


_GROUND = "foot_radius mu cone_angle kg_scale k_sh sigma phi rho added_mass_constant"


def _rule(effects: str, reads: str, met: Callable[[Values], Any], fault: Callable[[Values], str | None]) -> Rule:
    return Rule(frozenset(effects.split()), frozenset(reads.split()), met, fault)


RULES = (
    _rule("", "upper_link lower_link", lambda p: p["upper_link"] < p["lower_link"], _links),
    _rule("", "upper_link lower_link rest_length", _within_reach, _rest_length),
    _rule("hydrostatic_stiffness added_mass", _GROUND, _bears_each, _bearing),
    _rule(
        "latched_switching",
        "rest_tolerance switch_compression",
        lambda p: p["rest_tolerance"] < p["switch_compression"],
        _switching,
    ),
    _rule(
        "latched_switching short_leg_guard",
        "rest_length rest_tolerance guard_length",
        lambda p: p["guard_length"] < p["rest_length"] - p["rest_tolerance"],
        _guard,
    ),
    _rule(
        "touchdown_impact short_leg_guard",
        "upper_link lower_link guard_length",
        lambda p: p["guard_length"] > _folded_m(p),
        _guard_acts,
    ),
    _rule(
        "emulated_ground latched_switching",
        "release_tolerance rest_tolerance",
        lambda p: p["release_tolerance"] >= p["rest_tolerance"],
        _release,
    ),
)
