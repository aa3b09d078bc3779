"""How each outcome is computed from the runs; a new outcome is a line here and in `data_schema.outcomes`."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from data_schema.outcomes import Outcome
from data_schema.vocabulary import FileRole
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import as_protocol, run_apexes
from labbook.analysis.outcomes.run_energy import passive_drains, run_energies
from labbook.analysis.outcomes.run_force import run_forces
from labbook.analysis.results.codec import StoredResult
from labbook.analysis.results.result_cache import ResultCache, RunResults
from labbook.analysis.study_data import StudyData

_MEASURES: Mapping[Outcome, Callable[[ResultCache, Detections, StudyData], RunResults[StoredResult]]] = {
    Outcome.JOULES: lambda cache, _detections, data: run_energies(cache, data, passive_drains(cache, data)),
    Outcome.APEX: lambda cache, detections, data: run_apexes(cache, detections, data, as_protocol(data)),
    **{outcome: run_forces for outcome in Outcome if outcome.source is FileRole.FORCE},
}


def measure(outcome: Outcome, cache: ResultCache, detections: Detections, data: StudyData) -> RunResults[StoredResult]:
    """Ensure the outcome of every selected jump run that has what it takes, as the protocol says."""
    return _MEASURES[outcome](cache, detections, data)
