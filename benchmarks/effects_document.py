"""Measures what each effect of the shipped scenes is worth, and writes those tables of `docs/accuracy.md` anew.

python benchmarks/effects_document.py
"""

from __future__ import annotations

from pathlib import Path

from labbook.presenting.simulation.effects_ablation import alone_table, heading, verdict
from reports.display import time_text
from simulator.ablation.kernel_time import kernel_time
from simulator.ablation.study import ablation_of_effects
from simulator.scene_file import load_scene

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "accuracy.md"
SCENES = ("sim2", "bed", "emulator", "force_plate", "sim1")
WITHIN = 0.01


def measured(name: str) -> str:
    """Return the table of a scene and the sentence on its smallest set, as Markdown."""
    scene = load_scene(name)
    ablation = ablation_of_effects(scene, WITHIN)
    head, *rows = alone_table(ablation, {}, None)
    lines = [heading(scene, ablation)[1], "", f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for effect, *values in rows:
        starred = " *" if effect.endswith("*") else ""
        name_cell = f"`{effect.rstrip('*')}`{starred}"
        lines.append(f"| {' | '.join([name_cell, *values])} |")
    fewer = scene.changed({}, (), ablation.smallest.left_out.effects)
    full, smallest = (kernel_time(of, ablation.accuracy).time_per_jump_s for of in (scene, fewer))
    times = f"A jump takes {time_text(full)} with all effects and {time_text(smallest)} with these."
    return "\n".join([*lines, "", *verdict(ablation), "", times])


def main() -> None:
    """Write each scene's table between its two lines of the document."""
    text = DOCUMENT.read_text(encoding="utf-8")
    for name in SCENES:
        first, last = f"<!-- effects: {name} -->\n", "\n<!-- end -->"
        before, _, rest = text.partition(first)
        text = before + first + measured(name) + last + rest.partition(last)[2]
    DOCUMENT.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
