"""A scene: what is simulated. The robot, its leg and controller, the ground, the drive, the start, and the effects."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace

from data_schema.errors import UsageError, unknown_name
from simulator.declared import GROUNDS, all_parameters, parameters_read, readers
from simulator.effects.registry import EFFECTS
from simulator.scene_rules import RULES

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
    jumps : number of jumps that follow each other
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
        _check_effects(self.effects)
        values = {**_assumed_values(self.effects), **self.values}
        object.__setattr__(self, "values", {name: values[name] for name in _in_order(values)})
        for name, value in self.values.items():
            _check_value(name, value.value)
        _check_jumps(self.jumps, self.effects)
        for name, parameter in parameters_read(self.effects).items():
            if name not in self.values:
                needed = " and ".join(effect for effect in readers(name) if effect in self.effects) or "every scene"
                raise UsageError(
                    f"{name} has no value, and {needed} reads it: give {name} ({parameter.meaning}, {parameter.unit})."
                )
        plain = {name: value.value for name, value in self.values.items()}
        for rule in RULES:
            fault = rule.fault(plain) if rule.effects <= self.effects else None
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


def _check_effects(effects: Collection[str]) -> None:
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


def _check_jumps(jumps: object, effects: Collection[str]) -> None:
    if isinstance(jumps, bool) or not isinstance(jumps, int) or not 1 <= jumps <= MOST_JUMPS:
        raise UsageError(f"jumps = {jumps!r} is not a number of jumps: give a whole number from 1 to {MOST_JUMPS}.")
    if jumps > 1 and "hydrostatic_stiffness" in effects:
        raise UsageError(
            f"jumps = {jumps} on a granular bed, which is levelled after every jump: give jumps = 1, or another ground."
        )


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
