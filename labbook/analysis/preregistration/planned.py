"""What was decided about the analysis before the first measurement, and what departs from it, also in sentences.

The journal stores labbook.toml whenever it changed, in order with all other entries. The `[analysis]` that it had when
the first file was imported, or the first charge typed in, applies. A later change is not refused: it is listed and has
no effect. Where nothing had been decided by then, today's settings are used and every comparison is exploratory.

What the choice of runs for a report or a comparison leaves out: it could have been made after looking at them.

Some runs of a condition are another condition, and some levels of a group, compared without its others, are another
comparison than the planned one. A group that is left out whole takes nothing from the others' means, but its
comparisons belong to the planned family: Holm's p of a report counts them too.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sqlalchemy as sa

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries.history import EntryRow, first_measurement, recorded_configurations
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import FileRole, ReasonCode, RunKind, RunState
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.pairing import place_configured
from labbook.analysis.preregistration.book_state import (
    BookState,
    read_history,
    reported_states,
    state_at,
)
from labbook.analysis.preregistration.departures import (
    Departure,
    DepartureKind,
    departures_since,
    first_named,
    in_order,
)
from labbook.analysis.preregistration.looks import look_of
from labbook.config.model import HOW_TO_DECIDE, AnalysisSettings, Bounds, Configuration, Family
from labbook.config.parsing import parse_configuration
from reports.display import list_text, sentence_start
from reports.results import Look, Plan


def _unselected(now: BookState, configuration: Configuration, selected: frozenset[str]) -> list[Departure]:
    """List what a selection (uids of runs) leaves out: of conditions, of groups, and of the planned family."""
    if all(run.uid in selected for run in now.runs.values() if run.kind is RunKind.JUMPS):
        return []
    swept = pairing.swept_factor(configuration)
    control = None if swept is None else configuration.factors[swept].control
    given = {run.uid: now.given(run.uid) for run in now.runs.values() if run.kind is RunKind.JUMPS}
    runs = [run for run in now.runs.values() if given.get(run.uid)]
    groups: dict[tuple[tuple[str, str], ...], dict[str, list[RunRow]]] = {}
    levels = {run.condition_key: run.levels for run in runs}
    places = {key: place_configured(configuration, of) for key, of in levels.items()}
    for run in sorted(runs, key=lambda run: places[run.condition_key]):
        group = tuple(sorted((name, label) for name, label in run.levels.items() if name != swept))
        groups.setdefault(group, {}).setdefault(run.condition_key, []).append(run)
    found: list[Departure] = []
    whole: list[str] = []
    for key, of_condition in (item for conditions in groups.values() for item in conditions.items()):
        taken = {outcome for run in of_condition if run.uid in selected for outcome in given[run.uid]}
        others = {run.name: given[run.uid] & taken for run in of_condition if run.uid not in selected}
        if names := [name for name, outcomes in others.items() if outcomes]:
            parameters = {"runs": f"{'run' if len(names) == 1 else 'runs'} {', '.join(names)}", "condition": key}
            quantities = in_order(frozenset().union(*others.values()))
            found.append(Departure(DepartureKind.RUNS_UNSELECTED, parameters, quantities, (key,)))
    for conditions in groups.values():
        left = [key for key, some in conditions.items() if not any(run.uid in selected for run in some)]
        treated = {key for key, some in conditions.items() if some[0].levels.get(str(swept)) != control}
        if swept is not None and treated & set(left) and treated - set(left):
            quantities = in_order(frozenset().union(*(given[run.uid] for key in left for run in conditions[key])))
            found.append(Departure(DepartureKind.LEVELS_UNSELECTED, _listed(left), quantities, tuple(conditions)))
        else:
            whole += left
    return [*found, *([Departure(DepartureKind.CONDITIONS_UNSELECTED, _listed(whole))] if whole else ())]


def _listed(keys: Sequence[str]) -> dict[str, str]:
    """Count and name conditions, of many the first and how many more there are."""
    return {
        "count": f"{len(keys)} condition{'' if len(keys) == 1 else 's'}",
        "conditions": first_named(keys, "; "),
    }


FAMILY_OF: Mapping[Family, str] = {Family.EACH: pairing.EACH, Family.POOLED: pairing.POOLED}
"""The family of comparisons that a setting means."""
NOTHING_DECIDED = "nothing was decided before the first run was ingested"
AS_A_WHOLE = "a family counts as planned only as a whole, because Holm's p of each comparison rests on all of its runs"
"""Why a run left out for a reason that was not allowed concerns groups that it does not belong to."""


_History = Sequence[tuple[EntryRow, AnalysisSettings | None]]
"""Every labbook.toml that the journal stores, with its [analysis]."""


@dataclass(frozen=True, slots=True)
class DisallowedExclusion:
    """A run, the reason given, and how many of its jumps it took away; `jumps` is None where the whole run is void."""

    run: str
    reason: str
    jumps: int | None

    @property
    def sentence(self) -> str:
        """Say what was left out."""
        if self.jumps is None:
            return f"run {self.run} is void ({self.reason})"
        return f"{self.jumps} jump{'' if self.jumps == 1 else 's'} of run {self.run} rejected ({self.reason})"


@dataclass(frozen=True, slots=True)
class Planned:
    """The settings that apply to the analysis, whether they were recorded in time, and what departs from them.

    - `stated`: whether they were recorded before the first measurement.
    - `stated_utc`, `stated_by`: when and by whom they were first recorded, even if too late; None if they never were.
    - `first_measured_utc`: None before the first measurement.
    - `disallowed_exclusions`: what people left out for reasons that the settings do not allow.
    - `bounds_stated`: whether the settings' bounds, if they have any, were recorded in time.
    - `further`: departures in what the numbers depend on: the runs selected, corrections, the rules of `[protocol]` on
      which jumps count.
    - `run_before`: the day of the first run, where its own date lies before the settings were recorded. These then
      show only that the numbers were not in the book yet.
    - `look`: which look at the data this is; None before the first. Where a selection was given, its nominal level is
      the alpha of the settings.
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
    look: Look | None = None

    def exploratory(self, quantity: Outcome, family: str, conditions: Collection[str] | None = None) -> str | None:
        """Say why a comparison of a family (a name of `pairing`) is exploratory; None where it is the planned one.

        `conditions` are the keys of those compared; without them it may be any.
        """
        planned = self.settings.primary_outcome
        if not self.stated:
            return NOTHING_DECIDED
        if quantity is not planned:
            return f"the primary outcome decided on is {planned}"
        return self._beside_the_plan(quantity, family, conditions)

    def exploratory_equivalence(self, family: str, conditions: Collection[str] | None = None) -> str | None:
        """Say why a test of apexes against the bounds is exploratory; recorded bounds make it a planned one."""
        if not self.stated:
            return NOTHING_DECIDED
        if not self.bounds_stated:
            return "no bounds of apex height were stated before the first run was ingested"
        return self._beside_the_plan(Outcome.APEX, family, conditions)

    def exploratory_contrast(
        self, quantity: Outcome, conditions: Collection[str], *, selected: bool = False
    ) -> str | None:
        """Say why a contrast of condition means is exploratory; `selected` where it is of some of the runs."""
        if not self.stated:
            return NOTHING_DECIDED
        if not self.settings.contrasts:
            return "no contrasts were decided on"
        if selected:
            return "contrasts were decided on for all runs, not a selection"
        return self._beside_the_plan(quantity, FAMILY_OF[self.settings.family], conditions)

    def _beside_the_plan(self, quantity: Outcome, family: str, conditions: Collection[str] | None) -> str | None:
        planned = FAMILY_OF[self.settings.family]
        if family != planned:
            return f"the family decided on is {planned}"
        touching = [
            item for item in self.disallowed_exclusions if item.jumps is None or quantity.source is FileRole.LOG
        ]
        if touching:
            exclusions = "; ".join(item.sentence for item in touching)
            return f"something was left out for a reason that was not allowed ({exclusions}), and {AS_A_WHOLE}"
        return "; ".join(item.sentence for item in self.further if item.touches(quantity, conditions)) or None


def planned_analysis(
    connection: sa.Connection, configuration: Configuration, selected: frozenset[str] | None = None
) -> Planned:
    """Find what rules the analysis of a book whose labbook.toml is `configuration`; the journal alone decides.

    `selected` are the uids of the runs that a report or a comparison takes, None where it takes all.
    """
    now, first = configuration.analysis, first_measurement(connection)
    configurations = [(item, _stored(item.new["text"]).analysis) for item in recorded_configurations(connection)]
    before = [item for item in configurations if first is not None and item[0].seq < first.seq]
    stood = before[-1][1] if before else None
    if first is None or stood is None:
        since = None if now is None else _since(configurations, now)
        day = "" if since is None else f"; [analysis] was stated on {since.at_utc[:10]} by {since.person}, after it"
        departures, at_utc = ((), None) if first is None else ((NOTHING_DECIDED + day,), first.at_utc)
        planned = first is None and now is not None
        found = Planned(now or AnalysisSettings(), planned, departures, *_time_and_person(since), at_utc)
        return found if first is None else _at_look(connection, found, first.seq, selected)
    history, since = read_history(connection), _since(before, stood)
    state, reports = state_at(history), reported_states(history)
    left_out = _disallowed(state, stood.exclusions)
    void_runs = [item.run for item in left_out if item.jumps is None]
    since_first = departures_since(history, state, reports, first.seq, void_runs)
    further = [*_changed_jump_rules(before[-1][0].new["text"], configuration), *since_first]
    further += [] if selected is None else _unselected(state, configuration, selected)
    departing = [*_changed_settings(stood, now, configurations), *map(not_allowed, left_out)]
    bounds_late = stood.apex_bounds is None and now is not None and now.apex_bounds is not None
    found = Planned(
        replace(stood, apex_bounds_m=now.apex_bounds_m, apex_bounds_percent=now.apex_bounds_percent)
        if now is not None and bounds_late
        else stood,
        True,
        (*departing, *(item.sentence for item in further)),
        *_time_and_person(since),
        first.at_utc,
        left_out,
        bounds_stated=not bounds_late,
        further=tuple(further),
        run_before=None if since is None else _run_before(state.runs.values(), since.at_utc),
    )
    return _at_look(connection, found, first.seq, selected, (state, reports))


def _at_look(
    connection: sa.Connection,
    planned: Planned,
    first_seq: int,
    selected: frozenset[str] | None,
    states: tuple[BookState, Mapping[int, BookState]] | None = None,
) -> Planned:
    """Add which look this is; a report or a comparison keeps to the level of its look."""
    look = look_of(connection, first_seq, planned.settings, selected, states)
    if look is None or selected is None:
        return replace(planned, look=look)
    return replace(planned, look=look, settings=replace(planned.settings, alpha=look.level))


def not_allowed(item: DisallowedExclusion) -> str:
    """Return the sentence of the departure that an exclusion for a reason that is not allowed makes."""
    return f"{item.sentence}, which was not allowed"


def is_allowed(reason: str, allowed: Collection[ReasonCode]) -> bool:
    """Tell whether a reason begins with one that is allowed, written with blanks or underscores.

    A run is void for a reason in words, as "sensor fault: the string was off its drum"; other allows every reason.
    """
    text = reason.strip().lower().replace("_", " ")
    return ReasonCode.OTHER in allowed or any(
        text.startswith(words) and not text[len(words) : len(words) + 1].isalnum()
        for code in allowed
        for words in [str(code).replace("_", " ")]
    )


def _disallowed(state: BookState, allowed: Collection[ReasonCode]) -> tuple[DisallowedExclusion, ...]:
    """List what was left out for other reasons than those allowed, by run: void runs, then jumps of runs that count."""
    found = [
        DisallowedExclusion(state.runs[uid].name, reason, jumps or None)
        for (uid, reason), jumps in state.exclusions.items()
        if state.runs[uid].kind in (RunKind.JUMPS, RunKind.IDLE) and not is_allowed(reason, allowed)
    ]
    return tuple(sorted(found, key=lambda item: (item.jumps is not None, item.run, item.reason)))


def _changed_settings(stood: AnalysisSettings, now: AnalysisSettings | None, history: _History) -> list[str]:
    """Say field by field what labbook.toml says otherwise than before the first measurement, and since when."""
    if now is None:
        return [Departure(DepartureKind.NO_ANALYSIS, {}).sentence]
    found = []
    for name in (*(one for one in AnalysisSettings.__match_args__ if not one.startswith("apex_bounds")), "apex_bounds"):
        was, value = getattr(stood, name), getattr(now, name)
        since = _since([(item, getattr(settings, name, None)) for item, settings in history], value)
        parameters = {
            "name": name.replace("_", " ") if name in ("primary_outcome", "apex_bounds") else name,
            "was": _shown(was),
            "now": _shown(value),
            "since": "" if since is None else f" since {since.at_utc[:10]} ({since.person})",
            "effect": "it is used, and exploratory" if was is None else "what was stated before stands",
        }
        found += [Departure(DepartureKind.SETTING, parameters).sentence] if was != value else []
    return found


def _stored(text: str) -> Configuration:
    return parse_configuration(text, "the book's configuration")


def _changed_jump_rules(text: str, configuration: Configuration) -> list[Departure]:
    """List the rules of the protocol on jumps that are others than before the first measurement; today's are used."""
    of_jumps = tuple(outcome for outcome in Outcome if outcome.of_jumps)
    of_push_off = tuple(outcome for outcome in Outcome if outcome.of_push_off)
    found = []
    then = _stored(text).protocol
    for name in ("detector", "exclude_first_jumps", "exclude_gap_jumps", "onset", "take_off"):
        was, now = getattr(then, name), getattr(configuration.protocol, name)
        changed = of_push_off if name in ("onset", "take_off") else of_jumps
        what = list_text([outcome.plural for outcome in changed])
        words = {"name": name, "was": _shown(was), "now": _shown(now), "exploratory": what}
        found += [Departure(DepartureKind.JUMP_RULE, words, changed)] if was != now else []
    return found


def _shown(value: object) -> str:
    if isinstance(value, Outcome):
        return value.key
    if isinstance(value, Bounds):
        return f"{value.low:g} to {value.high:g} {'%' if value.percent else 'm'}"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return ", ".join(map(str, value)) or "none"
    return "none" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def _run_before(runs: Iterable[RunRow], at_utc: str) -> str | None:
    """Return the day of the first run that was made, where that was before a time; None where it was later.

    A run without the time of its start is before where its day is.
    """
    made = [run for run in runs if run.started_utc is not None or run.state is not RunState.OPEN]
    times = [(run.started_utc or run.day, run.day) for run in made]
    return min((day for time, day in times if time < at_utc[: len(time)]), default=None)


def _since(history: Sequence[tuple[EntryRow, Any]], value: object) -> EntryRow | None:
    """Return the entry since which a value has stood unbroken to the end of the history."""
    found = None
    for item, recorded in reversed(history):
        if recorded != value:
            break
        found = item
    return found


def _time_and_person(item: EntryRow | None) -> tuple[str | None, str | None]:
    return (None, None) if item is None else (item.at_utc, item.person)


NOT_WATCHED = (
    "Not watched: runs never made or never entered, whether a value was corrected to please (that it was is listed), "
    "apexes that were moved and jumps that were added (the report counts them), the study, the rest of labbook.toml "
    "(beside [analysis] and which jumps count), and what was looked at without a report; the journal has all but the "
    "first and the last of these."
)
"""What could depart from the plan and is not looked for."""

_UNIT = "the day where four or more are shared, else the run within shared days"


def planned_sentences(planned: Planned) -> tuple[str, ...]:
    """Say what rules the analysis and since when, then each departure."""
    return (*decision_sentences(planned), *departure_sentences(planned))


def decision_sentences(planned: Planned) -> tuple[str, ...]:
    """Say what was decided and when; then, where it is so, that nothing shows that this was before the data were seen.

    So it is where runs are dated before the decision, which the book cannot place before their numbers.
    """
    settings = _settings(planned)
    by = "" if planned.stated_utc is None else f" on {planned.stated_utc[:10]} by {planned.stated_by}"
    if planned.first_measured_utc is None:
        if not planned.stated:
            return (f"Nothing is decided about the analysis yet: {HOW_TO_DECIDE}",)
        where = by or " in labbook.toml, which the book takes over with the next statement"
        return (f"Decided{where}, and nothing is measured yet: {settings}",)
    first = planned.first_measured_utc[:10]
    if not planned.stated:
        return (
            f"Nothing was decided about the analysis before the first measurement came into the book on {first}, so "
            f"every comparison is exploratory. Used are: {settings}",
        )
    in_time = f"Decided{by}, before the first measurement came into the book on {first}: {settings}"
    if planned.run_before is None or planned.stated_utc is None:
        return (in_time,)
    return (
        in_time,
        f"The first run is dated {planned.run_before}, before the decision: "
        "nothing shows that the decision was made before the data were seen.",
    )


def _settings(planned: Planned) -> str:
    settings, look = planned.settings, planned.look
    alpha = f"{settings.alpha if look is None else look.alpha:g}"
    if look is not None and look.planned > 1:
        alpha += f" over {look.planned} looks by Lan and DeMets' spending of O'Brien and Fleming's type"
    bounds, one_sided = settings.apex_bounds, " one-sided of a saving" if settings.one_sided else ""
    unit = "" if bounds is None else "% of the control's" if bounds.percent else "m"
    within = (
        "no bounds of apex height"
        if bounds is None
        else f"differences of apex height from {bounds.low:g} to {bounds.high:g} {unit} count as none"
    )
    return (
        f"the primary outcome is {settings.primary_outcome}, the family "
        f"{FAMILY_OF[settings.family]}, alpha {alpha}{one_sided}, the unit "
        f"{_UNIT}; {within}; {_exclusions(settings)}{_contrasts(settings)}."
    )


def _contrasts(settings: AnalysisSettings) -> str:
    return f"; contrasts: {', '.join(map(str, settings.contrasts))}" if settings.contrasts else ""


def _exclusions(settings: AnalysisSettings) -> str:
    if ReasonCode.OTHER in settings.exclusions:
        return "a person may leave out jumps and runs for any reason"
    listed = ", ".join(str(reason).replace("_", " ") for reason in settings.exclusions)
    return f"a person may leave out jumps and runs for: {listed or 'no reason'}"


def plan_of(planned: Planned) -> Plan:
    """Return the same in words, as a report has it."""
    return Plan(
        stated=planned.stated,
        decided=decision_sentences(planned),
        run_before=planned.run_before or "",
        departures=departure_sentences(planned),
        departed=len(planned.departures),
        look=planned.look,
    )


def void_sentence(void: Sequence[RunRow], reasons: Mapping[str, str]) -> str:
    """Name runs that are void by the `reasons` (by uid); "" without one."""
    by_reason = grouped(void, [reasons.get(run.uid, "") for run in void])
    listed = [f"{first_named([run.name for run in runs])} ({reason})" for reason, runs in by_reason.items()]
    return f"Void: {'; '.join(listed)}." if listed else ""


def departure_sentences(planned: Planned) -> tuple[str, ...]:
    """Return what departs from it, each with the outcomes that are exploratory for it."""
    found = []
    for text in planned.departures:
        of = next((item.quantities for item in planned.further if item.sentence == text), ())
        exploratory = f" Exploratory for it: {list_text([outcome.plural for outcome in of])}." if of else ""
        found += [f"Departure: {text}.{exploratory}"] if text != NOTHING_DECIDED else []
    return (*found, *([f"{sentence_start(AS_A_WHOLE)}."] if planned.disallowed_exclusions else []))
