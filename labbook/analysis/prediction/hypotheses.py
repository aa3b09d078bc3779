"""Hypotheses of a study, each tested on what was measured and on what the simulator predicts for the same runs.

A hypothesis is split into comparisons; it holds where each of them does (an intersection-union test, Berger 1982: no
correction is needed), and fails where one fails, at a level divided by their number (Bonferroni). A comparison is of
means, in percent of the first, or of two savings, in percentage points.

That a treatment saves is asked by the first page, too: the answer is taken from there, with its p, its side and Holm's
family. All else is measured by the contrast that decides the study's comparisons: it holds where the interval lies
within the bounds, and fails where that of alpha / m lies outside. The interval has level 1 - 2 alpha (two one-sided
tests) of means, and that of `[analysis]` of savings. Simulated, two standard uncertainties of the prediction stand for
either interval; a parameter has one value in all conditions, so that its error cancels where it does in what is
compared.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparisons import Compared
from labbook.analysis.comparison.deciding import contrast_of, fingerprints_of_contrast
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.prediction.checking import (
    AllPredicted,
    accuracy_of,
    inputs_of,
    mean_of,
    side_of,
    values_of_side,
    varied_means,
)
from labbook.analysis.prediction.predicting import error_parts, in_quadrature
from labbook.analysis.prediction.simulating import SIMULATED
from labbook.analysis.results import Algorithm, Results, result_fingerprint
from labbook.config.model import AnalysisSettings, ClaimKind, HypothesisSettings, Side
from reports.numbers import Number
from reports.results import COVERAGE_FACTOR, Decision, Hypothesis, HypothesisPart, Verdict
from stats.days.contrasts import Effect, linear_contrast
from stats.days.decision import Contrast, Estimate

ALGORITHM = Algorithm("hypothesis", 4)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Conditions to compare: the second with the first, or the saving of the last two with that of the first two.

    `of` are the levels of what is compared, `against` those that differ in what it is compared with, none where that is
    the control. In percent, or percentage points, the claim is that it lies between `low` and `high`.
    """

    of: Mapping[str, str]
    against: Mapping[str, str]
    sides: tuple[tuple[ConditionValues, ...], ...]
    low: float = -math.inf
    high: float = math.inf

    @property
    def label(self) -> str:
        """Its name among a hypothesis's comparisons."""
        return pairing.group_label(self.of) + (f" against {pairing.group_label(self.against)}" if self.against else "")

    @property
    def pairs(self) -> list[Pair]:
        """The sides two by two."""
        return [Pair("", self.label, {}, "", a, b) for a, b in zip(self.sides[::2], self.sides[1::2], strict=True)]


def judge_hypotheses(
    computed: Results,
    hypotheses: Sequence[HypothesisSettings],
    conditions: Mapping[Outcome, Sequence[ConditionValues]],
    compared: Sequence[Compared],
    predicted: AllPredicted,
    swept: str,
    decided: AnalysisSettings,
    known: Mapping[str, Sequence[str]],
) -> tuple[Hypothesis, ...]:
    """Compute the test of every comparison of every hypothesis; `swept` is the factor with a control.

    `compared` are the study's comparisons, of which the first page claims whether each group saves. `known` has the
    labels of each factor, in whose order comparisons are returned.
    """
    claimed = {
        (item.shown.quantity, pairing.group_label(item.pair.group)): item
        for item in compared
        if item.pair.family == pairing.POOLED
    }
    found = []
    for settings in hypotheses:
        comparisons = comparisons_of(settings, conditions.get(settings.outcome, ()), swept)
        saves = settings.claim is ClaimKind.SAVES
        results = [
            _part(
                computed,
                settings,
                one,
                claimed[settings.outcome, pairing.group_label(one.of)] if saves else None,
                predicted,
                decided,
                len(comparisons),
            )
            for one in comparisons
        ]
        parts = sorted(results, key=lambda part: pairing.place(known, None, part.of))
        found.append(Hypothesis(settings.name, settings.text, settings.source, settings.published, tuple(parts)))
    return tuple(found)


def comparisons_of(settings: HypothesisSettings, conditions: Sequence[ConditionValues], swept: str) -> list[Comparison]:
    """Return what a hypothesis compares among the conditions; nothing where they lack what it needs."""
    if settings.claim is ClaimKind.SAME:
        return _between(settings, conditions, swept)
    groups = [
        (group, (tuple(control), tuple(treated)))
        for group, items in pairing.groups(conditions, swept)
        for treated, control in [pairing.treated_and_control(items)]
    ]
    if not all(side for _group, sides in groups for side in sides):  # a claim about all groups needs both in each
        return []
    if settings.claim is ClaimKind.NOT_LOWER:
        return [Comparison(group, {}, sides, low=-settings.within_percent) for group, sides in groups]
    if settings.claim is ClaimKind.SAVES:
        return [Comparison(group, {}, sides, high=0.0) for group, sides in groups]
    return _ordered(settings, groups)


def _between(settings: HypothesisSettings, conditions: Sequence[ConditionValues], swept: str) -> list[Comparison]:
    """Compare every level of a factor with the first, where all other factors have the same levels.

    Nothing is compared where a group lacks a level that the hypothesis names.
    """
    factor, within = settings.between, settings.within_percent
    side = [one for one in conditions if one.is_control is (settings.side is Side.CONTROL)]
    others = [name for name in pairing.other_factors(side, swept) if name != factor]
    found = []
    for group, items in pairing.by_levels(side, others):
        by_level = {of[factor]: tuple(each) for of, each in pairing.by_levels(items, [factor])}
        first, *further = settings.levels or sorted(by_level, key=pairing.sort_key)
        if not by_level.keys() >= {first, *further}:  # a level that is named was not measured: no comparison
            return []
        found += [
            Comparison({**group, factor: level}, {factor: first}, (by_level[first], by_level[level]), -within, within)
            for level in further
        ]
    return found


def _ordered(
    settings: HypothesisSettings,
    groups: Sequence[tuple[Mapping[str, str], tuple[tuple[ConditionValues, ...], tuple[ConditionValues, ...]]]],
) -> list[Comparison]:
    """Compare the saving of the group that is named with that of each other."""
    own = [(group, sides) for group, sides in groups if settings.group.items() <= group.items()]
    if len(own) != 1:
        return []
    [(group, sides)] = own
    largest = settings.claim is ClaimKind.LARGEST_SAVING
    low, high = (0.0, math.inf) if largest else (-math.inf, 0.0)
    return [
        Comparison(group, other, (*other_sides, *sides), low, high) for other, other_sides in groups if other != group
    ]


def _part(
    computed: Results,
    settings: HypothesisSettings,
    one: Comparison,
    claimed: Compared | None,
    predicted: AllPredicted,
    decided: AnalysisSettings,
    n_comparisons: int,
) -> HypothesisPart:
    outside = decided.outside if len(one.sides) > 2 else 2.0 * decided.alpha
    simulated = predicted if settings.outcome in SIMULATED else {}
    inputs = [row for pair in one.pairs for row in fingerprints_of_contrast(pair)]
    if claimed is not None:
        inputs.append(result_fingerprint("test", claimed.shown.decision))
        inputs += [] if claimed.family is None else [result_fingerprint("family", claimed.family)]
    if simulated:
        inputs += [row for side in one.sides for row in inputs_of("predicted", side_of(side, simulated))]
    return computed.record(
        ALGORITHM,
        {"hypothesis": settings.name, "label": one.label, "quantity": str(settings.outcome)},
        dict.fromkeys(inputs),
        _tested(one, simulated, settings.outcome, outside, n_comparisons, claimed),
        {
            "claim": str(settings.claim),
            "bounds": [None if math.isinf(end) else end for end in (one.low, one.high)],
            "outside": outside,
            "comparisons": n_comparisons,
        },
    )


def _tested(
    one: Comparison,
    predicted: AllPredicted,
    outcome: Outcome,
    outside: float,
    n_comparisons: int,
    claimed: Compared | None = None,
) -> HypothesisPart:
    """Test a comparison whose interval leaves out `outside`; where the first page claims it, as it does."""
    if claimed is None:
        contrasts = [contrast_of(pair) for pair in one.pairs]
        (measured, no_interval), (strict, _) = (_measured(contrasts, 1.0 - outside / m) for m in (1, n_comparisons))
        verdict = _verdict(one, (measured.ci_low, measured.ci_high), (strict.ci_low, strict.ci_high))
    else:
        measured, no_interval = _as_claimed(claimed.shown.decision)
        verdict = _verdict_of_claim(claimed.shown.decision, 0.5 * outside / n_comparisons)
    simulated = _simulated(one, predicted, outcome)
    ends = _ends(simulated)
    return HypothesisPart(
        one.of,
        one.against,
        measured,
        simulated,
        verdict,
        _verdict(one, ends, ends),
        None if math.isinf(one.low) else one.low,
        None if math.isinf(one.high) else one.high,
        no_interval,
        savings=len(one.sides) > 2,
    )


def _verdict(one: Comparison, holding: tuple[Any, Any], failing: tuple[Any, Any]) -> Verdict:
    """Judge by both intervals; an end that does not exist decides nothing."""
    if all(isinstance(end, float) for end in holding) and one.low < holding[0] and holding[1] < one.high:
        return Verdict.HOLDS
    if all(isinstance(end, float) for end in failing) and (failing[1] <= one.low or failing[0] >= one.high):
        return Verdict.FAILS
    return Verdict.CANNOT_TELL


def _as_claimed(claimed: Decision) -> tuple[Number, Undefined | None]:
    """Return the change in percent that is less the saving of a claim; beside it why it has no interval."""
    saving = claimed.savings
    assert saving is not None  # noqa: S101 - only outcomes with savings are claimed to be saved
    value = saving.value if isinstance(saving.value, Undefined) else -saving.value
    low, high = saving.ci_low, saving.ci_high
    if not isinstance(low, float) or not isinstance(high, float):
        reasons = [each for each in (value, claimed.t.value) if isinstance(each, Undefined)]
        why = reasons[0] if reasons else Undefined(Reason.CONTROL_NEAR_ZERO)
        return Number(value, "%", ci_level=saving.ci_level, n=saving.n), why
    return replace(saving, value=value, ci_low=-high, ci_high=-low, provenance=""), None


def _verdict_of_claim(claimed: Decision, alpha: float) -> Verdict:
    """Return what the claim of the first page says of "it saves"; where it was one-sided, a cost is one at alpha."""
    saving = claimed.savings
    if claimed.shown is None or saving is None or not isinstance(saving.value, float):
        return Verdict.CANNOT_TELL
    if claimed.shown:
        return Verdict.HOLDS if saving.value > 0.0 else Verdict.FAILS
    p = claimed.p.value
    cost = claimed.one_sided and isinstance(p, float) and 1.0 - p <= alpha
    return Verdict.FAILS if cost else Verdict.CANNOT_TELL


def _measured(contrasts: Sequence[Contrast], level: float) -> tuple[Number, Undefined | None]:
    """Return the change of the second mean in percent of the first, or the last saving less the first, in points.

    Beside it stands why it has no interval.
    """
    n = sum(sum(contrast.n) for contrast in contrasts)
    found = contrasts[0].savings(level) if len(contrasts) == 1 else _less_saving(contrasts[0], contrasts[1], level)
    value = found.value if isinstance(found.value, Undefined) else -found.value
    if isinstance(found.ci, Undefined):
        return Number(value, "%", ci_level=level, n=n), found.ci
    low, high = found.ci
    return Number(value, "%", found.se, found.shared_se, -high, -low, level, df=found.df, n=n), None


def _less_saving(other: Contrast, own: Contrast, level: float) -> Estimate:
    """Return the saving of the first contrast less that of the second."""
    runs = {"other": other.runs.treated, "its control": other.runs.control}
    runs |= {"own": own.runs.treated, "own control": own.runs.control}
    effects = [Effect(1.0, "other", "its control"), Effect(-1.0, "own", "own control")]
    return linear_contrast(runs, effects, percent=True, level=level).estimate


def _simulated(one: Comparison, predicted: AllPredicted, outcome: Outcome) -> Number:
    """Return the same of the predictions for the runs as they were made, with its standard uncertainty."""
    if not predicted:
        return Number(Undefined(Reason.NOT_SIMULATED), "%")
    sides = [side_of(side, predicted) for side in one.sides]
    value = _compared([mean_of(values_of_side(side, outcome)) for side in sides])
    if value is None:
        ends = sorted({each.outcome for side in sides for each, _runs in side if each.value(outcome) is None})
        return Number(Undefined(Reason.SIMULATED_ENDS_OTHERWISE, ends=", ".join(ends)), "%")
    error = math.sqrt(len(sides)) * accuracy_of(sides) * 100.0
    return Number(value, "%", se=in_quadrature(error_parts(value, error, varied_means(sides, outcome, _compared))))


def _compared(means: Sequence[float | None]) -> float | None:
    known = [mean for mean in means if mean is not None]
    if len(known) < len(means) or any(mean <= 0.0 for mean in known[::2]):
        return None
    changes = [100.0 * (b / a - 1.0) for a, b in zip(known[::2], known[1::2], strict=True)]
    return changes[0] if len(changes) == 1 else changes[0] - changes[1]


def _ends(simulated: Number) -> tuple[float | None, float | None]:
    value, se = simulated.value, simulated.se
    if not isinstance(value, float) or not isinstance(se, float):
        return None, None
    return value - COVERAGE_FACTOR * se, value + COVERAGE_FACTOR * se
