"""What `labbook stats anova` does: all groups together, all pairs, and each against the control."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from labbook.actions.stats_compare import compared, holm_of
from labbook.actions.stats_data import Given, observe
from labbook.actions.stats_pictures import Pictures
from labbook.actions.stats_told import Told, alpha_of, told_of
from labbook.analysis.observations import Observations
from labbook.presenting.stats_days import day_notes, days_untold
from labbook.presenting.stats_fields import field_lines
from labbook.presenting.stats_figures import estimation_of, number_of
from labbook.presenting.stats_many import against_control_text, all_pairs_text
from labbook.presenting.stats_plan import NO_ANOVA, plan_notes
from stats.anova import one_way_anova
from stats.checks import Missing
from stats.dunnett import dunnett
from stats.finite import as_interval
from stats.results import as_dict
from stats.tukey import compare_all_pairs
from stats.variances import bartlett, brown_forsythe, levene
from stats.welch_anova import welch_anova

SHARED_NOTE = "The error of the passive drain, which groups share in part, is left out of this."


def analyse(
    given: Given, alpha: float | None, level: float | None, pictures: Pictures, step: Callable[[str], None]
) -> Told:
    """Analyse the variance of all groups; intervals of pairs and against the control are simultaneous."""
    pictures.check()
    observed = observe(given, step)
    observed.others()
    alpha = alpha_of(alpha, level, observed)
    return told_of(observed, pictures, lambda own, drawn: _answer(own, given, alpha, drawn, step))


def _answer(
    observed: Observations, given: Given, alpha: float, pictures: Pictures, step: Callable[[str], None]
) -> Told:
    others = observed.others()
    level, missing = 1.0 - alpha, cast(Missing, given.missing)
    groups, control, unit = observed.groups(), observed.name(observed.control), observed.unit

    step(f"{len(groups)} groups")
    classic = one_way_anova(groups, level=level, missing=missing)
    welch = welch_anova(groups, level=level, missing=missing)
    variances = [test(groups, missing=missing) for test in (brown_forsythe, levene, bartlett)]
    step("all pairs by Tukey")
    tukey = compare_all_pairs(groups, variances="equal", level=level, missing=missing)
    step("all pairs by Games and Howell")
    games_howell = compare_all_pairs(groups, variances="unequal", level=level, missing=missing)
    step("Dunnett's test")
    treatments = {name: values for name, values in groups.items() if name != control}
    against = dunnett(groups[control], treatments, control_name=control, level=level, missing=missing)
    tests = {label: compared(observed, label, "welch", alpha, given.missing) for label in others}
    family = holm_of(tests, observed, alpha)

    told = Told()
    told.lines += [
        classic.sentence(observed.shown_by or observed.by),
        welch.sentence(observed.shown_by or observed.by),
        *(test.sentence() for test in variances),
        all_pairs_text(tukey, unit),
        all_pairs_text(games_howell, unit),
        against_control_text(against, unit),
        family.sentence(),
    ]
    if untold := days_untold(observed):
        told.lines.append(f"{untold}.")
    told.say("one-way ANOVA", field_lines(classic))
    told.say("Welch ANOVA", field_lines(welch))
    told.show("equal variances", variances, left_out=("ratio_ci", "level"))
    told.show(f"all pairs by {tukey.method}", tukey.pairs)
    told.show(f"all pairs by {games_howell.method}", games_howell.pairs)
    told.show(f"Dunnett against {control}", against.comparisons)
    told.say("Holm", field_lines(family))
    told.data |= {
        "one_way": as_dict(classic),
        "welch": as_dict(welch),
        "variances": [as_dict(test) for test in variances],
        "tukey": as_dict(tukey),
        "games_howell": as_dict(games_howell),
        "dunnett": as_dict(against),
        "holm": as_dict(family),
    }
    found = dict(zip(others, against.comparisons, strict=True))
    step("figures" if pictures.files else "tables")
    pictures.write(
        observed,
        lambda: estimation_of(
            observed,
            {
                label: number_of(one.difference, as_interval(one.ci_low, one.ci_high), level, unit)
                for label, one in found.items()
            },
            interval="Dunnett's test",
        ),
        level,
    )
    notes = [*plan_notes(observed, False, alpha, NO_ANOVA), *day_notes(observed)]
    if any(row.shared.se > 0.0 for row in observed.rows):
        notes.append(f"{SHARED_NOTE} Holm's family has it.")
    return told.about(observed, pictures, notes)
