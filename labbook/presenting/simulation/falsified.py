"""A box that was searched for grounds on which active damping does not save: a sentence, lines for people, data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from data_schema.rounding import decimals_for, fixed_text
from labbook.presenting.simulation.simulated import set_by_user_line
from labbook.terminal import columns, within_width
from reports.display import count_text, list_text
from simulator.declared import all_parameters
from simulator.falsify import (
    FAILS,
    HEIGHT,
    NO_JUMP,
    SAME,
    SAME_WITHIN,
    SAVES,
    VERDICTS,
    Counterexample,
    Judged,
    Question,
    Searched,
    ground_at,
    interval,
    region_of,
)


def sentences(question: Question, searched: Searched) -> list[str]:
    """Say where the controller helps, where it does not, how sure that is, and where joules are no price."""
    found = _answer(question, searched)
    if count := searched.not_positive:
        found.append(
            f"On {count} of the {count_text(searched.says, 'ground')} that say something a cost is not positive: "
            "braking gives back more than the jump takes. There joules are compared, and there is no share of them; "
            "for a drive that gives nothing back add --effects +no_regeneration."
        )
    return found


def _answer(question: Question, searched: Searched) -> list[str]:
    counts, says = searched.counts, searched.says
    if not says:
        return ["No ground of the sample says anything of the claim."]
    found = (
        f"Active damping saves joules at {_equal(question)} on {_share(counts[SAVES], says)} of the grounds that say "
        f"something, makes no difference (less than {100.0 * SAME_WITHIN:g} %) on {_share(counts[SAME], says)}, and "
        f"costs more on {_share(counts[FAILS], says)} ({_interval(counts[FAILS], says)})."
    )
    failing = searched.failing
    if not len(failing):
        return [found, f"The search found no ground on which it costs more, either: {_most(says)}."]
    region = region_of(searched)
    if region is None:
        low, high = searched.shares[failing].min(axis=0), searched.shares[failing].max(axis=0)
        where = _box(question, low.tolist(), high.tolist())
        grounds = "the one ground" if len(failing) == 1 else f"the {len(failing)} grounds"
        return [found, f"It costs more at {where}, of {grounds} that were found."]
    (fail_inside, inside), (fail_outside, outside) = region.inside, region.outside
    elsewhere = f"{fail_outside} of {outside} ({_interval(fail_outside, outside)})"
    return [
        found,
        f"It costs more at {_box(question, region.low, region.high)}, where the failures of half the sample lie. Of "
        f"the other half {fail_inside} of {count_text(inside, 'ground')} there fail, and elsewhere "
        f"{elsewhere if fail_outside else f'none of {outside}: {_most(outside)}'}.",
    ]


def ground_sentence(judged: Judged, conditions: int) -> str:
    """Say on which side of the boundary a ground lies: the first `conditions` as they are, the others as varied."""
    verdict, saving = judged.verdict[:conditions], 100.0 * judged.saving[:conditions]
    shares = saving[~np.isnan(saving)]
    told = verdict < NO_JUMP
    if not told.any():
        return "Simulated on this ground, nothing can be said of joules at equal height: no two jumps reach one."
    fails, of = int((verdict == FAILS).sum()), int(told.sum())
    side = "saves" if not fails else "costs more" if fails == of else f"costs more in {fails}"
    joules = f" ({shares.min():.2g} to {shares.max():.2g} % of the joules)" if shares.size else ""
    varied = judged.verdict[conditions:]
    failing, among = int((varied == FAILS).sum()), int((varied < NO_JUMP).sum())
    beside = f"; with its assumed parameters varied it costs more in {failing} of {among}" if among else ""
    return (
        f"Simulated on this ground, active damping {side} at equal height, of {count_text(of, 'condition')}"
        f"{joules}{beside}."
    )


def _most(grounds: int) -> str:
    return f"at most {100.0 * interval(0, grounds)[1]:.2g} % of such grounds fail (95 %)"


def _box(question: Question, low: Sequence[float], high: Sequence[float]) -> str:
    first, last = ground_at(question, low), ground_at(question, high)
    return list_text([f"{name} {first[name]:.3g} to {last[name]:.3g}{_unit(name)}" for name in first])


def _unit(name: str) -> str:
    return all_parameters()[name].unit_text if name in all_parameters() else ""


def _equal(question: Question) -> str:
    return "equal height" if question.equal == HEIGHT else "equal gains"


def _share(count: int, of: int) -> str:
    return f"{100.0 * count / of:.3g} %"


def _interval(count: int, of: int) -> str:
    low, high = interval(count, of)
    return f"95 % interval {100.0 * low:.2g} to {100.0 * high:.2g} %"


def title(question: Question) -> str:
    """Return what heads the figure."""
    return f"{question.scene.name}: what active damping saves at {_equal(question)}, {_damping(question)}"


def _damping(question: Question) -> str:
    """Write the active damping, unless it is a parameter of the box."""
    name = question.damping
    if name in question.names:
        return f"{name} varied"
    return f"{name} = {question.scene[name]:g}{_unit(name)}"


def as_lines(question: Question, searched: Searched, examples: Sequence[Counterexample]) -> list[str]:
    """Return the lines for people."""
    scene, counts = question.sweep.scene, searched.counts
    unset = scene[question.damping] == 0.0 and question.damping not in question.names
    apart = [f"{VERDICTS[verdict]} {count}" for verdict, count in counts.items() if verdict >= NO_JUMP and count]
    said = [
        f"{scene.name}: {scene.title}",
        f"claim: active damping ({_damping(question)}{', as none was set' if unset else ''}) saves joules at "
        f"{_equal(question)}, over {', '.join(question.over)}.",
        "",
        *sentences(question, searched),
        "",
        f"{count_text(searched.sample, 'ground')}, {question.sweep.design.description}, of which {searched.says} say "
        f"something ({_share(searched.says, searched.sample)} of the box), and "
        f"{len(searched.shares) - searched.sample} of the search from its hollows.",
        *([f"apart: {', '.join(apart)}."] if apart else []),
    ]
    table = _table(examples) if examples else []
    return [*within_width(said), *table, *within_width(set_by_user_line(scene))]


def _table(examples: Sequence[Counterexample]) -> list[str]:
    """Set the grounds side by side, numbered as in the figure, so that a terminal holds any number of parameters."""
    confirmed = sum(one.confirmed for one in examples)
    names = (
        *examples[0].ground,
        *("CE N/m", "AD N/m", "CE J", "AD J", "AD costs more J", "± J", "apex m", "other solver within J", "confirmed"),
    )
    cells = zip(names, *map(_cells, examples), strict=True)
    return [
        "",
        *within_width(
            [
                f"grounds on which it costs more, the worst first; {confirmed} of {len(examples)} are confirmed, with "
                "error bars and by another solver:"
            ]
        ),
        "",
        *columns(("", *(str(number) for number in range(1, len(examples) + 1))), list(cells)),
    ]


def _cells(one: Counterexample) -> list[str]:
    ce, ad = one.jumps
    places = decimals_for(one.bar_j) if 0.0 < one.bar_j < 1.0 else 4
    return [
        *(f"{value:.4g}" for value in one.ground.values()),
        *(f"{value:.5g}" for value in one.stiffness),
        *(f"{jump.cost_J:.5g}" for jump in (ce, ad)),
        fixed_text(one.more_j, places),
        f"{one.bar_j:.1g}",
        "-" if ad.apex_height_m is None else f"{ad.apex_height_m:.4g}",
        "gave up" if one.solver_j is None else f"{one.solver_j:.1g}",
        "yes" if one.confirmed else "no",
    ]


def as_data(question: Question, searched: Searched, examples: Sequence[Counterexample]) -> dict[str, Any]:
    """Return the same for programs."""
    counts, region = searched.counts, region_of(searched)
    return {
        "scene": question.scene.name,
        "claim": "saves",
        "equal": question.equal,
        "damping": {question.damping: question.scene[question.damping]},
        "over": list(question.over),
        "grounds": searched.sample,
        "searched": len(searched.shares) - searched.sample,
        "verdicts": {VERDICTS[verdict]: count for verdict, count in counts.items()},
        "share_failing": counts[FAILS] / searched.says if searched.says else None,
        "share_failing_95": list(interval(counts[FAILS], searched.says)),
        "failing": len(searched.failing),
        "cost_not_positive": searched.not_positive,
        "region": None
        if region is None
        else {
            "low": ground_at(question, region.low),
            "high": ground_at(question, region.high),
            "inside_failing_of": list(region.inside),
            "outside_failing_of": list(region.outside),
        },
        "sentences": sentences(question, searched),
        "counterexamples": [
            {
                "ground": one.ground,
                "k_extension": {"ce": one.stiffness[0], "ad": one.stiffness[1]},
                "cost_J": {"ce": one.jumps[0].cost_J, "ad": one.jumps[1].cost_J},
                "apex_height_m": {"ce": one.jumps[0].apex_height_m, "ad": one.jumps[1].apex_height_m},
                "more_J": one.more_j,
                "bar_J": one.bar_j,
                "other_solver_J": one.solver_j,
                "confirmed": one.confirmed,
            }
            for one in examples
        ],
    }
