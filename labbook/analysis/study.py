"""The whole analysis of a selection: from facts and logs to the results that a report shows."""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import sqlalchemy as sa

from data_schema import journal
from data_schema.outcomes import Outcome
from data_schema.queries.history import void_reasons
from data_schema.queries.study import checks_by_day, people, planned_runs, withdrawn_names
from data_schema.vocabulary import RunState, Undefined
from ingest.store import Store
from labbook.analysis import methods
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.comparisons import (
    Compared,
    analyses_of_variance,
    compare_all,
    groups_without_charges,
    unselected_conditions,
)
from labbook.analysis.comparison.contrasts import contrast_means
from labbook.analysis.comparison.deciding import Overall, overall_effects
from labbook.analysis.comparison.order import confounded_with_day, favoured_headlines
from labbook.analysis.comparison.robustness import Variations, vary
from labbook.analysis.measured import Measured, analysed_runs, days, flow, measure_study, runs_by_robot
from labbook.analysis.outcomes.budget import budget, pack_deviations
from labbook.analysis.outcomes.conditions import coarse_charger
from labbook.analysis.outcomes.control_limits import exchanged_charges, joule_limits, runs_outside
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.prediction.bias import judge
from labbook.analysis.prediction.checking import check_conditions, check_savings, study_predictions
from labbook.analysis.prediction.hypotheses import judge_hypotheses
from labbook.analysis.prediction.predicting import predictions
from labbook.analysis.prediction.simulating import ALWAYS, SIMULATED
from labbook.analysis.preregistration.planned import Planned, plan_of, planned_analysis, void_sentence
from labbook.analysis.results import Results, provenance, shown_numbers
from labbook.analysis.study_data import gather
from labbook.config.parsing import Configuration
from reports.claims import claims
from reports.results import Anova, Favoured, MeansContrast, StudyResults
from stats.apexes.detectors import DETECTORS


@dataclass(frozen=True, slots=True)
class Analysis:
    """A study's results, what they are computed from, and every result behind a number of them by its key."""

    results: StudyResults
    measured: Measured
    planned: Planned
    computed: Results

    @property
    def shown(self) -> tuple[str, ...]:
        """The ids of the numbers that a report shows."""
        return tuple(one.id for one in self.results.provenance)

    @property
    def versions(self) -> dict[str, int]:
        """The versions of the algorithms that made it, those of all detectors among them, by name."""
        used = {one.origin.kind: one.origin.version for one in self.computed.made.values()}
        return {**dict(sorted(used.items())), **{name: detector.version for name, detector in DETECTORS.items()}}


def analyse(
    connection: sa.Connection,
    store: Store,
    configuration: Configuration,
    *,
    where: str | None,
    made_at: str,
    progress: Callable[[str], None] = lambda _what: None,
    level: float | None = None,
) -> Analysis:
    """Analyse the selected runs; needs no lock and stores nothing. `progress` is called with what is being done.

    `level` is that of the comparisons' intervals, and alpha of their tests follows; without it they are as planned.
    """
    evidence = gather(connection, configuration, where)
    computed, detections = Results(), Detections(connection, store, progress)
    planned = planned_analysis(connection, configuration, frozenset(run.uid for run in evidence.selected))
    settings = planned.settings
    if level is not None and not math.isclose(level, 1.0 - settings.outside):
        settings = replace(settings, alpha=settings.alpha * (1.0 - level) / settings.outside)
        planned = replace(planned, settings=settings)
    measured = measure_study(computed, detections, evidence, progress)
    conditions = measured.conditions
    progress("comparisons")
    selected = computed.about(selection=evidence.selection)
    swept = pairing.swept_factor(configuration)
    packs = pack_deviations(selected, conditions[Outcome.JOULES])
    of_a_joule = budget(selected, evidence, conditions[Outcome.JOULES])
    keys = list(dict.fromkeys(item.key for item in measured.every_condition))
    simulated = [outcome for outcome in SIMULATED if outcome in ALWAYS or conditions.get(outcome)]
    predicted = predictions(computed, connection, evidence, keys, progress, simulated)
    checks = {
        outcome: check_conditions(selected, conditions[outcome], predicted, outcome, swept)
        for outcome in simulated
        if predicted
    }
    in_groups = {name: labels for name, labels in evidence.labels.items() if name != swept}
    biases = [
        one
        for outcome, found in checks.items()
        for one in judge(selected, conditions[outcome], found, outcome, in_groups)
    ]
    compared: list[Compared] = []
    anovas: list[Anova] = []
    contrasts: list[MeansContrast] = []
    effects, variations, favoured = Overall(), Variations(), tuple[Favoured, ...]()
    if swept is not None:
        beside = unselected_conditions(computed, detections, evidence, conditions) if planned.stated else {}
        compared = compare_all(selected, conditions, swept, planned, evidence, beside)
        for outcome, several in conditions.items():
            anovas += analyses_of_variance(selected, several, swept, outcome)
        pooled = {outcome: pairing.pairs_pooled(several, swept) for outcome, several in conditions.items()}
        effects = overall_effects(selected, pooled, planned)
        values = pairing.treated_values(configuration, swept)
        contrasts = contrast_means(selected, conditions, swept, values, planned, selected=bool(evidence.selection))
        progress("what the headlines depend on")
        variations = vary(
            computed, detections, evidence, measured.drains, measured.results, conditions, swept, settings
        )
        favoured = favoured_headlines(selected, pooled, effects, planned, variations.varied)
    asked = tuple(configuration.hypotheses.values())
    hypotheses = judge_hypotheses(selected, asked, conditions, compared, predicted, swept or "", settings, in_groups)
    of_savings = [(one.pair, one.shown.decision) for one in compared if one.shown.quantity is Outcome.JOULES]
    checked = [one for several in checks.values() for one in several]
    checked += check_savings(selected, of_savings, predicted)
    joules = {item.run.uid: item.value for each in conditions[Outcome.JOULES] for item in each.runs}
    limits = joule_limits(evidence, joules)
    void = [run for run in evidence.selected if run.state is RunState.VOID]
    detector = configuration.protocol.detector
    used = ("numpy", "scipy", "matplotlib", *(("numba",) if predicted else ()))
    study = StudyResults(
        title=f"Report on {evidence.study.name}",
        study=evidence.study.name,
        selection=evidence.selection,
        made_at=made_at,
        software_version=importlib.metadata.version("robot-labbook"),
        configuration_hash=configuration.sha256[:12],
        detector=f"{detector}, version {DETECTORS[detector].version}",
        people=tuple(people(connection)),
        days=days(evidence, checks_by_day(connection)),
        flow=flow(measured, planned_runs(connection), withdrawn_names(connection)),
        factors=pairing.study_factors(evidence, measured.every_condition),
        conditions=pairing.study_conditions(evidence, conditions),
        claims=(),
        comparisons=tuple(one.shown for one in compared),
        anovas=tuple(anovas),
        drains=tuple(one for one in measured.drains.values() if not isinstance(one.line, Undefined)),
        budget=of_a_joule,
        packs=packs,
        confounded=confounded_with_day(evidence, swept),
        variations=variations.varied,
        contrasts=tuple(contrasts),
        overall=tuple(effects.savings.values()),
        overall_equivalence=effects.equivalent,
        outside_limits=tuple(run.name for run in runs_outside(evidence.runs, joules, limits)),
        exchanged_charges=exchanged_charges(evidence, measured.drains, joules, limits),
        assumed=methods.assumed(evidence),
        runs=analysed_runs(measured),
        robots=runs_by_robot(measured),
        predictions=study_predictions(measured, swept, predicted, checked, biases),
        hypotheses=hypotheses,
        plan=plan_of(planned),
        void=void_sentence(void, void_reasons(connection, [run.uid for run in void])),
        without_charges=groups_without_charges(evidence, swept, compared),
        favoured=favoured,
        coarse_charger=coarse_charger(conditions[Outcome.JOULES]),
        software=tuple((name, importlib.metadata.version(name)) for name in used),
        entry=journal.head(connection)[0],
    )
    of_robots = methods.robot_limitations(compared, study)
    study = replace(
        study,
        claims=claims(study),
        methods=methods.methods(measured, study),
        limitations=(*of_robots, *methods.limitations(measured, variations.fits_lost)),
        no_equivalence=methods.no_equivalence(study, settings),
        sources=methods.sources(study),
    )
    shown = dict.fromkeys(number.provenance for number in shown_numbers(study))
    return Analysis(replace(study, provenance=provenance(shown, computed)), measured, planned, computed)
