"""Making a report: analyse the selected runs and fill the content of the page."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import sqlalchemy as sa

from data_schema import journal
from data_schema.outcomes import Outcome
from data_schema.queries.history import void_reasons
from data_schema.queries.study import checks_by_day, people, planned_runs, withdrawn_names
from data_schema.vocabulary import RunState
from ingest.store import Store
from labbook.analysis.comparison import pairing
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.results import Results
from labbook.analysis.study import StudyAnalysis, analyse
from labbook.analysis.study_data import gather
from labbook.config.parsing import Configuration
from labbook.presenting.report import methods, results
from labbook.presenting.report.results import provenance, shown_numbers
from reports.claims import family_claim, group_claim, overall_claims
from reports.content import Claim, Comparison, ReportContent
from reports.tables.contrasts import contrast_claims
from stats.apexes.detectors import DETECTORS


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
    compared = results.comparisons(analysis)
    bare = ReportContent(
        title=f"Report on {evidence.study.name}",
        study=evidence.study.name,
        selection=evidence.selection,
        made_at=made_at,
        software_version=importlib.metadata.version("robot-labbook"),
        configuration_hash=evidence.configuration.sha256[:12],
        detector=f"{detector}, version {DETECTORS[detector].version}",
        people=tuple(people(connection)),
        days=results.days(analysis, checks_by_day(connection)),
        flow=results.flow(analysis, planned_runs(connection), withdrawn_names(connection)),
        factors=results.factors(analysis),
        conditions=results.conditions(analysis),
        claims=(),
        comparisons=compared,
        contrasts=tuple(analysis.contrasts),
        overall=results.overall(analysis),
        overall_equivalence=results.overall_equivalence(analysis),
        anovas=tuple(analysis.anovas),
        drains=results.drains(analysis),
        budget=analysis.budget,
        packs=analysis.packs,
        confounded=tuple(results.confounded_with_day(analysis)),
        variations=analysis.variations.varied,
        methods=methods.methods(analysis),
        sources=methods.sources(analysis),
        limitations=methods.limitations(analysis),
        outside_limits=methods.outside_limits(analysis),
        exchanged_charges=methods.exchanged_charges(analysis),
        assumed=methods.assumed(analysis),
        robots=results.runs_by_robot(analysis),
        runs=results.runs(analysis),
        predictions=results.predictions(analysis),
        hypotheses=results.hypotheses(analysis),
        planned=analysis.planned.stated,
        decided=results.decision_sentences(analysis.planned),
        run_before=analysis.planned.run_before or "",
        departures=results.departures(analysis),
        departed=len(analysis.planned.departures),
        void=results.void_sentence(void, void_reasons(connection, [run.uid for run in void])),
        look=analysis.planned.look,
        without_charges=results.groups_without_charges(analysis),
        favoured=results.favoured(analysis),
        coarse_charger=results.coarse_charger(analysis),
        entry=journal.head(connection)[0],
        no_equivalence=results.no_equivalence(analysis),
    )
    used = ("numpy", "scipy", "matplotlib", *(("numba",) if bare.predictions.items else ()))
    content = replace(
        bare,
        software=tuple((name, importlib.metadata.version(name)) for name in used),
        limitations=(*results.robot_limitations(analysis, bare), *bare.limitations),
        claims=_warned(bare, _claims(bare, compared, one_level=results.one_level(analysis))),
    )
    shown = dict.fromkeys(number.provenance for number in shown_numbers(content))
    return MadeReport(replace(content, provenance=provenance(shown, computed)), analysis, computed)
