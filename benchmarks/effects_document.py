"""Measures what each effect of the shipped scenes is worth, and writes those tables of `docs/accuracy.md` anew.

python benchmarks/effects_document.py [SCENE...]
"""

from __future__ import annotations

import sys
from pathlib import Path

from labbook.presenting.simulation.effects import alone_table, heading, verdict
from simulator.ablation import ablation_of_effects
from simulator.scene_file import load_scene

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "accuracy.md"
SCENES = ("sim2", "bed", "emulator", "force_plate", "sim1")
WITHIN = 0.01


def measured(name: str) -> str:
    """Return the table of a scene and the sentences on the effects that are enough, as Markdown."""
    scene = load_scene(name)
    ablation = ablation_of_effects(scene, WITHIN, step=lambda what: print(f"   {what}", flush=True))
    head, *rows = alone_table(ablation)
    lines = [heading(scene, ablation)[1], "", f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for effect, *values in rows:
        starred = " *" if effect.endswith("*") else ""
        name_cell = f"`{effect.rstrip('*')}`{starred}"
        lines.append(f"| {' | '.join([name_cell, *values])} |")
    return "\n".join([*lines, "", *verdict(ablation)])


def main(names: list[str]) -> None:
    """Write each scene's table between its two lines of the document."""
    for name in names or SCENES:
        print(f"== {name}", flush=True)
        first, last = f"<!-- effects: {name} -->\n", "\n<!-- end -->"
        before, _, rest = DOCUMENT.read_text(encoding="utf-8").partition(first)
        text = before + first + measured(name) + last + rest.partition(last)[2]
        DOCUMENT.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
