"""What scenes are made of: effects, parameters, and the words that change several at once; for people and programs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from data_schema.errors import unknown_name
from reports.tables.formats import markdown_text
from reports.tables.table import Column, Row, Table, words
from simulator.changes import WORDS
from simulator.declared import all_parameters, readers
from simulator.effects.effect import Effect
from simulator.effects.registry import EFFECTS
from simulator.parameter import Parameter
from simulator.scene_file import PARTS, load_scene, shipped_scenes

EVERY_SCENE = "every scene"
_CAPTIONS = {
    "effects": "Effects: on in a scene where its list of effects, or --effects +NAME, names them.",
    "parameters": "Parameters, by the table of a scene's file: SI units, both ends of a range allowed.",
    "words": "Words for --set that change what they do not name.",
}


def parts_tables() -> dict[str, Table]:
    """Return the tables of all effects, parameters and words."""
    return {
        "effects": _table(
            "effects",
            ("effect", "meaning", "needs", "not with", "gives"),
            (
                (
                    effect.name,
                    effect.meaning,
                    _needs(effect),
                    ", ".join(effect.excludes),
                    ", ".join(effect.outputs),
                )
                for effect in EFFECTS.values()
            ),
        ),
        "parameters": _table(
            "parameters",
            ("parameter", "table", "unit", "from", "to", "meaning", "read by"),
            (
                (
                    parameter.name,
                    parameter.part,
                    parameter.unit,
                    f"{parameter.low:g}",
                    f"{parameter.high:g}",
                    parameter.meaning,
                    _read_by(parameter),
                )
                for parameter in sorted(all_parameters().values(), key=lambda one: PARTS.index(one.part))
            ),
        ),
        "words": _table("words", ("word", "meaning"), _meanings().items()),
    }


def _meanings() -> dict[str, str]:
    return {name: word.meaning for name, word in WORDS.items()}


def parts_markdown() -> str:
    """Return all tables as Markdown, as docs/scenes.md has them."""
    return "\n".join(map(markdown_text, parts_tables().values()))


def parts_data() -> dict[str, Any]:
    """Return everything for JSON."""
    return {
        "effects": {effect.name: _effect_data(effect) for effect in EFFECTS.values()},
        "parameters": {name: _parameter_data(parameter) for name, parameter in all_parameters().items()},
        "words": _meanings(),
    }


def part_data(name: str) -> dict[str, Any]:
    """Return one effect, parameter or word for JSON; raises `UnknownName` for none of them."""
    if name in EFFECTS:
        return {"name": name, "kind": "effect", **_effect_data(EFFECTS[name])}
    if name in all_parameters():
        return {"name": name, "kind": "parameter", **_parameter_data(all_parameters()[name])}
    if name in WORDS:
        return {"name": name, "kind": "word", "meaning": WORDS[name].meaning}
    raise unknown_name("effect, parameter or word", name, (*EFFECTS, *all_parameters(), *WORDS))


def part_lines(name: str) -> list[str]:
    """Return what there is to say of one effect, parameter or word; raises `UnknownName` for none of them."""
    data = part_data(name)
    head = f"{name} ({data['kind']}): {data['meaning']}."
    match data["kind"]:
        case "effect":
            return [head, *_effect_lines(EFFECTS[name])]
        case "parameter":
            return [head, *_parameter_lines(all_parameters()[name])]
        case _:
            return [head]


def _effect_lines(effect: Effect) -> list[str]:
    own = [item.name for item in effect.parameters]
    scenes = [scene for scene in shipped_scenes() if effect.name in load_scene(scene).effects]
    return [
        f"source: {effect.source}.",
        *([f"leaves out: {effect.lacks}."] if effect.lacks else []),
        *([f"needs {_needs(effect)}."] if effect.needs else []),
        *([f"pushes the body in the modes {', '.join(force.modes)}."] if (force := effect.body_force) else []),
        *(f"is an event where {guard.expression} rises through zero: {guard.happens}." for guard in effect.guards),
        *(f"integrates {state.name}: {state.meaning}, {state.unit}." for state in effect.states),
        *(f"gives {' and '.join(energy.columns)}: {energy.meaning}." for energy in effect.all_energies),
        *(f"not with {other}: {sentence}." for other, sentence in effect.excludes.items()),
        f"reads {', '.join(own)}." if own else "reads no parameter of its own.",
        f"on in {', '.join(scenes) or 'no shipped scene'}.",
    ]


def _parameter_lines(parameter: Parameter) -> list[str]:
    unit = parameter.unit_text
    lines = [
        f"from {parameter.low:g} to {parameter.high:g}{unit}, in the table [{parameter.part}] of a scene's file.",
        f"read by {_read_by(parameter)}.",
        *(f"{effect}: {EFFECTS[effect].source}." for effect in readers(parameter.name)),
    ]
    for scene in map(load_scene, shipped_scenes()):
        if parameter.name in scene.read:
            value = scene.values[parameter.name]
            origin = f"assumed: {value.why}" if value.assumed else value.source
            lines.append(f"{scene.name}: {value.value:g}{unit} ({origin})")
    if parameter.assumed is not None:
        lines.append(
            f"where --effects asks for it, and a scene has none: {parameter.assumed:g}{unit} (assumed: {parameter.why})"
        )
    return lines


def _effect_data(effect: Effect) -> dict[str, Any]:
    return {
        "meaning": effect.meaning,
        "source": effect.source,
        "lacks": effect.lacks,
        "needs": [list(alternatives) for alternatives in effect.needs],
        "excludes": effect.excludes,
        "parameters": [parameter.name for parameter in effect.parameters],
        "outputs": list(effect.outputs),
        "guards": [guard.name for guard in effect.guards],
        "states": [state.name for state in effect.states],
        "pushes_body_in": list(effect.body_force.modes) if effect.body_force else [],
    }


def _parameter_data(parameter: Parameter) -> dict[str, Any]:
    return {
        "meaning": parameter.meaning,
        "table": parameter.part,
        "unit": parameter.unit,
        "from": parameter.low,
        "to": parameter.high,
        "read_by": list(readers(parameter.name)),
    }


def _needs(effect: Effect) -> str:
    return ", ".join(" or ".join(alternatives) for alternatives in effect.needs)


def _read_by(parameter: Parameter) -> str:
    return ", ".join(readers(parameter.name)) or EVERY_SCENE


def _table(name: str, heads: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Table:
    columns = tuple(Column(head, (head,), numeric=False) for head in heads)
    return Table(name, _CAPTIONS[name], columns, tuple(Row(tuple(map(words, cells))) for cells in rows))
