"""One stance of set 2 to a relative error of a millionth: labbook, scipy's and CyRK's methods, the thesis's scheme."""

from __future__ import annotations

import importlib.util
import itertools
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
LABBOOK_US, OF_COMPILED, OF_EULER = 60.0, 1.0, 100.0
ROUNDS = 25
CALLS = 100
"""Calls of a compiled method timed together, so that they take about as long as one of the others."""
TOLD = "CyRK (compiled), told all events"
COMPILED = (
    "CyRK's methods are compiled, and called from compiled code. They find no events there, so that the times of all, "
    "lift-off with them, are found beforehand and told, which no user has: they spend nothing on finding events, on "
    "the margins of decisions, or on the growth of errors, and meet each told event by one step of Newton's. Tick by "
    "tick they are told the changes of contact and of the force's cap, but not where gains change."
)
WITHOUT_CYRK = "CyRK is not installed (`pip install '.[benchmarks]'`), so that no compiled method is compared."


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
    groups = {what: [_coarsest_within_goal(scene, method) for method in methods] for what, methods in _peers().items()}
    works = [ours, *itertools.chain(*groups.values()), euler]
    say(f"{ROUNDS} rounds of {len(works)} methods")
    times = in_turns({work.name: Work(_many(work)) for work in works}, ROUNDS)
    seconds = {work.name: times[work.name].minimum / work.calls for work in works}
    mine = seconds[ours.name]
    fastest = {what: min(seconds[peer.name] for peer in peers) for what, peers in groups.items()}
    return Section(
        "One stance",
        "One stance of set 2 (scene `sim2`), from touchdown to lift-off, after compilation. The error is the largest "
        "of depth, lift-off time and cost, against the stored reference of 36 digits. solve_ivp and CyRK get the same "
        f"compiled forces. Of each method's settings the coarsest is taken that keeps an error of {GOAL:g} together "
        "with all finer ones; Euler's step is the thesis's. A ratio counts only if labbook's error is within the goal, "
        "and smaller than Euler's.",
        (
            _budget(f"a stance to {GOAL:g} relative error (min)", LABBOOK_US, "µs", mine * 1e6, ours.error <= GOAL),
            _budget(
                "labbook over the fastest compiled method, which is told all events, at that error (min)",
                OF_COMPILED,
                "×",
                mine / fastest[TOLD] if TOLD in fastest else None,
                ours.error <= GOAL,
                why=WITHOUT_CYRK,
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
            Table(
                ("fastest at that error", "min over labbook's"),
                tuple((what, f"{fastest_s / mine:.3g}") for what, fastest_s in fastest.items()),
                "How many times labbook's a stance of the fastest method of each kind takes. solve_ivp finds the same "
                "events as labbook. The controller is sampled, so solve_ivp is first written to be called from tick to "
                "tick; it can be told, by an event of its own, to start anew only where gains change. The forces that "
                "it calls are as fast as labbook's: the difference is that each of its steps passes through Python. "
                + (COMPILED if TOLD in groups else WITHOUT_CYRK),
            ),
            _table(
                works,
                times,
                mine,
                f"{ours.evaluations} evaluations at the price of one of explicit Euler's, with nothing for errors and "
                f"events, are {ours.evaluations * seconds[euler.name] / euler.evaluations * 1e6:.3g} µs.",
            ),
        ),
    )


def _peers() -> dict[str, list[Method]]:
    """The methods that are compared, by what they are told."""
    like = METHODS[f"solve_ivp {SOLVE_IVP[0]}"]
    peers = {
        "solve_ivp, tick by tick": [_tick_by_tick(name) for name in SOLVE_IVP],
        "solve_ivp, told where gains change": [METHODS[f"solve_ivp {name}"] for name in SOLVE_IVP],
    }
    if importlib.util.find_spec("CyRK") is None:
        return peers
    from benchmarks.compiled_peer import methods

    return peers | {f"{TOLD}, tick by tick": methods(like, every_tick=True), TOLD: methods(like)}


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
    calls = CALLS if method.name.startswith((LABBOOK, "CyRK")) else 1
    return _Timed(method.name, shown, attempt, error, found.evaluations, calls)


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


def _budget(
    what: str, limit: float, unit: str, measured: float | None, holds: bool, at_least: bool = False, why: str = ""
) -> Budget:
    """A budget counts only together with the error it is for."""
    if not holds:
        return Budget(what, limit, unit, None, at_least, "the error was larger than it may be")
    return Budget(what, limit, unit, measured, at_least, why)


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
