"""One stance of set 2 to a relative error of a millionth: labbook, scipy's methods, the thesis's scheme; and to other
errors beside a compiled program that knows nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.compiled_peer import PEER
from benchmarks.section import Benchmark, Budget, Section, Table
from benchmarks.timing import Times, Work, in_turns
from simulator.accuracy.fixed_step_euler import THESIS_STEP_S
from simulator.accuracy.methods import EULER, LABBOOK, METHODS, NAMES, Attempt, Method, relative_errors, stops_after
from simulator.accuracy.reference_of import stored_reference
from simulator.scene import Scene
from simulator.scene_file import load_scene

SCENE = "sim2"
OUTPUTS = tuple(name for name in NAMES if name != "apex_height_m")
GOAL = 1e-6
LABBOOK_US, OF_EULER, OF_COMPILED = 60.0, 100.0, 1.3
FURTHER_GOALS = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
"""Errors to which labbook and the compiled peer are compared."""
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
    euler = _prepared(scene, METHODS[EULER], THESIS_STEP_S)
    works = {name: _coarsest_within(GOAL, scene, method) for name, method in METHODS.items() if name != EULER}
    ours = works[LABBOOK]
    works[EULER] = euler
    say(f"{ROUNDS} rounds of {len(works)} methods")
    times = in_turns({name: Work(_many(work)) for name, work in works.items()}, ROUNDS)
    mine, thesis = (times[work.name].cpu_minimum / work.calls for work in (ours, euler))
    fair = ours.error < euler.error
    say("beside the compiled peer")
    beside, ratios = _beside_compiled(scene)
    return Section(
        "One stance",
        "One stance of set 2 (scene `sim2`), from touchdown to lift-off, after compilation. The error is the largest "
        "of depth, lift-off time and cost, against the stored reference of 36 digits. solve_ivp gets the same compiled "
        "forces, finds the same events, and starts anew where the sampled controller changes gains. Of each method's "
        f"settings the coarsest is taken that keeps an error of {GOAL:g} together with all finer ones; Euler's step is "
        "the thesis's. A ratio counts only if labbook's error is within the goal, and smaller than Euler's. The "
        "compiled peer is a program in numba for this robot alone (`benchmarks/compiled_peer.py`): Dormand and "
        "Prince's method with dense output, which locates its events by itself; without energy book, margins or other "
        "effects.",
        (
            _budget(
                f"a stance to {GOAL:g} relative error (processor time)",
                LABBOOK_US,
                "µs",
                mine * 1e6,
                ours.error <= GOAL,
            ),
            _budget(
                f"explicit Euler at {THESIS_STEP_S:g} s over labbook (processor time)",
                OF_EULER,
                "×",
                thesis / mine,
                fair,
            ),
            Budget(
                f"labbook over the compiled peer, {FURTHER_GOALS[0]:g} to {FURTHER_GOALS[-1]:g} (processor time)",
                OF_COMPILED,
                "×",
                max(ratios),
            ),
        ),
        (
            _table(
                list(works.values()),
                times,
                mine,
                "The forces that solve_ivp calls are as fast as labbook's: the difference is that each of its steps "
                f"passes through Python. {ours.evaluations} evaluations at the price of one of explicit Euler's, with "
                f"nothing for errors and events, are {ours.evaluations * thesis / euler.evaluations * 1e6:.3g} µs.",
            ),
            beside,
        ),
    )


def _beside_compiled(scene: Scene) -> tuple[Table, list[float]]:
    """Return what labbook and the compiled peer take to each error, in turns, and labbook's time over the peer's."""
    pairs = {
        goal: tuple(_coarsest_within(goal, scene, method) for method in (METHODS[LABBOOK], PEER))
        for goal in FURTHER_GOALS
    }
    works = {f"{goal:g} {work.name}": Work(_many(work)) for goal, pair in pairs.items() for work in pair}
    times, rows, ratios = in_turns(works, ROUNDS), list[tuple[str, ...]](), list[float]()
    for goal, pair in pairs.items():
        ours_s, peers_s = (times[f"{goal:g} {work.name}"].cpu_minimum / work.calls for work in pair)
        ratios.append(ours_s / peers_s)
        cells = (
            f"{work.setting}: {seconds * 1e6:.3g} µs, {work.evaluations} evaluations, error {work.error:.1e}"
            for work, seconds in zip(pair, (ours_s, peers_s), strict=True)
        )
        rows.append((f"{goal:g}", *cells, f"{ratios[-1]:.3g}"))
    return Table(
        ("error", *(work.name for work in pairs[GOAL]), "ratio"),
        tuple(rows),
        "Least processor time. Both have the coarsest setting that keeps the error together with all finer ones.",
    ), ratios


def _many(work: _Timed) -> Callable[[object], None]:
    run, calls = work.attempt.run, work.calls

    def repeated(_prepared: object) -> None:
        for _ in range(calls):
            run()

    return repeated


def _prepared(scene: Scene, method: Method, setting: float) -> _Timed:
    attempt = method.prepare(scene, setting, stops_after(scene, stance=True))
    attempt.run()
    found, match = attempt.found(), stored_reference(scene)
    if match is None:
        raise RuntimeError(f"there is no stored reference of scene {scene.name}")
    errors = relative_errors(found, match.values)
    error = max(errors[output] or 0.0 for output in OUTPUTS)
    shown = f"{method.setting} {setting:g} {method.unit}".rstrip()
    calls = CALLS if method.name in (LABBOOK, PEER.name) else 1
    return _Timed(method.name, shown, attempt, error, found.evaluations, calls)


def _coarsest_within(goal: float, scene: Scene, method: Method) -> _Timed:
    """The coarsest setting that keeps an error together with all finer ones: powers of ten and three times those."""
    kept: _Timed | None = None
    for setting in sorted({*method.settings, *(3.0 * setting for setting in method.settings)}):
        tried = _prepared(scene, method, setting)
        if tried.error > goal:
            break
        kept = tried
    if kept is None:
        raise RuntimeError(f"{method.name} does not keep an error of {goal:g}")
    return kept


def _budget(what: str, limit: float, unit: str, measured: float, holds: bool) -> Budget:
    """A budget counts only together with the error it is for; a ratio is to be large."""
    why = "" if holds else "the error was larger than it may be"
    return Budget(what, limit, unit, measured if holds else None, unit == "×", why)


def _table(works: list[_Timed], times: dict[str, Times], mine: float, shows: str) -> Table:
    rows = []
    for work in works:
        least, middle = times[work.name].cpu_minimum / work.calls, times[work.name].median / work.calls
        times_of_it = (f"{least * 1e6:.4g}", f"{middle * 1e6:.4g}", f"{least / mine:.3g}")
        rows.append((work.name, work.setting, f"{work.error:.1e}", str(work.evaluations), *times_of_it))
    return Table(
        ("", "setting", "largest error", "evaluations", "processor, µs", "median, µs", "processor over labbook's"),
        tuple(rows),
        shows,
    )


BENCHMARK = Benchmark("stance", measure)
