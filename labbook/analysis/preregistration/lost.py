"""Which planned comparisons are not made any more, because all runs of a condition that gave numbers are void."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.vocabulary import RunKind, RunState
from labbook.analysis.comparison import pairing
from labbook.analysis.preregistration.book_state import BookHistory, BookState, state_at
from labbook.analysis.preregistration.departures import Departure, DepartureKind, first_named
from labbook.config.model import AnalysisSettings, Configuration, Family


def comparisons_lost(
    history: BookHistory,
    now: BookState,
    first_seq: int,
    configuration: Configuration,
    settings: AnalysisSettings,
    since: Sequence[Departure],
) -> list[Departure]:
    """List group by group the comparisons of the primary outcome that void runs took away, after an entry.

    Where a report had seen these runs, which the departures `since` that entry tell, all other comparisons are
    exploratory: one that was seen and taken away makes Holm's p of the others smaller.
    """
    swept, outcome = pairing.swept_factor(configuration), settings.primary_outcome
    void = {uid for uid, run in now.runs.items() if run.state is RunState.VOID and run.kind is RunKind.JUMPS}
    if swept is None or not void:
        return []
    before, control = state_at(history, first_seq, arrivals=False), configuration.factors[swept].control
    groups: dict[tuple[tuple[str, str], ...], dict[str, bool]] = {}
    counting = set[str]()
    for uid, run in now.runs.items():
        counts = run.kind is RunKind.JUMPS and outcome in now.given(uid)
        if swept in run.levels and (counts or (uid in void and outcome in before.given(uid, surplus=False))):
            group = tuple(sorted((name, label) for name, label in run.levels.items() if name != swept))
            groups.setdefault(group, {})[run.condition_key] = run.levels[swept] == control
            counting |= {run.condition_key} if counts else set()
    seen = {key for item in since if item.kind is DepartureKind.VOIDED for key in item.conditions or ()}
    found = []
    for conditions in groups.values():
        treated, gone = [key for key in conditions if not conditions[key]], conditions.keys() - counting
        alone = all(key in gone for key in conditions if conditions[key])  # no control counts
        lost = [key for key in treated if alone or key in gone]
        pooled = settings.family is Family.POOLED
        if not gone or len(treated) == len(conditions) or not lost or (pooled and len(lost) < len(treated)):
            continue
        named, after = first_named(lost, "; "), " after a report had been made" if seen & gone else ""
        one = pooled or len(lost) == 1
        words = {
            "compared": f"comparison{'' if one else 's'} of {named} with the control",
            "conditions": first_named([key for key in conditions if key in gone], "; "),
            "after": after,
        }
        found.append(Departure(DepartureKind.COMPARISONS_LOST, words, (outcome,) if after else ()))
    return found
