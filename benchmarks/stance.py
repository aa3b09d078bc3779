"""One stance of set 2 to a relative error of a millionth: labbook, scipy's integrators, the thesis's scheme."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from benchmarks.section import Benchmark, Budget, Section, Table
from benchmarks.timing import Times, Work, in_turns
from simulator.accuracy.fixed_step_euler import THESIS_STEP_S
from simulator.accuracy.methods import EULER, LABBOOK, METHODS, Attempt, Method, SolveIvpAttempt, stops_after
from simulator.accuracy.outputs import NAMES, relative_errors
from simulator.accuracy.peers import METHODS as SOLVE_IVP
from simulator.accuracy.reference_of import stored_reference
from simulator.scene import Scene
from simulator.scene_file import load_scene

SCENE = "sim2"
OUTPUTS = tuple(name for name in NAMES if name != "apex_height_m")
GOAL = 1e-6
LABBOOK_US, OF_SOLVE_IVP, OF_EULER = 60.0, 500.0, 100.0
ROUNDS = 25
CALLS = 100
"""Calls of labbook timed together, so that they take about as long as one of the others."""


@dataclass(frozen=True, slots=True)
class _Timed:
    name: str
    setting: str
    attempt: Attempt
    error: float
    evaluations: int
    calls: int = 1


def measure(say: Callable[[str], None]) -> Section:
    """Choose the settings by their errors against the stored reference, then time all in turns."""
    scene = load_scene(SCENE)
    say("compiling, and choosing settings by their errors")
    ours = _coarsest_within_goal(scene, METHODS[LABBOOK])
    euler = _prepared(scene, METHODS[EULER], THESIS_STEP_S)
    peers = [_coarsest_within_goal(scene, METHODS[f"solve_ivp {name}"]) for name in SOLVE_IVP]
    ticking = [_coarsest_within_goal(scene, _tick_by_tick(name)) for name in SOLVE_IVP]
    works = [ours, *peers, *ticking, euler]
    say(f"{ROUNDS} rounds of {len(works)} methods")
    times = in_turns({work.name: Work(_many(work)) for work in works}, ROUNDS)
    seconds = {work.name: times[work.name].minimum / work.calls for work in works}
    mine = seconds[ours.name]
    best, best_ticking = (min(group, key=lambda peer: seconds[peer.name]) for group in (peers, ticking))
    evaluation_s = seconds[euler.name] / euler.evaluations
    return Section(
        "One stance",
        "One stance of set 2 (scene `sim2`), from touchdown to lift-off, after compilation. The error is the largest "
        "of depth, lift-off time and cost, against the stored reference of 36 digits. solve_ivp gets the same compiled "
        f"forces and events. Of each method's settings the coarsest is taken that keeps an error of {GOAL:g} together "
        "with all finer ones; Euler's step is the thesis's. A ratio counts only if labbook's error is within the goal, "
        "and smaller than Euler's.",
        (
            _budget(f"a stance to {GOAL:g} relative error (min)", LABBOOK_US, "µs", mine * 1e6, ours.error <= GOAL),
            *(
                _budget(
                    f"{peer.name} at that error over labbook (fastest of three methods; min)",
                    OF_SOLVE_IVP,
                    "×",
                    seconds[peer.name] / mine,
                    ours.error <= GOAL,
                    at_least=True,
                )
                for peer in (best_ticking, best)
            ),
            _budget(
                f"explicit Euler at {THESIS_STEP_S:g} s over labbook (min)",
                OF_EULER,
                "×",
                seconds[euler.name] / mine,
                ours.error < euler.error,
                at_least=True,
            ),
        ),
        (
            _table(
                works,
                times,
                mine,
                "The controller is sampled, so solve_ivp is first written to be called from tick to tick. It can be "
                "told, by an event of its own, to start anew only where gains change, and is then the faster peer. "
                "The forces that it calls are as fast as labbook's: the difference is that each of its steps passes "
                f"through Python. {OF_SOLVE_IVP:g} times as fast as the faster peer would be "
                f"{seconds[best.name] / OF_SOLVE_IVP * 1e6:.3g} µs; {ours.evaluations} evaluations at the price of one "
                f"of explicit Euler's, with nothing for errors and events, are "
                f"{ours.evaluations * evaluation_s * 1e6:.3g} µs.",
            ),
        ),
    )


def _many(work: _Timed) -> Callable[[object], None]:
    run, calls = work.attempt.run, work.calls

    def repeated(_prepared: object) -> None:
        for _ in range(calls):
            run()

    return repeated


def _tick_by_tick(name: str) -> Method:
    method = METHODS[f"solve_ivp {name}"]
    return replace(method, name=f"{method.name}, tick by tick", prepare=partial(SolveIvpAttempt, name, every_tick=True))


def _prepared(scene: Scene, method: Method, setting: float) -> _Timed:
    attempt = method.prepare(scene, setting, stops_after(scene, stance=True))
    attempt.run()
    found, match = attempt.found(), stored_reference(scene)
    if match is None:
        raise RuntimeError(f"there is no stored reference of scene {scene.name}")
    errors = relative_errors(found.outputs, match.values)
    error = max(errors[output] or 0.0 for output in OUTPUTS)
    shown = f"{method.setting} {setting:g} {method.unit}".rstrip()
    return _Timed(method.name, shown, attempt, error, found.evaluations, CALLS if method.name == LABBOOK else 1)


def _coarsest_within_goal(scene: Scene, method: Method) -> _Timed:
    """The coarsest setting that keeps the goal together with all finer ones: powers of ten and three times those."""
    kept: _Timed | None = None
    for setting in sorted({*method.settings, *(3.0 * setting for setting in method.settings)}):
        tried = _prepared(scene, method, setting)
        if tried.error > GOAL:
            break
        kept = tried
    if kept is None:
        raise RuntimeError(f"{method.name} does not keep an error of {GOAL:g}")
    return kept


def _budget(what: str, limit: float, unit: str, measured: float, holds: bool, at_least: bool = False) -> Budget:
    """A budget counts only together with the error it is for."""
    if not holds:
        return Budget(what, limit, unit, None, at_least, "the error was larger than it may be")
    return Budget(what, limit, unit, measured, at_least)


def _table(works: list[_Timed], times: dict[str, Times], mine: float, shows: str) -> Table:
    rows = []
    for work in works:
        least, middle = times[work.name].minimum / work.calls, times[work.name].median / work.calls
        rows.append(
            (
                work.name,
                work.setting,
                f"{work.error:.1e}",
                str(work.evaluations),
                f"{least * 1e6:.4g}",
                f"{middle * 1e6:.4g}",
                f"{least / mine:.3g}",
            )
        )
    return Table(
        ("", "setting", "largest error", "evaluations", "min, µs", "median, µs", "min over labbook's"),
        tuple(rows),
        shows,
    )


BENCHMARK = Benchmark("stance", measure)
