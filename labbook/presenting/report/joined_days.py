"""Whether groups are compared over the days of others: b with c where a shares days with both."""

from __future__ import annotations

from collections.abc import Collection, Mapping


def joined_by_others(label: str, control: str, days: Mapping[str, Collection[str]]) -> bool:
    """Whether days of other groups join a group and the control; `days` are those of every group.

    So it is where a chain of shared days leads from the one to the other over a third group.
    """
    others = {name: set(of_group) for name, of_group in days.items() if name != label}
    return any(
        _reached(control, {name for name in others if name != control and day in others[name]}, _without(others, day))
        for day in days[label]
    )


def _without(days: Mapping[str, set[str]], left_out: str) -> Mapping[str, set[str]]:
    return {name: of_group - {left_out} for name, of_group in days.items()}


def _reached(control: str, start: set[str], days: Mapping[str, set[str]]) -> bool:
    """Whether a chain of shared days leads from one of these groups to the control."""
    reached, new = set(start), set(start)
    while new:
        held = set().union(*(days[name] for name in new))
        new = {name for name, of_group in days.items() if of_group & held} - reached
        reached |= new
    return control in reached
