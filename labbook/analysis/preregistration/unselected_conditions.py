"""Conditions that a selection leaves out whole.

Some levels of a group, compared without its others, are another comparison than the planned one, pooled or in one
family. A group that is left out whole takes nothing from the others' means, but its comparisons belong to the planned
family: Holm's p of a report counts them too (`rest_of_family`), and that they are not shown is told.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import RunKind
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.condition_order import place_configured
from labbook.analysis.preregistration.departures import Analysable, Departure
from labbook.config.model import Configuration

_MOST_NAMED = 4


def unselected_conditions(
    every: Analysable, configuration: Configuration, selected: Collection[str]
) -> list[Departure]:
    """List the conditions with numbers of which a selection (uids of runs) takes no run, group by group."""
    uids, swept = set(selected), pairing.swept_factor(configuration)
    control = None if swept is None else configuration.factors[swept].control
    groups: dict[tuple[tuple[str, str], ...], dict[str, list[RunRow]]] = {}
    for run in sorted(every.runs, key=lambda run: place_configured(configuration, run.levels)):
        if run.kind is RunKind.JUMPS and every.given(run):
            group = tuple(sorted((name, label) for name, label in run.levels.items() if name != swept))
            groups.setdefault(group, {}).setdefault(run.condition_key, []).append(run)
    whole: list[str] = []
    found = []
    for conditions in groups.values():
        left = [key for key, runs in conditions.items() if not any(run.uid in uids for run in runs)]
        treated = [key for key, runs in conditions.items() if runs[0].levels.get(str(swept)) != control]
        in_part = swept is not None and set(treated) - set(left) and set(treated) & set(left)
        if in_part:
            found.append(_of_group(every, conditions, left))
        else:
            whole += left
    if whole:
        found.append(
            Departure(
                f"the selection leaves out {_counted(whole)} whole, whose comparisons belong to the planned family "
                f"(Holm's p of a report counts them): {_listed(whole)}"
            )
        )
    return found


def _of_group(every: Analysable, conditions: Mapping[str, Sequence[RunRow]], left: Sequence[str]) -> Departure:
    given = {quantity for key in left for run in conditions[key] for quantity in every.given(run)}
    return Departure(
        f"the selection compares some levels of a group and leaves out {_counted(left)} of it whole: {_listed(left)}",
        tuple(quantity for quantity in Outcome if quantity in given),
        tuple(conditions),
    )


def _counted(keys: Collection[str]) -> str:
    return f"{len(keys)} condition{'' if len(keys) == 1 else 's'}"


def _listed(keys: Sequence[str]) -> str:
    """Name conditions, of many the first and how many more there are: what ends a sentence."""
    shown = "; ".join(keys[:_MOST_NAMED])
    return f"{shown}; and {len(keys) - _MOST_NAMED} more" if len(keys) > _MOST_NAMED else shown
