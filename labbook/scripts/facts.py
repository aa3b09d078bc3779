"""What was measured of the runs behind a number: their values as a report of the same runs has them, by condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.frozen import frozen
from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from ingest.store import Store
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.contrasts import AskedContrast, asked_contrasts
from labbook.analysis.comparison.order import ADJUSTED, adjusted_for_position
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.comparison.robustness import with_void, without_day
from labbook.analysis.outcomes.charger_step import rounding_in, with_rounding_of
from labbook.analysis.outcomes.conditions import ConditionValues, condition_values, measure
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import ApexVariant, as_protocol, without_exclusions
from labbook.analysis.outcomes.run_force import ALL_RULES, PushOffRules, RunForce, run_forces_by_rules
from labbook.analysis.prediction.checking import AllPredicted, side_of
from labbook.analysis.prediction.predicting import predictions
from labbook.analysis.prediction.simulating import ALWAYS, SIMULATED
from labbook.analysis.preregistration.planned import Planned, planned_analysis
from labbook.analysis.results import Results
from labbook.analysis.study_data import StudyData, gather
from labbook.config.parsing import Configuration
from reports.results import WITHOUT_EXCLUSIONS
from stats.apexes.detectors import DETECTORS

WITHOUT = "without "
_RULES = {str(rules): rules for rules in ALL_RULES}


@frozen
class Varied:
    """The facts of a variant of the analysis, and by which jumps.

    `day` is one that is left out, "" where none is; `rules` are those of single jumps on a plate, where not the
    protocol's.
    """

    evidence: StudyData
    jumps: ApexVariant
    day: str = ""
    rules: PushOffRules | None = None


@dataclass(frozen=True)
class Facts:
    """The facts of the runs that a report selects, in a book as it was when the report was made."""

    connection: sa.Connection
    store: Store
    configuration: Configuration
    selection: str
    _found: dict[tuple[Outcome, str], list[ConditionValues]] = field(default_factory=dict)

    @cached_property
    def evidence(self) -> StudyData:
        """The selected runs with what was measured of them."""
        return gather(self.connection, self.configuration, self.selection or None)

    @cached_property
    def planned(self) -> Planned:
        """The settings of the analysis."""
        selected = frozenset(run.uid for run in self.evidence.selected)
        return planned_analysis(self.connection, self.configuration, selected)

    @property
    def swept(self) -> str:
        """The factor with a control, "" where none has one."""
        return pairing.swept_factor(self.configuration) or ""

    def varied(self, variant: str) -> Varied:
        """Return the facts of a variant of the analysis; raises `UsageError` where it has no script."""
        protocol = as_protocol(self.evidence)
        detector = variant.removeprefix("with the ").removesuffix(" detector")
        if variant in ("", ADJUSTED):
            return Varied(self.evidence, protocol)
        if variant == WITHOUT_EXCLUSIONS:
            return Varied(with_void(self.evidence), without_exclusions(self.evidence))
        if variant.startswith(WITHOUT):
            day = variant.removeprefix(WITHOUT)
            return Varied(without_day(self.evidence, day), protocol, day)
        if detector in DETECTORS:
            return Varied(self.evidence, replace(protocol, detector=detector))
        if variant in _RULES:
            return Varied(self.evidence, protocol, rules=_RULES[variant])
        raise UsageError(
            f"the number is of the variant {variant!r}, which has no script: ask for the same number of the report's "
            f"own way, {WITHOUT_EXCLUSIONS}, without a day, by another detector or other rules, or {ADJUSTED}."
        )

    def conditions(self, outcome: Outcome, variant: str = "") -> list[ConditionValues]:
        """Return the conditions of the runs, in the order in which a report has them."""
        if (outcome, variant) not in self._found:
            self._found[outcome, variant] = self._measured(outcome, variant)
        return self._found[outcome, variant]

    def _measured(self, outcome: Outcome, variant: str) -> list[ConditionValues]:
        varied = self.varied(variant)
        found = self._conditions(varied, outcome)
        if not varied.day:
            return found
        # whether runs are rounded alike is decided by those of all days
        of_all_days = {item.run.uid: item.shared for one in self.conditions(outcome) for item in one.runs}
        return [
            replace(
                one,
                runs=tuple(
                    replace(
                        item,
                        shared=with_rounding_of(rounding_in(item.shared, without=True), of_all_days[item.run.uid]),
                    )
                    for item in one.runs
                ),
            )
            for one in found
        ]

    def conditions_beside(self, outcome: Outcome) -> list[ConditionValues]:
        """Return the conditions of which the selection takes no run, which count in a planned family of tests."""
        if not self.planned.stated or not self.evidence.beside:
            return []
        beside = replace(self.evidence, runs=self.evidence.beside)
        return self._conditions(Varied(beside, as_protocol(self.evidence)), outcome)

    def _conditions(self, varied: Varied, outcome: Outcome) -> list[ConditionValues]:
        evidence, computed, detections = varied.evidence, Results(), Detections(self.connection, self.store)
        found = measure(outcome, computed, detections, evidence, varied.jumps).results
        if varied.rules is not None:
            single = [uid for uid, force in found.items() if isinstance(force, RunForce) and force.single_jumps]
            found = {**found, **run_forces_by_rules(computed, detections, evidence, single)[varied.rules]}
        return condition_values(computed, evidence.runs, found, outcome)

    @property
    def settings(self) -> dict[str, object]:
        """The settings of templates that are the study's."""
        return {"REFERENCE_VOLTAGE_V": float(self.evidence.study.reference_voltage_v)}

    def decision_level(self, outcome: Outcome) -> float:
        """Return the level of the intervals of comparisons."""
        settings = self.planned.settings
        return 1.0 - (2.0 if settings.one_sided and outcome.has_savings else 1.0) * settings.alpha

    def pooled(self, outcome: Outcome, variant: str = "") -> list[Pair]:
        """Return the comparisons of all levels with the control, one a group; adjusted for position where asked for."""
        found = pairing.pairs_pooled(self.conditions(outcome, variant), self.swept)
        adjusted = adjusted_for_position(found) if variant == ADJUSTED else found
        return found if isinstance(adjusted, Undefined) else adjusted

    def contrasts(self) -> dict[str, AskedContrast]:
        """Return the contrasts of means of the plan, or those that the factors suggest, by their labels."""
        settings = self.planned.settings
        outcomes = {each.outcome for each in settings.contrasts} or {each for each in Outcome if each.has_savings}
        conditions = {outcome: self.conditions(outcome) for outcome in Outcome if outcome in outcomes}
        values = pairing.treated_values(self.configuration, self.swept)
        return asked_contrasts(settings.contrasts, conditions, self.swept, values)

    @cached_property
    def predicted(self) -> AllPredicted:
        """What is predicted for every condition of an outcome that is simulated, by its key and a robot's uid."""
        conditions = {outcome: self.conditions(outcome) for outcome in SIMULATED}
        keys = list(dict.fromkeys(one.key for several in conditions.values() for one in several))
        wanted = [outcome for outcome in SIMULATED if outcome in ALWAYS or conditions[outcome]]
        return predictions(Results(), self.connection, self.evidence, keys, lambda _step: None, wanted)

    def is_simulated(self, condition: ConditionValues, outcome: Outcome, *, varied: bool = False) -> bool:
        """Return whether there is a prediction for all runs of a condition; with `varied`, one with an error."""
        found = [one for one, _runs in side_of([condition], self.predicted)]
        return all(one.value(outcome) is not None for one in found) and not (
            varied and any(None in values for one in found for values in one.varied(outcome).values())
        )

    def pairs(self, outcome: Outcome, variant: str = "") -> list[Pair]:
        """Return what the planned families compare, in order."""
        return pairing.pairs_with_control(self.conditions(outcome, variant), self.swept)


def keys_of(pair: Pair) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the conditions of both sides of a comparison by their keys, the control's first."""
    return tuple(one.key for one in pair.a), tuple(one.key for one in pair.b)


def conditions_in(pairs: Sequence[Pair]) -> list[ConditionValues]:
    """Return the conditions that some comparisons are of, each once."""
    found: Mapping[str, ConditionValues] = {one.key: one for pair in pairs for one in (*pair.a, *pair.b)}
    return list(found.values())
