"""Scenes with many sets of effects, each simulated without compiling a kernel for it.

A set takes seconds to compile and a twentieth of a second to simulate in plain Python, which is the same code
(`NUMBA_DISABLE_JIT=1`). numba reads that variable when it is loaded, so it is another process that simulates
(`python -m simulator.ablation`); requests and answers are lines of JSON.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import IO, cast

from simulator.ablation.outputs import Outputs, outputs_of
from simulator.scene import Scene
from simulator.scene_file import write_scene

OutputsWithout = Callable[[frozenset[str]], Outputs]
"""What a scene gives without these effects."""
STEPS_MORE = 30
"""Times the steps of a jump with all effects after which one without some of them is given up. What chatters without
the controller's clock takes thousands of times as many; shipped scenes without one or two effects at most twice as
many."""
PATIENCE_S = 30.0
"""A jump that takes longer in plain Python has very many steps, and is worth compiling."""


@contextlib.contextmanager
def interpreted(
    scene: Scene, accuracy: float, patience_s: float = PATIENCE_S, steps_more: int = STEPS_MORE
) -> Iterator[OutputsWithout]:
    """Yield the function that simulates the scene without some of its effects; each set is simulated once.

    What is left out must leave a scene that can be simulated. A set that takes longer than `patience_s` in plain
    Python is compiled after all; a jump that takes `steps_more` times the steps of any with all effects ends in
    `step_limit`.
    The other process ends with the block, at once.
    """
    request = json.dumps({"scene": write_scene(scene), "name": scene.name, "accuracy": accuracy})
    with contextlib.ExitStack() as stack:
        running: list[_Interpreter] = []

        @cache
        def outputs(left_out: frozenset[str]) -> Outputs:
            most_steps = steps_more * outputs(frozenset()).most_steps if left_out else None
            if not running:
                running.append(stack.enter_context(_interpreter(request)))
            found = running[0].ask(left_out, most_steps, patience_s)
            if found is not None:
                return found
            running.clear()
            return outputs_of(scene.changed(effects_off=left_out), accuracy, most_steps)

        yield outputs


class _Interpreter:
    """The other process, and the thread that waits for its answers."""

    def __init__(self, process: subprocess.Popen[str], waiting: ThreadPoolExecutor) -> None:
        self.process, self.waiting = process, waiting

    def send(self, line: str) -> None:
        questions = cast(IO[str], self.process.stdin)
        with contextlib.suppress(BrokenPipeError):  # then there is no answer either
            questions.write(line + "\n")
            questions.flush()

    def ask(self, left_out: frozenset[str], most_steps: int | None, patience_s: float) -> Outputs | None:
        """Return what the process answers in time; without an answer, None, and the process has ended."""
        self.send(json.dumps({"left_out": sorted(left_out), "most_steps": most_steps}))
        answers = cast(IO[str], self.process.stdout)
        try:
            answer = self.waiting.submit(answers.readline).result(patience_s)
        except TimeoutError:
            answer = ""
        if not answer:
            self.process.kill()
            return None
        return Outputs(**json.loads(answer))


@contextlib.contextmanager
def _interpreter(request: str) -> Iterator[_Interpreter]:
    with (
        subprocess.Popen(
            [sys.executable, "-P", "-m", "simulator.ablation"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            encoding="utf-8",
            env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
            start_new_session=True,  # Ctrl-C is for this process, which ends the other
        ) as process,
        ThreadPoolExecutor(1) as waiting,
    ):
        try:
            interpreter = _Interpreter(process, waiting)
            interpreter.send(request)
            yield interpreter
        finally:
            process.kill()
            with contextlib.suppress(BrokenPipeError):
                cast(IO[str], process.stdin).close()
