"""A scene changed by words, as a command line gives them: `--set name=value` and `--effects +drag,-added_mass`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from data_schema.errors import UsageError, nearest, unknown_name
from simulator.declared import all_parameters
from simulator.effects.registry import EFFECTS
from simulator.gains import (
    DAMPING_AT_ZERO_GAIN,
    DAMPING_PER_GAIN,
    STIFFNESS_AT_ZERO_GAIN_N_M,
    STIFFNESS_PER_GAIN_N_M,
    active_damping_kg_m,
    fitted_active_damping_kg_m,
    stiffness_n_m,
)
from simulator.scene import MOST_JUMPS, Scene

_BUT = ", but with "
"""Between a scene's title and the words that changed the scene."""

_HEIGHT, _JUMPS, _SOFT = "initial_height", "jumps", "soft"
FLIGHT_EFFECTS = {"held": "held_gains_in_flight", "massless": "massless_leg_in_flight"}
"""Words for the leg in flight, beside `soft`, which is neither of these effects."""

CONTACT_EFFECT, CONTACTS = "contact_once_risen", ("once_risen", "at_the_print")
"""The effect that decides when a lifted foot meets the ground again, and words for with it and without."""


@dataclass(frozen=True, slots=True)
class Change:
    """What one word changes: a `subject` by a `number`, or what effects are switched for; no two may change the same.

    A subject is a parameter, "jumps" or a choice; the height of a drop waits for the leg's rest length.
    """

    subject: str
    number: float | None = None
    on: frozenset[str] = frozenset()
    off: frozenset[str] = frozenset()
    is_drop: bool = False


@dataclass(frozen=True, slots=True)
class Word:
    """A word for `--set` beside the parameters' names, and what it changes: the value and the effects in force say.

    One that is `swept` stands for one parameter, in other units, and this is its meaning; of others `not_swept` says
    why they are no axis of a sweep, and what to do instead.
    """

    meaning: str
    change: Callable[[str, frozenset[str]], Change]
    swept: str = ""
    not_swept: str = ""


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
    changes: dict[str, Change] = {}
    word_of: dict[str, str] = {}
    for word in sets:
        change = _change(word, (scene.effects | on) - off)
        if change.subject in changes:
            raise UsageError(f"{word_of[change.subject]} and {word} both set {change.subject}: leave one of them out.")
        changes[change.subject], word_of[change.subject] = change, word
        on, off = on | change.on, off | change.off
    values = {subject: change.number for subject, change in changes.items() if change.number is not None}
    jumps = int(values.pop(_JUMPS)) if _JUMPS in values else None
    if (height := changes.get(_HEIGHT)) is not None and height.is_drop:
        drop_height_m, rest_length_m = values[_HEIGHT], values.get("rest_length", scene["rest_length"])
        if drop_height_m < rest_length_m:
            raise UsageError(
                f"drop_height={drop_height_m:g} starts with the foot in the ground: give the body's height above the "
                f"surface, at least the leg's rest length of {rest_length_m:g} m."
            )
        values[_HEIGHT] = drop_height_m - rest_length_m
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
        return WORDS[name].change(value, effects)
    if name in all_parameters():
        return Change(name, _number(name, value))
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
    if value not in (_SOFT, *FLIGHT_EFFECTS):
        raise unknown_name("leg in flight", value, (_SOFT, *FLIGHT_EFFECTS))
    on = frozenset(effect for word, effect in FLIGHT_EFFECTS.items() if word == value)
    return Change("the leg in flight", on=on, off=every - on)


def _contact(value: str, effects: frozenset[str]) -> Change:
    if "hydrostatic_stiffness" not in effects:
        raise UsageError(f"contact={value} says when a lifted foot meets grains again: leave it out on other grounds.")
    rule = frozenset({CONTACT_EFFECT})
    if value not in CONTACTS:
        raise unknown_name("contact after lift-off", value, CONTACTS)
    on = rule if value == CONTACTS[0] else frozenset[str]()
    return Change("contact", on=on, off=rule - on)


def _jumps(value: str, _effects: frozenset[str]) -> Change:
    try:
        return Change(_JUMPS, int(value))
    except ValueError as error:
        raise UsageError(f"jumps={value} is not a whole number: give for example jumps=4.") from error


def _gain(value: str, _effects: frozenset[str]) -> Change:
    return Change("k_extension", stiffness_n_m(_number("gain", value)))


def _damping_gain(value: str, effects: frozenset[str]) -> Change:
    of_gain = active_damping_kg_m if "emulated_ground" in effects else fitted_active_damping_kg_m
    return Change("b_ad", of_gain(_number("damping_gain", value)))


def _drop_height(value: str, _effects: frozenset[str]) -> Change:
    return Change(_HEIGHT, _number("drop_height", value), is_drop=True)


WORDS: dict[str, Word] = {
    "flight": Word(
        "how the leg flies: soft (with its gains of compression), "
        + " or ".join(f"{word} (the effect {effect})" for word, effect in FLIGHT_EFFECTS.items()),
        _flight,
        not_swept="switches effects and cannot be swept: give it with --set, in a sweep of its own for each of soft, "
        "held and massless.",
    ),
    "contact": Word(
        f"when a lifted foot meets grains again: {CONTACTS[0]} (the effect {CONTACT_EFFECT}) or {CONTACTS[1]} "
        "(without it)",
        _contact,
        not_swept="switches an effect and cannot be swept: give it with --set, in a sweep of its own for each of "
        "once_risen and at_the_print.",
    ),
    "gain": Word(
        "extension gain of the robot's controller; sets k_extension to "
        f"{STIFFNESS_PER_GAIN_N_M:g} gain + {STIFFNESS_AT_ZERO_GAIN_N_M:g} N/m (thesis 5.1.1)",
        _gain,
        swept="extension gain of the leg's controller",
    ),
    "damping_gain": Word(
        "active-damping gain of the controller; sets b_ad to "
        f"{DAMPING_PER_GAIN:g} gain + {DAMPING_AT_ZERO_GAIN:g} kg/m, to 0 at gain 0, and on the emulator to "
        f"{DAMPING_PER_GAIN:g} gain (thesis 5.1.1)",
        _damping_gain,
        swept="active-damping gain of the leg's controller",
    ),
    "drop_height": Word(
        "height of the body at the start, in m; sets initial_height to it less rest_length",
        _drop_height,
        not_swept="depends on the leg's rest length and cannot be swept: give it with --set, or sweep initial_height, "
        "the foot's height at the start.",
    ),
    "jumps": Word(
        f"number of jumps, one after the other: 1 to {MOST_JUMPS}; on grains each on fresh ground",
        _jumps,
        not_swept="is a dimension of every result and cannot be swept: give it with --set, and the result holds all "
        "jumps up to that number.",
    ),
}
"""Words for `--set` beside the parameters' names."""


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
