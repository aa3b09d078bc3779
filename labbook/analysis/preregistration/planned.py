"""What was decided about the analysis before the first measurement, and what departs from it.

The journal keeps labbook.toml whenever it changed, in the order of everything else that was stated. What `[analysis]`
said when the first file was imported or the first charge typed in rules; a later change refuses nothing and changes
nothing, it is told. Where nothing had been decided by then, today's settings are used and every comparison is
exploratory.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.first_measurement import StatedConfiguration, first_measurement, stated_configurations
from data_schema.queries.runs import RunRow, list_runs
from data_schema.vocabulary import FileRole, RunState
from labbook.analysis.comparison import pairing
from labbook.analysis.preregistration.changed_settings import History, changed_jump_rules, changed_settings
from labbook.analysis.preregistration.departures import Analysable, Departure, parted_conditions, read_analysable
from labbook.analysis.preregistration.disallowed_exclusions import DisallowedExclusion, disallowed_exclusions
from labbook.analysis.preregistration.late_arrivals import late_arrivals
from labbook.analysis.preregistration.late_corrections import late_corrections
from labbook.analysis.preregistration.late_replacements import late_replacements
from labbook.analysis.preregistration.moved_runs import moved_runs
from labbook.analysis.preregistration.study_history import StudyHistory, read_study_history
from labbook.analysis.preregistration.unselected_conditions import unselected_conditions
from labbook.config.analysis import kept_analysis
from labbook.config.model import AnalysisSettings, Configuration, Family

FAMILY_OF: Mapping[Family, str] = {Family.EACH: pairing.EACH, Family.POOLED: pairing.POOLED}
"""The family of comparisons that a setting means."""
NOTHING_DECIDED = "nothing was decided before the first run was ingested"
AS_A_WHOLE = "a family counts as planned only as a whole, because Holm's p of each comparison rests on all of its runs"
"""Why a run left out for a reason that was not allowed concerns groups that it does not belong to."""


@dataclass(frozen=True, slots=True)
class Reason:
    """Why something is exploratory, in words; `departures` are those of `Planned` that make it so, none elsewhere."""

    text: str
    departures: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Planned:
    """The settings that rule the analysis, whether they were stated in time, and what departs from them.

    `stated_utc` and `stated_by` say when and by whom the settings were first stated as they rule, also where that was
    too late; None where they never were. `first_measured_utc` is None before the first measurement. `left_out` is what
    people left out for reasons that the settings do not allow; `bounds_stated` tells whether the settings' bounds, if
    they have any, were stated in time. `further` departs in what the numbers rest on: the runs selected, corrections,
    the rules of `[protocol]` which jumps count. `run_before` is the day of the first run where its own date lies before
    the statement, which then shows only that the numbers were not in the book yet.
    """

    settings: AnalysisSettings
    stated: bool
    departures: tuple[str, ...]
    stated_utc: str | None = None
    stated_by: str | None = None
    first_measured_utc: str | None = None
    disallowed_exclusions: tuple[DisallowedExclusion, ...] = ()
    bounds_stated: bool = True
    further: tuple[Departure, ...] = ()
    run_before: str | None = None

    def exploratory(self, quantity: Outcome, family: str, conditions: Collection[str] | None = None) -> str | None:
        """Say why a comparison of a family (a name of `pairing`) is exploratory; None where it is the planned one.

        `conditions` are the keys of those compared; without them it may be any.
        """
        reason = self.reason(quantity, family, conditions)
        return None if reason is None else reason.text

    def reason(self, quantity: Outcome, family: str, conditions: Collection[str] | None = None) -> Reason | None:
        """Return why a comparison is exploratory, as `exploratory`."""
        planned = self.settings.primary_outcome
        if not self.stated:
            return Reason(NOTHING_DECIDED)
        if quantity is not planned:
            return Reason(f"the primary outcome decided on is {planned}")
        return self._beside_the_plan(quantity, family, conditions)

    def exploratory_equivalence(self, family: str, conditions: Collection[str] | None = None) -> str | None:
        """Say why a test of apexes against the bounds is exploratory; bounds that were stated plan it."""
        reason = self.reason_of_equivalence(family, conditions)
        return None if reason is None else reason.text

    def reason_of_equivalence(self, family: str, conditions: Collection[str] | None = None) -> Reason | None:
        """Return why a test of apexes against the bounds is exploratory."""
        if not self.stated:
            return Reason(NOTHING_DECIDED)
        if not self.bounds_stated:
            return Reason("no bounds of apex height were stated before the first run was ingested")
        return self._beside_the_plan(Outcome.APEX, family, conditions)

    def exploratory_anova(self) -> str:
        """Say why an analysis of variance is exploratory: no family that can be decided on has one."""
        return "the families that can be decided on have no analysis of variance" if self.stated else NOTHING_DECIDED

    def exploratory_jumps(self) -> str:
        """Say why a test over single jumps is exploratory: no unit of analysis is the jump."""
        unit = self.settings.unit_of_analysis
        return f"the unit of analysis decided on is the {unit}, not the jump" if self.stated else NOTHING_DECIDED

    def _beside_the_plan(self, quantity: Outcome, family: str, conditions: Collection[str] | None) -> Reason | None:
        planned = FAMILY_OF[self.settings.family]
        if family != planned:
            return Reason(f"the family decided on is {planned}")
        touching = [
            item for item in self.disallowed_exclusions if item.jumps is None or quantity.source is FileRole.LOG
        ]
        rests_on = [item.sentence for item in self.further if item.touches(quantity, conditions)]
        departures = (*map(not_allowed, touching), *rests_on)
        if touching:
            said = "; ".join(item.sentence for item in touching)
            text = f"something was left out for a reason that was not allowed ({said}), and {AS_A_WHOLE}"
            return Reason(text, departures)
        return Reason("; ".join(rests_on), departures) if rests_on else None


def planned_analysis(
    connection: sa.Connection, configuration: Configuration, selected: Collection[str] | None = None
) -> Planned:
    """Find what rules the analysis of a book whose labbook.toml is `configuration`; the journal alone decides.

    `selected` are the uids of the runs that a report or a comparison takes, None where it takes all.
    """
    now, first = configuration.analysis, first_measurement(connection)
    history = [(item, kept_analysis(item.text)) for item in stated_configurations(connection)]
    if first is None:
        known = _since(history, now)
        return Planned(now or AnalysisSettings(), now is not None, (), *_said(known))
    before = [item for item in history if item[0].seq < first.seq]
    stood = before[-1][1] if before else None
    if stood is None:
        known = _since(history, now)
        too_late = (
            "" if known is None else f"; [analysis] was stated on {known.at_utc[:10]} by {known.person}, after it"
        )
        return Planned(
            now or AnalysisSettings(), False, (NOTHING_DECIDED + too_late,), *_said(known), first.at_utc
        )  # fmt: skip
    out, since, every = (
        disallowed_exclusions(connection, stood.exclusions),
        _since(before, stood),
        read_analysable(connection),
    )
    study_history = read_study_history(connection, first.seq)
    further = [
        *changed_jump_rules(before[-1][0].text, configuration),
        *(item for watch in _SINCE_MEASURED for item in watch(connection, study_history, every)),
        *(
            ()
            if selected is None
            else (item for watch in _IN_SELECTIONS for item in watch(every, configuration, selected))
        ),
    ]
    departures = [
        *changed_settings(stood, now, history),
        *map(not_allowed, out),
        *(item.sentence for item in further),
    ]
    late_bounds = None if stood.apex_bounds or now is None else now.apex_bounds
    return Planned(
        replace(stood, apex_bounds=late_bounds) if late_bounds else stood,
        True,
        tuple(departures),
        *_said(since),
        first.at_utc,
        out,
        bounds_stated=late_bounds is None,
        further=tuple(further),
        run_before=None if since is None else _run_before(list_runs(connection), since.at_utc),
    )


_SINCE_MEASURED: tuple[Callable[[sa.Connection, StudyHistory, Analysable], list[Departure]], ...] = (
    late_corrections,
    moved_runs,
    late_replacements,
    late_arrivals,
)
"""What is watched in the journal since the entry of the first measurement, in the order in which it is told."""
_IN_SELECTIONS: tuple[Callable[[Analysable, Configuration, Collection[str]], list[Departure]], ...] = (
    parted_conditions,
    unselected_conditions,
)
"""What is watched in the choice of runs (their uids) for a report or a comparison."""


def not_allowed(item: DisallowedExclusion) -> str:
    """Return the departure that something left out for another reason than those allowed is."""
    return f"{item.sentence}, which was not allowed"


def _run_before(runs: Sequence[RunRow], at_utc: str) -> str | None:
    """Return the day of the first run that was made, where that was before a time; None where it was later.

    A run without the time of its start is before where its day is.
    """
    made = [run for run in runs if run.started_utc is not None or run.state is not RunState.OPEN]
    times = [(run.started_utc or run.day, run.day) for run in made]
    return min((day for time, day in times if time < at_utc[: len(time)]), default=None)


def _since(history: History, settings: AnalysisSettings | None) -> StatedConfiguration | None:
    """Return the entry since which the settings have stood unbroken to the end of the history."""
    found = None
    for item, said in reversed(history):
        if settings is None or said != settings:
            break
        found = item
    return found


def _said(item: StatedConfiguration | None) -> tuple[str | None, str | None]:
    return (None, None) if item is None else (item.at_utc, item.person)
