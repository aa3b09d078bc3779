"""Which look at the study's data this is: how many reports were made on fewer runs, and how many looks were planned."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.history import entries_about_plans, reports_made
from data_schema.vocabulary import Action, RunKind
from labbook.analysis.preregistration.book_state import BookState, read_history, reported_states, state_at
from labbook.config.model import AnalysisSettings
from reports.results import Look
from stats.lines.passive_drain import why_no_line
from stats.planning.group_sequential import nominal_levels, share_in_error


def look_of(
    connection: sa.Connection,
    first_seq: int,
    settings: AnalysisSettings,
    selected: frozenset[str] | None,
    states: tuple[BookState, Mapping[int, BookState]] | None = None,
) -> Look | None:
    """Return which look a report of the selected runs (their uids, None for all) is; None where none was before.

    A report is a look where it had a control and a treatment to compare, in fewer runs than there are now; reports of
    the same runs are one. `states` are those of the book now and at its reports, which are read where they are not
    given. Plans count that were stated before the first measurement, the entry `first_seq`.
    """
    planned, runs_planned = _planned(connection, first_seq)
    if planned == 1 and not (reports_made(connection) if states is None else states[1]):
        return None
    if states is None:
        history = read_history(connection)
        states = state_at(history), reported_states(history)
    now, reports = states
    first = settings.primary_outcome
    outcome = next((each for each in (first, *Outcome) if _compared(now, each, selected)), None)
    if outcome is None or not _tested(now, selected):
        return None
    runs = _compared(now, outcome, selected)
    looks = {
        found: len(_compared(state, outcome, None))
        for state in reports.values()
        if (found := _compared(state, outcome, selected)) and len(found) < len(runs) and _tested(state, selected)
    }
    return look_at(
        [*map(len, looks), len(runs)],
        settings.alpha,
        planned=planned,
        runs_planned=runs_planned,
        runs_of_all=[*looks.values(), len(_compared(now, outcome, None))],
        one_sided=settings.one_sided and outcome.has_savings,
    )


def _tested(state: BookState, selected: frozenset[str] | None) -> bool:
    """Whether a report tested anything: what idle runs correct has no number before these make a line."""
    for outcome in Outcome:
        idle = [run for uid, run in state.runs.items() if run.kind is RunKind.IDLE and outcome in state.given(uid)]
        line = why_no_line([run.duration_s for run in idle if run.duration_s]) is None
        if _compared(state, outcome, selected) and (line or not outcome.shares_error):
            return True
    return False


def _compared(state: BookState, outcome: Outcome, selected: frozenset[str] | None) -> frozenset[str]:
    """Return the runs that gave an outcome, none where there was no control, or nothing beside it."""
    runs = [
        run
        for uid, run in state.runs.items()
        if run.kind is RunKind.JUMPS and outcome in state.given(uid) and (selected is None or uid in selected)
    ]
    return frozenset(run.uid for run in runs) if len({run.is_control for run in runs}) == 2 else frozenset()


def _planned(connection: sa.Connection, first_seq: int) -> tuple[int, int]:
    """Return the looks and the runs of jumps of the plans that stood at the first measurement."""
    plans: dict[str, Mapping[str, object]] = {}
    for entry in entries_about_plans(connection):
        if entry.seq > first_seq:
            break
        if entry.action is Action.EXCLUDE:
            plans.pop(entry.uid, None)
        else:
            plans[entry.uid] = entry.new
    looks = max((int(str(plan.get("looks", 1))) for plan in plans.values()), default=1)
    runs = [run for plan in plans.values() for run in plan["runs"]]  # type: ignore[attr-defined]
    return looks, sum(run["condition"] is not None for run in runs)


def look_at(
    runs: Sequence[int],
    alpha: float = 0.05,
    *,
    planned: int = 1,
    runs_planned: int | None = None,
    runs_of_all: Sequence[int] | None = None,
    one_sided: bool = False,
) -> Look:
    """Return the look that the last of `runs` is, the numbers of runs at each look so far.

    The last planned look, or the first with all planned runs, spends all of alpha; further ones keep its level.
    Levels are rounded down to three digits, so that what is said of them is what decides.
    Where the runs are a selection, `runs_of_all` are those of the study, of which the plan says how many there will be.
    """
    levels = [alpha] * len(runs)
    if planned > 1 and runs_planned:
        parts = [min(1.0, each / runs_planned) for each in runs_of_all or runs]
        last = next((at for at, part in enumerate(parts) if part == 1.0 or at == planned - 1), len(parts))
        times, made = [*parts[:last], 1.0][: len(parts)], (runs_of_all or runs)[: last + 1]
        found = nominal_levels(made, alpha, spending=times, one_sided=one_sided)
        levels = [_rounded_down(level) for level in (*found, *([found[-1]] * (len(runs) - len(found))))]
    share = share_in_error(runs, levels, one_sided=one_sided)
    return Look(len(runs), planned, (runs_of_all or runs)[-1], runs_planned, alpha, levels[-1], share)


def _rounded_down(level: float) -> float:
    unit = 10.0 ** (math.floor(math.log10(level)) - 2)
    return float(f"{math.floor(level / unit * (1.0 + 1e-12)) * unit:.2e}")
