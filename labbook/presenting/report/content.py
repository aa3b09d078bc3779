"""Making a report: analyse the selected runs and fill the content of the page."""

from __future__ import annotations

import importlib.metadata
import json
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import TYPE_CHECKING

import sqlalchemy as sa

from data_schema import journal
from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries.history import void_reasons
from data_schema.queries.runs import RunRow
from data_schema.queries.study import (
    CheckRow,
    FactorRow,
    PlannedRow,
    checks_by_day,
    people,
    planned_runs,
    withdrawn_names,
)
from data_schema.vocabulary import ReasonCode, Rule, RunKind, RunState, StudyKind, Undefined, Verdict
from data_schema.where import names_in, parse
from ingest.store import Store
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.deciding import deciding_runs, runs_of
from labbook.analysis.comparison.order import ADJUSTED, OVER_GROUPS
from labbook.analysis.comparison.pairing import place, study_factor
from labbook.analysis.outcomes.conditions import ConditionValues, coarse_scatter
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import Judgement
from labbook.analysis.outcomes.run_energy import RunEnergy, only_charge_missing
from labbook.analysis.prediction.condition_scenes import study_scene, unconverted_factors
from labbook.analysis.prediction.predicting import PredictionResult
from labbook.analysis.preregistration.departures import first_named
from labbook.analysis.preregistration.planned import decision_sentences, departure_sentences
from labbook.analysis.results import Results, numbers_of
from labbook.analysis.study import StudyAnalysis, analyse
from labbook.analysis.study_data import gather
from labbook.config.model import SimulationSettings
from labbook.config.parsing import Configuration
from labbook.presenting.report import methods
from reports.claims import family_claim, group_claim, overall_claims
from reports.content import (
    POOLED,
    AssumedInput,
    Claim,
    CoarseCharger,
    Comparison,
    Condition,
    Day,
    Drain,
    Factor,
    Favoured,
    Flow,
    Hypothesis,
    Judged,
    Level,
    OverallEquivalence,
    OverallSavings,
    PredictedQuantity,
    Prediction,
    Predictions,
    Provenance,
    ReportContent,
    Run,
)
from reports.display import in_sentence, list_text
from reports.naming import levels_name
from reports.numbers import Number, Result, Value
from reports.tables.contrasts import contrast_claims
from stats.apexes.detectors import DETECTORS
from stats.days.order import PositionsCompared

if TYPE_CHECKING:
    from simulator.steady.published_results import PublishedResult


def _claims(content: ReportContent, compared: Sequence[Comparison], *, one_level: bool) -> tuple[Claim, ...]:
    """One sentence over all groups, or one a pooled comparison, outcome by outcome.

    Where another family was decided on, what that shows comes before all of them, but for one group of one level, whose
    claims are of that family.
    """
    planned = [item for item in compared if item.family != pairing.POOLED and item.decision.adjusted is not None]
    if one_level and len(planned) == len({item.quantity for item in planned}):
        planned = []  # one group, whose claims are those of the family
    over_groups = overall_claims(content)
    claimed = {outcome for outcome, _claim in over_groups}
    wanted = {Outcome.JOULES, Outcome.APEX} - claimed if over_groups else set(Outcome)
    narrow = [
        (item.quantity, group_claim(content, item)) for item in compared if item.opens and item.quantity in wanted
    ]
    opening = [family_claim(content, planned, pooled=not one_level)] if planned else []
    by_outcome = sorted((*over_groups, *narrow), key=lambda each: list(Outcome).index(each[0]))
    return (*opening, *(claim for _outcome, claim in by_outcome), *contrast_claims(content))


def _warned(content: ReportContent, claims: tuple[Claim, ...]) -> tuple[Claim, ...]:
    """Say behind the first claim that it cannot stand without what is said of order or charger below."""
    why = [
        *(["the order within days"] if content.favoured else []),
        *(["the charger's step"] if content.coarse_charger is not None else []),
    ]
    if not why or not claims:
        return claims
    first = replace(claims[0], text=f"{claims[0].text} Read with what is said of {' and '.join(why)} below.")
    return (first, *claims[1:])


@dataclass(frozen=True, slots=True)
class MadeReport:
    """A report's content, and the results that it is of."""

    content: ReportContent
    analysis: StudyAnalysis
    computed: Results

    @property
    def shown(self) -> tuple[str, ...]:
        """The ids of the numbers that it shows."""
        return tuple(one.id for one in self.content.provenance)

    @property
    def versions(self) -> dict[str, int]:
        """The versions of the algorithms that made it, those of all detectors among them, by name."""
        used = {one.origin.kind: one.origin.version for one in self.computed.made.values()}
        return {**dict(sorted(used.items())), **{name: detector.version for name, detector in DETECTORS.items()}}


def make_report(
    connection: sa.Connection,
    store: Store,
    configuration: Configuration,
    *,
    where: str | None,
    made_at: str,
    progress: Callable[[str], None] = lambda _what: None,
    level: float | None = None,
) -> MadeReport:
    """Analyse the selected runs, with intervals as planned or of a `level`; needs no lock and stores nothing."""
    evidence = gather(connection, configuration, where)
    computed = Results()
    detections = Detections(connection, store, progress)
    analysis = analyse(computed, detections, evidence, progress, level)
    detector = evidence.configuration.protocol.detector
    void = [run for run in evidence.selected if run.state is RunState.VOID]
    compared = comparisons(analysis)
    bare = ReportContent(
        title=f"Report on {evidence.study.name}",
        study=evidence.study.name,
        selection=evidence.selection,
        made_at=made_at,
        software_version=importlib.metadata.version("robot-labbook"),
        configuration_hash=evidence.configuration.sha256[:12],
        detector=f"{detector}, version {DETECTORS[detector].version}",
        people=tuple(people(connection)),
        days=days(analysis, checks_by_day(connection)),
        flow=flow(analysis, planned_runs(connection), withdrawn_names(connection)),
        factors=factors(analysis),
        conditions=conditions(analysis),
        claims=(),
        comparisons=compared,
        contrasts=tuple(analysis.contrasts),
        overall=overall(analysis),
        overall_equivalence=overall_equivalence(analysis),
        anovas=tuple(analysis.anovas),
        drains=drains(analysis),
        budget=analysis.budget,
        packs=analysis.packs,
        confounded=tuple(confounded_with_day(analysis)),
        variations=analysis.variations.varied,
        methods=methods.methods(analysis),
        sources=methods.sources(analysis),
        limitations=methods.limitations(analysis),
        outside_limits=methods.outside_limits(analysis),
        exchanged_charges=methods.exchanged_charges(analysis),
        assumed=methods.assumed(analysis),
        robots=runs_by_robot(analysis),
        runs=runs(analysis),
        predictions=predictions(analysis),
        hypotheses=hypotheses(analysis),
        planned=analysis.planned.stated,
        decided=decision_sentences(analysis.planned),
        run_before=analysis.planned.run_before or "",
        departures=departure_sentences(analysis.planned),
        departed=len(analysis.planned.departures),
        void=void_sentence(void, void_reasons(connection, [run.uid for run in void])),
        look=analysis.planned.look,
        without_charges=groups_without_charges(analysis),
        favoured=favoured(analysis),
        coarse_charger=coarse_charger(analysis),
        entry=journal.head(connection)[0],
        no_equivalence=no_equivalence(analysis),
    )
    used = ("numpy", "scipy", "matplotlib", *(("numba",) if bare.predictions.items else ()))
    content = replace(
        bare,
        software=tuple((name, importlib.metadata.version(name)) for name in used),
        limitations=(*robot_limitations(analysis, bare), *bare.limitations),
        claims=_warned(bare, _claims(bare, compared, one_level=one_level(analysis))),
    )
    shown = dict.fromkeys(number.provenance for number in shown_numbers(content))
    return MadeReport(replace(content, provenance=provenance(shown, computed)), analysis, computed)


def factors(analysis: StudyAnalysis) -> tuple[Factor, ...]:
    """Return the study's factors with the formulas that turn gains into physical values."""
    return tuple(study_factor(analysis.evidence.configuration, row.name) for row in _considered(analysis))


def factor_title(analysis: StudyAnalysis, name: str) -> str:
    """Return what a factor is called in text: its title in labbook.toml, or its name."""
    return study_factor(analysis.evidence.configuration, name).title


def _considered(analysis: StudyAnalysis) -> list[FactorRow]:
    """Leave out what labbook.toml no longer names and no condition has: a name that was mistyped at first."""
    measured = {name for several in analysis.conditions.values() for item in several for name in item.levels}
    named = analysis.evidence.configuration.factors.keys() | measured
    return [row for row in analysis.evidence.factors if row.name in named]


def conditions(analysis: StudyAnalysis) -> tuple[Condition, ...]:
    """Return every condition that has a measured quantity, in the order of the factors' levels, the swept one last.

    So the control and the treated conditions of one group stand together.
    """
    measured = {outcome: {item.key: item for item in several} for outcome, several in analysis.conditions.items()}
    every = {key: item for items in measured.values() for key, item in items.items()}
    known = {row.name: [level.label for level in row.levels] for row in analysis.evidence.factors}
    ordered = sorted(every.values(), key=lambda item: place(known, analysis.swept, item.levels))
    return tuple(
        Condition(
            levels=_levels(analysis, item.levels),
            control=item.is_control,
            summaries={outcome: items[item.key].result for outcome, items in measured.items() if item.key in items},
        )
        for item in ordered
    )


def _levels(analysis: StudyAnalysis, labels: Mapping[str, str]) -> tuple[Level, ...]:
    gains = analysis.evidence.configuration.gains
    found = []
    for row in analysis.evidence.factors:
        level = next((level for level in row.levels if level.label == labels.get(row.name)), None)
        if level is None:
            continue
        gain = gains.get(row.name)
        if gain is not None and level.value is not None:
            found.append(Level(row.name, level.label, gain.physical(level.value), gain.unit, level.value))
            continue
        radius_m = json.loads(level.attributes_json).get("radius_m")
        unit = study_factor(analysis.evidence.configuration, row.name).unit
        found.append(Level(row.name, level.label, *((level.value, unit) if radius_m is None else (radius_m, "m"))))
    return tuple(found)


def runs(analysis: StudyAnalysis) -> dict[str, Run]:
    """Return the analysed runs by name."""
    used = {item.run.uid: item.run for several in analysis.conditions.values() for one in several for item in one.runs}
    return {run.name: _run(run, analysis.judgements.get(uid)) for uid, run in used.items()}


def _run(run: RunRow, judged: Judgement | None) -> Run:
    heights = [(jump.number, jump.apex_height_m) for jump in judged.counted] if judged is not None else []
    known = {number: height_m for number, height_m in heights if height_m is not None}
    return Run(run.day, run.position_in_day, run.battery, run.robot, known)


def days(analysis: StudyAnalysis, checks: Mapping[str, Sequence[CheckRow]]) -> tuple[Day, ...]:
    """Return what was measured on each day, and which checks were made before."""
    listed = analysis.evidence.configuration.protocol.checks
    found = []
    for date, runs in grouped(analysis.evidence.selected, lambda run: run.day).items():
        made = [check.kind for check in checks.get(date, ()) if check.passed]
        found.append(
            Day(
                date=date,
                runs=tuple(run.name for run in runs),
                conditions=tuple(sorted({run.condition_key for run in runs if run.condition_key})),
                packs=tuple(sorted({run.battery for run in runs})),
                checks_made=tuple(made),
                checks_not_made=tuple(kind for kind in listed if kind not in made),
            )
        )
    return tuple(found)


def flow(analysis: StudyAnalysis, planned: Sequence[PlannedRow], withdrawn: Collection[str] = ()) -> Flow:
    """Count runs and jumps from the plan to the numbers; of a selection by factors, planned runs of its conditions."""
    selected = analysis.evidence.selected
    jump_runs = analysis.evidence.runs
    used = {
        outcome: {one.run.uid for condition in conditions for one in condition.runs}
        for outcome, conditions in analysis.conditions.items()
    }
    with_heights = [run for run in jump_runs if run.uid in used[Outcome.APEX]]
    judged = [item for run in with_heights for item in analysis.judgements[run.uid].jumps]
    jumps_excluded = Counter(item.excluded for item in judged if item.excluded is not None)
    analysed = [item for item in judged if item.excluded is None]
    decided = [item.decision for item in analysed if item.decision is not None]
    with_the_rest = sum(one.reason_code is ReasonCode.WITH_THE_REST for one in decided)
    rejected = [one for item in judged if (one := item.decision) is not None and one.verdict is Verdict.REJECT]
    return Flow(
        runs_planned=_planned_count(analysis, planned) or None,
        runs_done=len(selected),
        runs_void=sum(run.state is RunState.VOID for run in selected),
        runs_idle=sum(run.kind is RunKind.IDLE and run.state is not RunState.VOID for run in selected),
        runs_other=Counter(
            f"{run.kind} run"
            for run in selected
            if run.kind not in (RunKind.JUMPS, RunKind.IDLE) and run.state is not RunState.VOID
        ),
        runs_with={outcome: len(runs) for outcome, runs in used.items()},
        runs_without={
            outcome: Counter(
                missing[run.uid].reason if run.uid in missing else outcome.undefined_because
                for missing in [analysis.results[outcome].missing]
                for run in jump_runs
                if run.uid not in runs
            )
            for outcome, runs in used.items()
        },
        jumps_made=sum(run.jumps_made for run in with_heights),
        jumps_detected=len(judged),
        jumps_excluded=dict(jumps_excluded),
        jumps_analysed=len(analysed),
        runs_withdrawn=0 if analysis.evidence.selection else len(withdrawn),
        jumps_reviewed=len(decided) - with_the_rest,
        jumps_with_the_rest=with_the_rest,
        jumps_rejected=len(rejected),
        verdicts_blind=sum(one.blind for one in (*decided, *rejected)),
    )


def _planned_count(analysis: StudyAnalysis, planned: Sequence[PlannedRow]) -> int:
    """Count the plan's runs; those of a selection are known where it is by factors alone, which the plan has too."""
    selection = analysis.evidence.selection
    if not selection:
        return len(planned)
    if not names_in(parse(selection)) <= {row.name for row in analysis.evidence.factors}:
        return 0
    conditions = {run.condition_key for run in analysis.evidence.selected}
    return sum((row.condition_key or "") in conditions for row in planned)


def confounded_with_day(analysis: StudyAnalysis) -> list[str]:
    """Say which factors are confounded with the day, because most days saw one level of them only.

    A day with a single run shows nothing of the kind and does not count.
    """
    runs = [run for run in analysis.evidence.runs if run.levels]
    days_of = [of_day for of_day in grouped(runs, lambda run: run.day).values() if len(of_day) > 1]
    sentences, named = [], set()
    for factor in analysis.evidence.factors:
        levels = {run.levels.get(factor.name) for run in runs}
        single = sum(len({run.levels.get(factor.name) for run in of_day}) == 1 for of_day in days_of)
        if len(levels) > 1 and 2 * single > len(days_of):
            named.add(factor.name)
            title = in_sentence(factor_title(analysis, factor.name))
            sentences.append(
                f"On {single} of the {len(days_of)} days with two or more runs all runs had one level of the {title}: "
                f"differences between its levels are {_confounded(single, len(days_of))} differences between days."
            )
    swept = analysis.swept
    if swept is not None and swept not in named and any(run.is_control for run in runs):
        without = sum(not any(run.is_control for run in of_day) for of_day in days_of)
        if 2 * without > len(days_of):
            sentences.append(
                f"On {without} of the {len(days_of)} days with two or more runs there was no control run: differences "
                f"from the control are {_confounded(without, len(days_of))} differences between days."
            )
    return sentences


def _confounded(count: int, days: int) -> str:
    return "confounded with" if count == days else "largely confounded with"


def runs_by_robot(analysis: StudyAnalysis) -> dict[str, int]:
    """Count the analysed runs of each robot, in the order in which the robots were used."""
    used = {uid for found in analysis.results.values() for uid in found.results}
    return dict(Counter(run.robot for run in analysis.evidence.runs if run.uid in used))


def robot_limitations(analysis: StudyAnalysis, content: ReportContent) -> tuple[str, ...]:
    """Say in which groups the control and the treated runs are not of the same robots; `content` names groups."""
    found = []
    for item in analysis.compared:
        if item.pair.family != pairing.POOLED:
            continue
        control, treated = _robots(item.pair.a), _robots(item.pair.b)
        if control.keys() != treated.keys():
            name = levels_name(content, item.pair.group)
            found.append(
                f"{f'With {name}' if name else 'In this selection'} the control runs are of {_listed(control)} and the "
                f"treated runs of {_listed(treated)}: the differences may be the robots'."
            )
    return tuple(dict.fromkeys(found))


def _robots(side: Iterable[ConditionValues]) -> Mapping[str, int]:
    return Counter(item.run.robot for condition in side for item in condition.runs)


def _listed(robots: Mapping[str, int]) -> str:
    return list_text([f"{robot} ({runs})" for robot, runs in robots.items()])


def comparisons(analysis: StudyAnalysis) -> tuple[Comparison, ...]:
    """Return all comparisons; those of savings without a claim name the runs whose charge would give one."""
    without_charge = only_charge_missing(analysis.evidence.runs, analysis.evidence.charges)
    found = []
    for item in analysis.compared:
        one, decision = item.shown, item.shown.decision
        if decision.rule is Rule.NONE and item.pair.family == pairing.POOLED and one.quantity.has_savings:
            group = item.pair.group.items()
            missing = deciding_runs(
                [number.run for side in (item.pair.a, item.pair.b) for number in runs_of(side)],
                [run for run in without_charge if group <= run.levels.items()],
            )
            one = replace(one, decision=replace(decision, charge_missing=tuple(run.name for run in missing)))
        found.append(one)
    return tuple(found)


def one_level(analysis: StudyAnalysis) -> bool:
    """Tell whether each group has one treated level, so that its comparison and that of all levels are the same."""
    pooled = [item.pair for item in analysis.compared if item.pair.family == pairing.POOLED]
    return bool(pooled) and all(len(pair.b) == 1 for pair in pooled)


def overall(analysis: StudyAnalysis) -> tuple[OverallSavings, ...]:
    """Return the savings over all groups."""
    return tuple(
        replace(result, exploratory=analysis.planned.exploratory(outcome, pairing.POOLED) or "")
        for outcome, result in analysis.overall.savings.items()
    )


def overall_equivalence(analysis: StudyAnalysis) -> OverallEquivalence | None:
    """Return the test over all groups that apex heights changed within the bounds."""
    result = analysis.overall.equivalent
    if result is None:
        return None
    return replace(result, exploratory=analysis.planned.exploratory_equivalence(pairing.POOLED) or "")


def favoured(analysis: StudyAnalysis) -> tuple[Favoured, ...]:
    """Return the headlines that the order within days favours, adjusted: that over all groups, else those of groups."""
    tests = analysis.favoured
    if OVER_GROUPS in tests:
        effects = analysis.overall_adjusted
        adjusted = {outcome: result.savings for outcome, result in effects.savings.items()}
        if effects.equivalent is not None:
            adjusted[Outcome.APEX] = effects.equivalent.estimate
        return (_favoured(None, tests[OVER_GROUPS], adjusted),)
    pooled = {item.pair.label: item.pair for item in analysis.compared if item.pair.family == pairing.POOLED}
    return tuple(
        _favoured(
            pair.group,
            tests[pairing.group_label(pair.group)],
            {
                varied.quantity: varied.result.headline
                for varied in analysis.variations.varied
                if varied.variant == ADJUSTED and varied.headline == label
            },
        )
        for label, pair in pooled.items()
        if pairing.group_label(pair.group) in tests
    )


def _favoured(group: Mapping[str, str] | None, test: PositionsCompared, adjusted: Mapping[Outcome, Number]) -> Favoured:
    claimed = {outcome: adjusted[outcome] for outcome in (Outcome.JOULES, Outcome.APEX) if outcome in adjusted}
    return Favoured(group, test, claimed)


def groups_without_charges(analysis: StudyAnalysis) -> tuple[tuple[Mapping[str, str], tuple[str, ...]], ...]:
    """Return the groups in which no control, or nothing beside it, has a charge, with the runs that lack theirs."""
    compared = {
        pairing.group_label(item.pair.group)
        for item in analysis.compared
        if item.pair.family == pairing.POOLED and item.shown.quantity is Outcome.JOULES
    }
    swept = [run for run in analysis.evidence.runs if analysis.swept in run.levels]
    groups = grouped(swept, lambda run: pairing.group_label(_without_swept(analysis, run)))
    return tuple(
        (_without_swept(analysis, runs[0]), names)
        for label, runs in groups.items()
        if label not in compared and len({run.is_control for run in runs}) == 2
        for names in [tuple(run.name for run in only_charge_missing(runs, analysis.evidence.charges))]
        if names
    )


def _without_swept(analysis: StudyAnalysis, run: RunRow) -> dict[str, str]:
    return {name: label for name, label in run.levels.items() if name != analysis.swept}


def drains(analysis: StudyAnalysis) -> tuple[Drain, ...]:
    """Return the passive drain of each robot that has a line."""
    return tuple(drain for drain in analysis.drains.values() if not isinstance(drain.line, Undefined))


def coarse_charger(analysis: StudyAnalysis) -> CoarseCharger | None:
    """Return the charger's step and the scatter of charges where that is below half a step; None where it is not."""
    runs = [item for condition in analysis.conditions[Outcome.JOULES] for item in condition.runs]
    scatter = coarse_scatter(runs)
    if scatter is None:
        return None
    step_mah = max(item.result.step_mah for item in runs if isinstance(item.result, RunEnergy))
    return CoarseCharger(step_mah, scatter * step_mah)


def predictions(analysis: StudyAnalysis) -> Predictions:
    """Return what was predicted; nothing where the study names no scene or has nothing measured."""
    settings = analysis.evidence.configuration.simulation
    found = list(analysis.predicted.values())
    if settings is None or not found:
        return Predictions()
    from simulator.declared import all_parameters

    items = tuple(replace(item, published=_published(analysis, item)) for item in _in_order(analysis))
    measured = {name for several in analysis.conditions.values() for item in several for name in item.levels}
    mapped = {*settings.factors, *settings.levels}
    return Predictions(
        scene=found[0].scene,
        accuracy=settings.accuracy,
        effects=found[0].effects,
        unmapped=tuple(
            factor_title(analysis, row.name)
            for row in analysis.evidence.factors
            if row.name in measured and row.name not in mapped
        ),
        unconverted=unconverted_factors(analysis.evidence.configuration, analysis.evidence.factors),
        units={factor: all_parameters()[name].unit for factor, name in settings.factors.items()},
        items=items,
        judged=_judged(analysis),
        assumed=_assumed(analysis, settings),
        branched=_conditions(analysis, lambda one: one.branched),
        on_edge=_conditions(analysis, lambda one: one.close_decision and not one.branched),
        grown=_conditions(analysis, lambda one: one.relative_error > one.accuracy),
        under_surface=_conditions(analysis, lambda one: one.under_surface),
        open_book=_conditions(analysis, lambda one: one.open_book),
        ends_otherwise=_conditions(analysis, lambda one: one.ends_otherwise),
    )


def hypotheses(analysis: StudyAnalysis) -> tuple[Hypothesis, ...]:
    """Return the study's hypotheses, each with its comparisons in the order of groups."""
    return tuple(
        replace(one, parts=tuple(sorted(one.parts, key=lambda part: _place(analysis, part.of))))
        for one in analysis.hypotheses
    )


def _conditions(analysis: StudyAnalysis, holds: Callable[[PredictionResult], bool]) -> int:
    """Count the conditions for which something holds of the prediction with any robot."""
    return len({key for (key, _robot), one in analysis.predicted.items() if holds(one)})


def _in_order(analysis: StudyAnalysis) -> list[Prediction]:
    """Sort as conditions are shown: by the factors' levels, the swept one last, what is pooled after its levels."""
    swept = [level.label for row in analysis.evidence.factors if row.name == analysis.swept for level in row.levels]

    def place(item: Prediction) -> tuple[int, list[int], int]:
        level = swept.index(item.level) if item.level in swept else len(swept)
        return list(PredictedQuantity).index(item.quantity), _place(analysis, item.group), level

    return sorted(analysis.checked, key=place)


def _place(analysis: StudyAnalysis, group: Mapping[str, str]) -> list[int]:
    """Return where a group stands among all, by the levels of each factor that is not swept."""
    labels = {row.name: [level.label for level in row.levels] for row in analysis.evidence.factors}
    return [
        known.index(group[name]) if name in group else -1 for name, known in labels.items() if name != analysis.swept
    ]


_WITH_FOOT = {StudyKind.BED: True, StudyKind.EMULATOR: False}
"""Studies of which single conditions are published, and whether a foot was varied."""


def _published(analysis: StudyAnalysis, item: Prediction) -> PublishedResult | None:
    """Return what the thesis has of the apex or saving at these gains, and on the bed with this foot, if anything."""
    from simulator.steady.published_results import result_of

    configuration, swept = analysis.evidence.configuration, analysis.swept
    factors = {} if configuration.simulation is None else configuration.simulation.factors
    of_parameter = {parameter: factor for factor, parameter in factors.items()}
    gain, foot = of_parameter.get("k_extension", ""), of_parameter.get("foot_radius", "")
    if _WITH_FOOT.get(configuration.study.kind) is not (foot in item.group):
        return None
    if swept is None or of_parameter.get("b_ad") != swept or not {gain, swept} <= configuration.gains.keys():
        return None
    of_apex = item.quantity is PredictedQuantity.APEX
    if not (of_apex or item.quantity is PredictedQuantity.SAVINGS) or not item.group.keys() <= {gain, foot}:
        return None
    of_group = [one for one in analysis.conditions[Outcome.JOULES] if item.group.items() <= one.levels.items()]
    pooled = [one.levels[swept] for one in of_group if not one.is_control]
    damping_gains = tuple(sorted(map(float, pooled if item.level == POOLED else [item.level])))
    return result_of(item.group.get(foot, ""), float(item.group[gain]), damping_gains, of_apex=of_apex)


def _judged(analysis: StudyAnalysis) -> tuple[Judged, ...]:
    return tuple(
        replace(one, groups=tuple(sorted(one.groups, key=lambda each: _place(analysis, each.group))))
        for one in analysis.biases
    )


def _assumed(analysis: StudyAnalysis, settings: SimulationSettings) -> tuple[AssumedInput, ...]:
    """Return every assumed input, with the most that varying it changed in any condition; robots may have their own."""
    study = analysis.evidence.configuration.study.name
    fitted = {name for name, value in study_scene(settings).values.items() if value.fitted_to == study}
    predicted = analysis.predicted.values()
    inputs = {(name, about.value): about for one in predicted for name, about in one.assumed.items()}
    return tuple(
        AssumedInput(
            name,
            about,
            {quantity: _most(analysis, quantity, name) for quantity in PredictedQuantity},
            fitted=name in fitted,
        )
        for (name, _value), about in sorted(inputs.items(), key=lambda item: item[0])
    )


def _most(analysis: StudyAnalysis, quantity: PredictedQuantity, source: str) -> Value | None:
    """Return the largest part of an error by a source; undefined where one of them is, None where there is none."""
    checks = [item.check.errors for item in analysis.checked if item.quantity is quantity]
    values = [errors[source].value for errors in checks if source in errors]
    undefined = next((value for value in values if isinstance(value, Undefined)), None)
    if undefined is not None:
        return undefined
    return max((value for value in values if isinstance(value, float)), default=None)


def void_sentence(void: Sequence[RunRow], reasons: Mapping[str, str]) -> str:
    """Name runs that are void by the `reasons` (by uid); "" without one."""
    by_reason = grouped(void, lambda run: reasons.get(run.uid, ""))
    listed = [f"{first_named([run.name for run in runs])} ({reason})" for reason, runs in by_reason.items()]
    return f"Void: {'; '.join(listed)}." if listed else ""


def no_equivalence(analysis: StudyAnalysis) -> str:
    """Say why apex heights are not tested for equality, and how that is asked for; "" where they are."""
    compared = any(item.shown.quantity.has_equivalence for item in analysis.compared)
    if not compared or analysis.planned.settings.apex_bounds is not None:
        return ""
    return (
        "That a difference of apex height is not told from zero does not show that heights are equal. No test of "
        "equivalence is made, because labbook.toml states no bounds within which a difference counts as none: write, "
        "before the first run, `apex_bounds_percent = [-3, 3]` (of the control's mean) or `apex_bounds_m = [-0.005, "
        "0.005]` under [analysis]."
    )


_PLAIN = (str, int, float, type(None))


def shown_numbers(content: ReportContent) -> Iterator[Number]:
    """Give every number with an id that a report shows; of what was recomputed the headlines."""
    of_headlines = [
        decision.headline
        for comparison, varied in content.headlines
        for decision in (comparison.decision, *(one.result for one in varied))
    ]
    budget = content.budget
    of_sources = [] if budget is None else [of[name] for name in budget.one_run for of in (budget.one_run, budget.mean)]
    beside: dict[str, object] = {"variations": of_headlines, "budget": of_sources}
    for one in fields(content):
        yield from numbers_in(beside.get(one.name, getattr(content, one.name)))


def numbers_in(value: object) -> Iterator[Number]:
    """Give every number that was computed of a book, with its id, in a part of a report's content."""
    if isinstance(value, Number):
        if value.provenance:
            yield value
        return
    if isinstance(value, Mapping):
        parts: Iterable[object] = value.values()
    elif is_dataclass(value) and not isinstance(value, type):
        parts = [getattr(value, one.name) for one in fields(value) if one.name != "origin"]
    elif isinstance(value, list | tuple):
        parts = value
    else:
        return
    for part in parts:
        if not isinstance(part, _PLAIN):
            yield from numbers_in(part)


def provenance(shown: Iterable[str], computed: Results) -> tuple[Provenance, ...]:
    """Say of each number by its id what it is and how many inputs its result has."""
    known = {number.provenance: (name, one) for one in computed.made.values() for name, number in numbers_of(one)}
    found = []
    for uid in shown:
        name, result = known[uid]
        found.append(Provenance(uid, f"{name.replace('_', ' ')}, {_scope(result)}", len(result.origin.inputs)))
    return tuple(found)


def _scope(result: Result) -> str:
    """Say what a result is about in a few words; the family of a comparison is in its label already."""
    return "; ".join(str(value) for name, value in result.origin.scope.items() if value != "" and name != "family")
