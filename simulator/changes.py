"""A scene changed by words, as a command line gives them: `--set name=value` and `--effects +drag,-added_mass`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from data_schema.errors import UsageError, nearest, unknown_name
from simulator.declared import all_parameters
from simulator.effects.registry import EFFECTS
from simulator.gains import active_damping_kg_m, fitted_active_damping_kg_m, stiffness_n_m
from simulator.scene import Scene

_BUT = ", but with "
"""Between a scene's title and the words that changed the scene."""

FLIGHT_EFFECTS = {"held": "held_gains_in_flight", "massless": "massless_leg_in_flight"}
"""Words for the leg in flight, beside `soft`, which is neither of these effects."""

CONTACT_EFFECT, CONTACTS = "contact_once_risen", ("once_risen", "at_the_print")
"""The effect that decides when a lifted foot meets the ground again, and words for with it and without."""


@dataclass(frozen=True, slots=True)
class Change:
    """What one word changes: parameters' values, effects, the number of jumps; `drop_height_m` waits for the rest.

    `choice` names what the effects are switched for.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    on: frozenset[str] = frozenset()
    off: frozenset[str] = frozenset()
    choice: str = ""
    jumps: int | None = None
    drop_height_m: float | None = None

    @property
    def subjects(self) -> tuple[str, ...]:
        """What is changed; no two words may change the same."""
        others = {
            self.choice: bool(self.choice),
            "jumps": self.jumps is not None,
            "initial_height": self.drop_height_m is not None,
        }
        return (*self.values, *(name for name, is_changed in others.items() if is_changed))


def changed_by_words(scene: Scene, sets: Sequence[str] = (), effects: str | None = None) -> Scene:
    """Return the scene changed by the words of `labbook sim run`; its title lists them.

    Parameters
    ----------
    sets : `name=value` each, a parameter in SI units or a word such as `drop_height`, as `--set` takes them
    effects : `+name,-name`, as `--effects` takes them

    Raises
    ------
    UnknownName for a name that does not exist; UsageError for words that have no meaning, name the same thing twice, or
    lead to what cannot be simulated.

    Examples
    --------
    >>> from simulator.scene_file import load_scene
    >>> changed_by_words(load_scene("sim2"), ["b_ad=100"], "+passive_draw")["b_ad"]
    100.0
    """
    on, off = _effects(effects)
    values: dict[str, float] = {}
    word_of: dict[str, str] = {}
    jumps, drop_height_m = None, None
    for word in sets:
        change = _change(word, (scene.effects | on) - off)
        for subject in change.subjects:
            if subject in word_of:
                raise UsageError(f"{word_of[subject]} and {word} both set {subject}: leave one of them out.")
            word_of[subject] = word
        values |= change.values
        on, off = on | change.on, off | change.off
        jumps = jumps if change.jumps is None else change.jumps
        drop_height_m = drop_height_m if change.drop_height_m is None else change.drop_height_m
    if drop_height_m is not None:
        rest_length_m = values.get("rest_length", scene["rest_length"])
        if drop_height_m < rest_length_m:
            raise UsageError(
                f"drop_height={drop_height_m:g} starts with the foot in the ground: give the body's height above the "
                f"surface, at least the leg's rest length of {rest_length_m:g} m."
            )
        values["initial_height"] = drop_height_m - rest_length_m
    changed = scene.changed(values, on, off, jumps)
    if changed == scene:
        return scene
    return with_changes_in_title(
        changed, [word.strip() for word in (*sets, *(effects or "").split(",")) if word.strip()]
    )


def with_changes_in_title(scene: Scene, words: Sequence[str]) -> Scene:
    """Return a changed scene with the words that changed it in its title, which is that of the scene it was."""
    return replace(scene, title=f"{scene.title}{', ' if _BUT in scene.title else _BUT}{', '.join(words)}")


def _change(word: str, effects: frozenset[str]) -> Change:
    name, equals, value = (part.strip() for part in word.partition("="))
    if not name or not equals or not value:
        raise UsageError(f"--set {word!r} is not NAME=VALUE: write for example --set foot_radius=0.038.")
    if name in WORDS:
        return WORDS[name](value, effects)
    if name in all_parameters():
        return Change({name: _number(name, value)})
    if name in EFFECTS:
        raise UsageError(f"{name} is an effect, not a parameter: switch it with --effects +{name} or -{name}.")
    raise unknown_name("parameter", name, (*all_parameters(), *WORDS))


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        unit = all_parameters()[name].unit if name in all_parameters() else "1"
        of = "" if unit == "1" else f" in {unit}"
        raise UsageError(f"{name}={text} is not a number: give a plain one{of}, without its unit.") from error


def _flight(value: str, _effects: frozenset[str]) -> Change:
    every = frozenset(FLIGHT_EFFECTS.values())
    choice = "the leg in flight"
    if value == "soft":
        return Change(off=every, choice=choice)
    if value not in FLIGHT_EFFECTS:
        raise unknown_name("leg in flight", value, ("soft", *FLIGHT_EFFECTS))
    return Change(on=frozenset({FLIGHT_EFFECTS[value]}), off=every - {FLIGHT_EFFECTS[value]}, choice=choice)


def _contact(value: str, effects: frozenset[str]) -> Change:
    if "hydrostatic_stiffness" not in effects:
        raise UsageError(f"contact={value} says when a lifted foot meets grains again: leave it out on other grounds.")
    rule = frozenset({CONTACT_EFFECT})
    if value not in CONTACTS:
        raise unknown_name("contact after lift-off", value, CONTACTS)
    once_risen = value == CONTACTS[0]
    return Change(on=rule if once_risen else frozenset(), off=frozenset() if once_risen else rule, choice="contact")


def _jumps(value: str, _effects: frozenset[str]) -> Change:
    try:
        return Change(jumps=int(value))
    except ValueError as error:
        raise UsageError(f"jumps={value} is not a whole number: give for example jumps=4.") from error


def _gain(value: str, _effects: frozenset[str]) -> Change:
    return Change({"k_extension": stiffness_n_m(_number("gain", value))})


def _damping_gain(value: str, effects: frozenset[str]) -> Change:
    of_gain = active_damping_kg_m if "emulated_ground" in effects else fitted_active_damping_kg_m
    return Change({"b_ad": of_gain(_number("damping_gain", value))})


def _drop_height(value: str, _effects: frozenset[str]) -> Change:
    return Change(drop_height_m=_number("drop_height", value))


WORDS: dict[str, Callable[[str, frozenset[str]], Change]] = {
    "flight": _flight,
    "contact": _contact,
    "gain": _gain,
    "damping_gain": _damping_gain,
    "drop_height": _drop_height,
    "jumps": _jumps,
}
"""Words for `--set` beside the parameters' names: the value and the effects in force give the change."""


def _effects(words: str | None) -> tuple[frozenset[str], frozenset[str]]:
    chosen: dict[str, set[str]] = {"+": set(), "-": set()}
    for word in (words or "").split(","):
        if not (word := word.strip()):
            continue
        sign, name = word[0], word[1:].strip()
        if sign not in chosen:
            known = nearest(word, EFFECTS) or "drag"
            raise UsageError(f"--effects {word!r} does not say on or off: write +{known} or -{known}.")
        if name not in EFFECTS:
            raise unknown_name("effect", name, EFFECTS)
        chosen[sign].add(name)
    return frozenset(chosen["+"]), frozenset(chosen["-"])
