"""What the choice of runs for a report or a comparison leaves out: it could have been made after looking at them.

Some runs of a condition are another condition, and some levels of a group, compared without its others, are another
comparison than the planned one. A group that is left out whole takes nothing from the others' means, but its
comparisons belong to the planned family: Holm's p of a report counts them too (`unselected_comparisons`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from data_schema.queries.runs import RunRow
from data_schema.vocabulary import RunKind
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.condition_order import place_configured
from labbook.analysis.preregistration.book_state import BookState
from labbook.analysis.preregistration.departures import Departure, DepartureKind, in_order
from labbook.config.model import Configuration

_MOST_NAMED = 4


def unselected(now: BookState, configuration: Configuration, selected: Collection[str]) -> list[Departure]:
    """List what a selection (uids of runs) leaves out: of conditions, of groups, and of the planned family."""
    uids, swept = set(selected), pairing.swept_factor(configuration)
    control = None if swept is None else configuration.factors[swept].control
    given = {run.uid: now.given(run.uid) for run in now.runs.values() if run.kind is RunKind.JUMPS}
    runs = [run for run in now.runs.values() if given.get(run.uid)]
    groups: dict[tuple[tuple[str, str], ...], dict[str, list[RunRow]]] = {}
    for run in sorted(runs, key=lambda run: place_configured(configuration, run.levels)):
        group = tuple(sorted((name, label) for name, label in run.levels.items() if name != swept))
        groups.setdefault(group, {}).setdefault(run.condition_key, []).append(run)
    found: list[Departure] = []
    whole: list[str] = []
    for key, of_condition in (item for conditions in groups.values() for item in conditions.items()):
        taken = {outcome for run in of_condition if run.uid in uids for outcome in given[run.uid]}
        others = {run.name: given[run.uid] & taken for run in of_condition if run.uid not in uids}
        if names := [name for name, outcomes in others.items() if outcomes]:
            parameters = {"runs": f"{'run' if len(names) == 1 else 'runs'} {', '.join(names)}", "condition": key}
            quantities = in_order(frozenset().union(*others.values()))
            found.append(Departure(DepartureKind.RUNS_UNSELECTED, parameters, quantities, (key,)))
    for conditions in groups.values():
        left = [key for key, some in conditions.items() if not any(run.uid in uids for run in some)]
        treated = {key for key, some in conditions.items() if some[0].levels.get(str(swept)) != control}
        if swept is not None and treated & set(left) and treated - set(left):
            quantities = in_order(frozenset().union(*(given[run.uid] for key in left for run in conditions[key])))
            found.append(Departure(DepartureKind.LEVELS_UNSELECTED, _listed(left), quantities, tuple(conditions)))
        else:
            whole += left
    return [*found, *([Departure(DepartureKind.CONDITIONS_UNSELECTED, _listed(whole))] if whole else ())]


def _listed(keys: Sequence[str]) -> dict[str, str]:
    """Count and name conditions, of many the first and how many more there are."""
    more = [f"and {len(keys) - _MOST_NAMED} more"] if len(keys) > _MOST_NAMED else []
    return {
        "count": f"{len(keys)} condition{'' if len(keys) == 1 else 's'}",
        "conditions": "; ".join([*keys[:_MOST_NAMED], *more]),
    }
