"""`python -m simulator.ablation`: the process of `simulator.ablation.interpreted` that simulates."""

import json
import sys
from dataclasses import asdict

import numpy as np

from simulator.ablation.outputs import outputs_of
from simulator.scene_file import parse_scene


def main() -> None:
    """Simulate the scene of the first line without the effects of each other line."""
    request = json.loads(sys.stdin.readline())
    scene = parse_scene(request["scene"], request["name"])
    with np.errstate(all="ignore"):  # as compiled code, which has infinities and no warnings
        for line in sys.stdin:
            asked = json.loads(line)
            left_out = scene.changed(effects_off=asked["left_out"])
            outputs = outputs_of(left_out, request["accuracy"], asked["most_steps"])
            print(json.dumps(asdict(outputs)), flush=True)


if __name__ == "__main__":
    main()
