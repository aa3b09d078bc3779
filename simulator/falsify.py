"""The grounds on which active damping does not save: looked for in a box of parameters, each one confirmed.

On every ground compression-extension (CE, no active damping) and active damping (AD) make the scene's jump. Joules are
compared at equal height: the controller that jumps higher gets a softer extension until its apex is the other's; where
it then does not jump at all, the other gets a stiffer one. A Sobol sample tells the share of the box, differential
evolution (Storn and Price 1997, as scipy has it) goes on from the worst grounds of the sample.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError, unknown_name
from simulator.accuracy.methods import METHODS
from simulator.accuracy.peers import PeerGaveUp
from simulator.compiled import Row
from simulator.declared import all_parameters
from simulator.error_bars import simulate_with_errors
from simulator.gains import fitted_active_damping_kg_m
from simulator.kernel.build import is_cached, why_no_lanes
from simulator.kernel.composition import compose
from simulator.kernel.limits import STOP_AFTER_TOUCHDOWN
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.sweep.chunks import PLACE, Block, Recipe, recipe_of_rows, simulate_on_all_cores
from simulator.sweep.design import LOGARITHMIC, at_shares, sobol_shares
from simulator.sweep.sweep import Flags, Sweep, refused_rows, sweep_by_words

CLAIMS = ("saves",)
HEIGHT, GAINS = "height", "gains"
"""What is equal where joules are compared: apex heights, or all gains but active damping."""
SAVES, SAME, FAILS, NO_JUMP, NEVER_ROSE, UNEQUAL, UNDER_SURFACE, FLAGGED, REFUSED = range(9)
VERDICTS = {
    SAVES: "active damping saves",
    SAME: "no difference",
    FAILS: "active damping costs more",
    NO_JUMP: "a controller does not jump",
    NEVER_ROSE: "a lifted foot never rises above its print",
    UNEQUAL: "no equal height",
    UNDER_SURFACE: "the body gets under the surface",
    FLAGGED: "ill-conditioned, or an open energy book",
    REFUSED: "cannot be simulated",
}
"""What may be found of a ground; from `NO_JUMP` on it is apart, and says nothing of the claim."""
SAME_WITHIN = 1e-4
"""Savings of less are no difference: on hard ground the foot does not move, and active damping does nothing."""
DAMPING_GAIN = 150.0
"""The damping gain of scenes without active damping: the middle one of thesis 5.1.1."""
DAMPINGS = {"active_damping": "b_ad", "scaled_active_damping": "ad_share"}
"""The effects that are active damping, and the parameter of each without which there is none."""
_CE, _AD = 0, 1
_STIFFNESS = all_parameters()["k_extension"]
_LOWEST, _HIGHEST = 0.25, 8.0
"""How much softer and stiffer an extension is made for an equal height."""
_HALVINGS, _CLOSE_M = 10, 1e-3
_MOST_HOLLOWS, _MEMBERS_AN_AXIS, _FEWEST_MEMBERS, _MOST_GENERATIONS, _IDLE = 5, 5, 8, 24, 6
"""How many hollows of the sample the search goes on from, how many grounds a generation has, how many generations
there are at most, and how many without a worse ground.
"""
_SOLVER, _SOLVER_ACCURACY = "solve_ivp DOP853", 1e-12
_SHOWN, _FEWEST_FAILURES = 5, 5


@dataclass(frozen=True, slots=True)
class Question:
    """Whether active damping saves in a box: the sweep's sample of it, with `over`, the ranges in words.

    `scene` has active damping, by the parameter `damping`; `equal` is `HEIGHT` or `GAINS`.
    """

    sweep: Sweep
    over: tuple[str, ...]
    scene: Scene
    damping: str
    equal: str

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters that span the box."""
        return tuple(axis.parameter for axis in self.sweep.design.axes)


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """What was found of grounds: their `verdict`, shape (grounds,), and what is saved, CE - AD, NaN where apart.

    `saved_j` is that in joules, `saving` the share of CE's cost, NaN also where this is not positive; `not_positive`
    where a cost is not, of grounds that say something. `stiffness` (N/m), shape (2, grounds), is that of the extension
    of CE and of AD; `slope` (J/m) what height costs with the controller that was changed; `stiffer` whether it does not
    jump with the scene's stiffness, and got more: the saving jumps where that begins.
    """

    verdict: NDArray[np.int64]
    saved_j: Row
    saving: Row
    not_positive: Flags
    stiffness: Row
    slope: Row
    stiffer: Flags


@dataclass(frozen=True, slots=True)
class Counterexample:
    """A ground on which the claim fails, and how sure that is.

    `more_j` is by how much active damping costs more; `bar_j` what the errors of both simulations and the rest of a
    difference in height leave open; `solver_j` how far another solver is from both costs, None where it gave up.
    """

    ground: dict[str, float]
    stiffness: tuple[float, float]
    jumps: tuple[JumpResult, JumpResult]
    more_j: float
    bar_j: float
    solver_j: float | None

    @property
    def saving(self) -> float:
        """The share that active damping saves, below 0; NaN where the other cost is not positive."""
        cost_j = self.jumps[_CE].cost_J
        return -self.more_j / cost_j if cost_j > 0.0 else math.nan

    @property
    def confirmed(self) -> bool:
        """Whether the difference is larger than all that is unsure of it, and no jump is flagged."""
        flagged = any(jump.ill_conditioned or jump.open_book for jump in self.jumps)
        return not flagged and self.solver_j is not None and self.more_j > self.bar_j + self.solver_j


@dataclass(frozen=True, slots=True)
class Region:
    """The smallest box, in shares of the whole, around the failures of half the sample; what the other half shows.

    `inside` and `outside`: failures and grounds that say something, of the other half.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    inside: tuple[int, int]
    outside: tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class Searched:
    """A box that was searched: `shares` of the ranges and what was found there, the first `sample` of them a sample."""

    shares: Row
    judged: Judged
    sample: int

    @property
    def counts(self) -> dict[int, int]:
        """How many grounds of the sample have each verdict."""
        return {verdict: int((self.judged.verdict[: self.sample] == verdict).sum()) for verdict in VERDICTS}

    @property
    def not_positive(self) -> int:
        """On how many grounds of the sample that say something a cost is not positive."""
        return int(self.judged.not_positive[: self.sample].sum())

    @property
    def says(self) -> int:
        """How many grounds of the sample say something of the claim."""
        return int((self.judged.verdict[: self.sample] < NO_JUMP).sum())

    @property
    def failing(self) -> NDArray[np.int64]:
        """The places of all grounds on which the claim fails, each once, the worst first."""
        found = np.flatnonzero(self.judged.verdict == FAILS)
        found = found[np.sort(np.unique(self.shares[found], axis=0, return_index=True)[1])]
        return found[np.argsort(_worth(self.judged)[found], kind="stable")]


def question_by_words(
    scene: str,
    over: Sequence[str],
    sets: Sequence[str] = (),
    effects: str | None = None,
    *,
    claim: str = CLAIMS[0],
    equal: str = HEIGHT,
    grounds: int = 2048,
    seed: int = 0,
    accuracy: float = 1e-6,
) -> Question:
    """Return the question whether a claim fails in the box that words span, ranges of a decade and more by logarithm.

    Raises `UsageError` for words without a meaning and scenes without active damping.
    """
    if claim not in CLAIMS:
        raise unknown_name("claim", claim, CLAIMS)
    if equal not in (HEIGHT, GAINS):
        raise unknown_name("value of --equal", equal, (HEIGHT, GAINS))
    spaced = tuple(map(_spaced, over))
    sweep = sweep_by_words(scene, spaced, sets, effects, accuracy=accuracy, sample=grounds, seed=seed, error_bars=0.0)
    damping = damping_of(sweep.scene)
    scene_with = with_damping(sweep.scene)
    return Question(sweep, spaced, scene_with, damping, equal)


def damping_of(scene: Scene) -> str:
    """Return the parameter without which a scene's controller is compression-extension."""
    for effect, parameter in DAMPINGS.items():
        if effect in scene.effects:
            return parameter
    raise UsageError(f"{scene.name} has no active damping that could save: add --effects +active_damping.")


def has_damping(scene: Scene) -> bool:
    """Whether a scene of one jump has active damping that is not 0."""
    names = [name for name in DAMPINGS if name in scene.effects]
    return scene.jumps == 1 and any(scene[DAMPINGS[name]] > 0.0 for name in names)


def with_damping(scene: Scene) -> Scene:
    """Return the scene with active damping: its own, or that of a gain of 150 where it has none."""
    if scene[damping_of(scene)] > 0.0:
        return scene
    if damping_of(scene) != "b_ad":
        raise UsageError("ad_share = 0 is no active damping: give its share, such as --set ad_share=0.1667.")
    return scene.changed({"b_ad": fitted_active_damping_kg_m(DAMPING_GAIN)})


def _spaced(word: str) -> str:
    values = word.partition("=")[2]
    ends = [part.strip() for part in values.split(":")]
    try:
        low, high = map(float, ends)
    except ValueError:
        return word
    return f"{word}:{LOGARITHMIC}" if 0.0 < 10.0 * low <= high else word


def falsify(question: Question, done: Callable[[str], object] = lambda _what: None) -> Searched:
    """Search the box of a question; `done` is told after the sample and after each generation what comes next."""
    scene, sample = question.scene, question.sweep.design
    rig, seed = _Rig(scene, question.sweep.accuracy, question.equal), sample.seed or 0

    def judge(shares: Row) -> Judged:
        design = at_shares(question.over, scene.effects, shares, seed)
        return rig.judge(question.names, design.rows(0, len(shares)), refused_rows(scene, design)[0])

    return search(judge, sobol_shares(len(sample.axes), sample.row_count, seed), seed, done)


def judge_scenes(scenes: Sequence[Scene], accuracy: float = 1e-6) -> Judged:
    """Judge at equal height scenes of the same effects, each with its active damping."""
    rig = _Rig(scenes[0], accuracy, HEIGHT)
    read = [parameter.name for parameter in compose(scenes[0].effects).parameters]
    return rig.judge(
        read, np.array([[scene[name] for name in read] for scene in scenes]), np.zeros(len(scenes), np.bool_)
    )


def search(
    judge: Callable[[Row], Judged], sample: Row, seed: int, done: Callable[[str], object] = lambda _what: None
) -> Searched:
    """Judge a sample of the unit cube, shape (grounds, axes), and go on from its hollows by differential evolution."""
    judged, shares = [judge(sample)], [sample]
    done("going on from the worst grounds")

    def worth(columns: Row) -> Row:
        rows = np.atleast_2d(columns.T)
        shares.append(rows)
        judged.append(judge(rows))
        done("going on from the worst grounds")
        return _worth(judged[-1])

    for number, members in enumerate(_hollows(sample, _worth(judged[0]))):
        _descend(worth, sample[members], np.random.default_rng((seed, number)))
    whole = Judged(*(np.concatenate([getattr(one, name) for one in judged], axis=-1) for name in Judged.__slots__))
    return Searched(np.concatenate(shares), whole, len(sample))


def _worth(judged: Judged) -> Row:
    """Return what is made small: the saving, or the joules where that is none, 0 where that is no difference, and much
    where a ground is apart.
    """
    saved = np.where(np.isnan(judged.saving), judged.saved_j, judged.saving)
    found: Row = np.where(judged.verdict == SAME, 0.0, np.where(judged.verdict < NO_JUMP, saved, 2.0))
    return found


def _hollows(sample: Row, worth: Row) -> list[NDArray[np.int64]]:
    """Return, the lowest first, the sample's points that lie below all of their neighbours, each with these; where none
    does, the lowest.
    """
    from scipy.spatial import KDTree

    size = min(len(sample), max(_FEWEST_MEMBERS, _MEMBERS_AN_AXIS * sample.shape[1]))
    near = KDTree(sample).query(sample, size)[1].reshape(len(sample), size)
    lowest = np.flatnonzero((worth[:, np.newaxis] < worth[near[:, 1:]]).all(axis=1))
    lowest = lowest if lowest.size else np.array([int(worth.argmin())])
    return [near[place] for place in lowest[np.argsort(worth[lowest], kind="stable")][:_MOST_HOLLOWS]]


def _descend(worth: Callable[[Row], Row], members: Row, chance: np.random.Generator) -> None:
    """Go down from a hollow as long as some generations bring something."""
    from scipy.optimize import OptimizeResult, differential_evolution

    if len(members) < _FEWEST_MEMBERS:
        return
    least, idle = math.inf, 0

    def ended(intermediate_result: OptimizeResult) -> bool:
        nonlocal least, idle
        now = float(intermediate_result.fun)
        idle = 0 if now < least - SAME_WITHIN else idle + 1
        least = min(least, now)
        return idle >= _IDLE

    box = [(0.0, 1.0)] * members.shape[1]
    how = {"maxiter": _MOST_GENERATIONS, "tol": 0.0, "polish": False, "callback": ended}
    differential_evolution(worth, box, init=members, seed=chance, vectorized=True, updating="deferred", **how)


class _Rig:
    """Both controllers on many grounds at a time."""

    def __init__(self, scene: Scene, accuracy: float, equal: str) -> None:
        self.equal = equal
        recipe: Recipe = recipe_of_rows(scene, accuracy)
        lanes = why_no_lanes(scene.effects) is None and is_cached(scene.effects, lanes=True)
        self.recipe = replace(recipe, why_scalar=None) if lanes else recipe
        self.names = [parameter.name for parameter in compose(scene.effects).parameters]
        self.stiffness, self.damping = self.names.index("k_extension"), self.names.index(damping_of(scene))

    def jumps(self, table: Row, stiffness: Row, controller: NDArray[np.int64]) -> Block:
        """Return the last jump of each row, shape (rows, outputs), without an apex where the lifted foot never rose."""
        rows = table.copy()
        rows[:, self.stiffness] = stiffness
        rows[controller == _CE, self.damping] = 0.0
        found = simulate_on_all_cores(self.recipe, rows)[:, -1]
        found[found[:, PLACE["never_rose"]] > 0.0, PLACE["apex_height_m"]] = np.nan
        return found

    def judge(self, names: Sequence[str], points: Row, refused: Flags) -> Judged:
        """Judge grounds that differ in named parameters, shape (grounds, names)."""
        table = np.tile(self.recipe.base, (len(points), 1))
        table[:, [self.names.index(name) for name in names]] = points
        size = len(points)
        if refused.all():
            nothing, none = np.full(size, np.nan), ~refused
            none_j = np.zeros(size)
            return Judged(np.full(size, REFUSED), nothing, nothing, none, np.stack([nothing] * 2), none_j, none)
        found = self._judged(np.where(refused[:, np.newaxis], table[~refused][0], table))
        return replace(
            found,
            verdict=np.where(refused, REFUSED, found.verdict),
            saved_j=np.where(refused, np.nan, found.saved_j),
            saving=np.where(refused, np.nan, found.saving),
            not_positive=found.not_positive & ~refused,
        )

    def _judged(self, table: Row) -> Judged:
        size = len(table)
        stiffness = np.tile(table[:, self.stiffness], (2, 1))
        jumps = np.stack([self.jumps(table, stiffness[_CE], np.full(size, which)) for which in (_CE, _AD)])
        apex, slope = jumps[:, :, PLACE["apex_height_m"]].copy(), np.zeros(size)
        never_rose = jumps[:, :, PLACE["never_rose"]] > 0.0
        height = np.where(np.isfinite(apex), apex, -np.inf)
        no_jump = np.isneginf(height.max(axis=0) if self.equal == HEIGHT else height.min(axis=0))
        unequal = ~no_jump if self.equal == HEIGHT else np.zeros(size, np.bool_)
        for softer in (True, False):
            tuned = height.argmax(axis=0) if softer else height.argmin(axis=0)
            wanted = height.min(axis=0) if softer else height.max(axis=0)
            left = np.flatnonzero(unequal & np.isfinite(wanted))
            if left.size:
                which, bounds = tuned[left], (_LOWEST, 1.0) if softer else (1.0, _HIGHEST)
                ends = np.clip(np.outer(bounds, stiffness[0, left]), _STIFFNESS.low, _STIFFNESS.high)
                met, *found = self._reached(table[left], which, wanted[left], ends)
                at, which = left[met], which[met]
                unequal[at] = False
                stiffness[which, at], slope[at], jumps[which, at] = (values[met] for values in found)
        cost = jumps[:, :, PLACE["cost_J"]]
        under, ill, open_book = (
            (jumps[:, :, PLACE[flag]] > 0.0).any(axis=0) for flag in ("under_surface", "ill_conditioned", "open_book")
        )
        saved_j = cost[_CE] - cost[_AD]
        saving = 1.0 - np.divide(cost[_AD], cost[_CE], out=np.full(size, np.nan), where=cost[_CE] > 0.0)
        verdict = np.select(
            [
                no_jump & never_rose.any(axis=0),
                no_jump,
                under,
                ill | open_book,
                unequal,
                np.abs(saved_j) <= SAME_WITHIN * np.abs(cost[_CE]),
                saved_j < 0,
            ],
            [NEVER_ROSE, NO_JUMP, UNDER_SURFACE, FLAGGED, UNEQUAL, SAME, FAILS],
            SAVES,
        )
        stiffer: Flags = np.any(stiffness > table[:, self.stiffness], axis=0)
        says, not_positive = verdict < NO_JUMP, (cost <= 0.0).any(axis=0)
        saved_j, saving = (np.where(says, values, np.nan) for values in (saved_j, saving))
        return Judged(verdict, saved_j, saving, says & not_positive, stiffness, slope, stiffer)

    def _reached(self, table: Row, which: NDArray[np.int64], wanted: Row, ends: Row) -> tuple[Flags, Row, Row, Block]:
        """Halve the stiffnesses, in the logarithm, between which an apex is reached.

        Return whether the last two are close, and on the straight line between them stiffness, slope and jump.
        """
        low, high = ends
        below, above = (self.jumps(table, end, which) for end in ends)
        apex = PLACE["apex_height_m"]
        for _ in range(_HALVINGS):
            middle = np.sqrt(low * high)
            found = self.jumps(table, middle, which)
            enough = found[:, apex] >= wanted
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
            below, above = np.where(enough[:, np.newaxis], below, found), np.where(enough[:, np.newaxis], found, above)
        with np.errstate(invalid="ignore"):  # where one of both has no end, and neither is met
            change = above - below
            apart, rest = change[:, apex], wanted - below[:, apex]
            met = (rest >= 0.0) & (rest <= apart) & (apart <= _CLOSE_M)
            per_m = change / np.where(apart > 0.0, apart, 1.0)[:, np.newaxis]
            jump = below + per_m * rest[:, np.newaxis]
        stiffness = low * (high / low) ** np.where(apart > 0.0, rest / np.where(apart > 0.0, apart, 1.0), 0.0)
        return met, stiffness, per_m[:, PLACE["cost_J"]], jump


def region_of(searched: Searched) -> Region | None:
    """Return where the failures of half the sample lie, held against the other half; None where that has under five.

    Chance halves it: to every other point of a Sobol sample belongs the same half of the first parameter.
    """
    verdict, shares = searched.judged.verdict[: searched.sample], searched.shares[: searched.sample]
    mixed = np.random.default_rng(searched.sample).permutation(searched.sample)
    one, other = mixed[::2], mixed[1::2]
    failing = shares[one][verdict[one] == FAILS]
    if len(failing) < _FEWEST_FAILURES:
        return None
    low, high = failing.min(axis=0), failing.max(axis=0)
    within = ((shares[other] >= low) & (shares[other] <= high)).all(axis=1)
    says, fails = verdict[other] < NO_JUMP, verdict[other] == FAILS
    inside, outside = ((int((fails & part).sum()), int((says & part).sum())) for part in (within, ~within))
    return Region(tuple(low.tolist()), tuple(high.tolist()), inside, outside)


def counterexamples(question: Question, searched: Searched, most: int = _SHOWN) -> tuple[Counterexample, ...]:
    """Return the worst ground on which the claim fails and others far from it, each simulated with error bars and by
    another solver.
    """
    failing = searched.failing
    chosen = list(failing[:1])
    while 0 < len(chosen) < min(most, len(failing)):
        apart = np.linalg.norm(searched.shares[failing][:, np.newaxis] - searched.shares[chosen], axis=2).min(axis=1)
        if apart.max() == 0.0:
            break
        chosen.append(failing[np.argmax(apart)])
    return tuple(_confirmed(question, searched, int(place)) for place in chosen)


def ground_at(question: Question, shares: Sequence[float]) -> dict[str, float]:
    """Return the parameters at these shares of the ranges, by what the ranges name."""
    design = at_shares(question.over, question.scene.effects, np.array([shares]), 0)
    return {axis.name: float(axis.coordinates[0]) for axis in design.axes}


def _confirmed(question: Question, searched: Searched, place: int) -> Counterexample:
    shares = searched.shares[place]
    design = at_shares(question.over, question.scene.effects, shares[np.newaxis], 0)
    ground = dict(zip(question.names, design.rows(0, 1)[0].tolist(), strict=True))
    stiffness = tuple(searched.judged.stiffness[:, place].tolist())
    ad = question.scene.changed({**ground, "k_extension": stiffness[_AD]})
    ce = question.scene.changed({**ground, "k_extension": stiffness[_CE], question.damping: 0.0})
    jumps = tuple(simulate_with_errors(scene, question.sweep.accuracy).jump for scene in (ce, ad))
    bar_j = sum((jump.errors or {}).get("cost_J", math.inf) for jump in jumps)
    if question.equal == HEIGHT:
        apexes = [math.nan if jump.apex_height_m is None else jump.apex_height_m for jump in jumps]
        bar_j += abs(apexes[_AD] - apexes[_CE]) * abs(float(searched.judged.slope[place]))
    solved = [_by_other_solver(scene) for scene in (ce, ad)]
    solver_j = sum(
        math.inf if cost_j is None else abs(cost_j - jump.cost_J + jump.passive_J)
        for cost_j, jump in zip(solved, jumps, strict=True)
    )
    return Counterexample(
        ground_at(question, shares.tolist()),
        (stiffness[_CE], stiffness[_AD]),
        (jumps[_CE], jumps[_AD]),
        jumps[_AD].cost_J - jumps[_CE].cost_J,
        bar_j,
        solver_j if math.isfinite(solver_j) else None,
    )


def _by_other_solver(scene: Scene) -> float | None:
    attempt = METHODS[_SOLVER].prepare(scene, _SOLVER_ACCURACY, STOP_AFTER_TOUCHDOWN)
    try:
        attempt.run()
    except PeerGaveUp:
        return None
    return attempt.found().values["cost_J"]


def interval(count: int, of: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share (Wilson 1927); a Sobol sample knows it better."""
    from scipy.stats import binomtest

    if not of:
        return 0.0, 1.0
    found = binomtest(count, of).proportion_ci(method="wilson")
    return float(found.low), float(found.high)
