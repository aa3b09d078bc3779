"""Studies of what accuracy costs, with nothing compiled but labbook's own kernel."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from simulator.accuracy import peers, study
from simulator.accuracy.methods import METHODS, stops_after
from simulator.accuracy.reference_of import Reference, reference_of
from simulator.accuracy.study import AccuracyStudy
from simulator.scene import Scene
from tests.helpers.kernels import interpreted


def quick_study(
    scene: Scene, methods: Sequence[str] = tuple(METHODS), most_evaluations: int = peers.MOST_EVALUATIONS
) -> tuple[AccuracyStudy, list[str]]:
    """A quick `accuracy_study`, and what it told on the way; only its times are those of plain Python.

    The kernel computes the reference, which takes it a hundred times as many jumps as all methods together.
    """
    reference = reference_of(scene, stops_after(scene))
    return interpreted(_with_reference, scene, reference, methods, most_evaluations)


def _with_reference(
    scene: Scene, reference: Reference, methods: Sequence[str], most_evaluations: int
) -> tuple[AccuracyStudy, list[str]]:
    told: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "reference_of", lambda *_: reference)
        patch.setattr(study, "METHODS", {name: METHODS[name] for name in methods})
        patch.setattr(study, "LONGEST_TIMING_S", 0.0)
        patch.setattr(peers, "MOST_EVALUATIONS", most_evaluations)
        return study.accuracy_study(scene, quick=True, done=told.append), told
