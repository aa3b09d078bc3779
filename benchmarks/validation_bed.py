"""The campaign of chapter 5 in a closed loop: from charges and run means of apexes alone, and through files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, astuple, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.validation_emulator import LEVEL, charged
from benchmarks.worlds.conditions import conditions_of, run_number, run_row
from data_schema.outcomes import Outcome
from data_schema.vocabulary import RunKind, Undefined
from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.comparison.pairing import group_label, pairs_each, pairs_pooled
from labbook.analysis.outcomes.conditions import ConditionValues, conditions_by_outcome
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_energy import joules_per_mah
from labbook.analysis.results import Results
from labbook.analysis.study_data import gather
from labbook.book.opening import opened
from labbook.demo.campaign import Campaign, make_campaign
from labbook.demo.files import campaign_files
from labbook.demo.running import make_campaign_book
from labbook.demo.truth import CHAPTER_5, CONTROL_GAIN, Condition
from stats.compare.shared_error import describe_shared, shared_of_mean
from stats.days.overall import overall_savings
from stats.lines.passive_drain import PassiveDrain, fit_passive_drain

Conditions = Mapping[Outcome, Sequence[ConditionValues]]
SWEPT = "b_ad_gain"
SHOWN = (Condition("large", 400, 250), Condition("small", 300, 50))
"""Treated conditions that are looked at alone, and their controls."""


def from_charges(chance: np.random.Generator) -> Conditions:
    """Draw the campaign without files."""
    return as_charged(make_campaign(int(chance.integers(2**31))))


def drain_of(campaign: Campaign) -> PassiveDrain:
    """Fit the passive drain of a campaign."""
    idle = campaign.of_kind(RunKind.IDLE)
    line = fit_passive_drain([run.duration_s for run in idle], [run.charge_mah for run in idle], resolution_mah=1.0)
    assert isinstance(line, PassiveDrain)
    return line


def as_charged(campaign: Campaign) -> Conditions:
    """Return the joules of a campaign as the charger reads it, and the run means of its true apexes."""
    truth, line = campaign.truth, drain_of(campaign)
    joules, apexes = [], []
    for run in campaign.of_kind(RunKind.JUMPS):
        assert run.condition is not None
        levels = {name: str(level) for name, level in asdict(run.condition).items()}
        is_control = run.condition.is_control
        row = run_row(run.name, run.date.isoformat(), levels, is_control=is_control, duration_s=run.duration_s)
        worth_j = joules_per_mah(truth.reference_voltage_v, run.jumps_made)
        joules.append(charged(row, run, line, worth_j))
        apexes.append(run_number(row, run.reached_apexes_m.mean()))
    return {Outcome.JOULES: conditions_of(joules), Outcome.APEX: conditions_of(apexes)}


def bed_book(chance: np.random.Generator) -> Conditions:
    """Draw the campaign through files and ingest, and measure joules and apexes of its runs."""
    campaign = make_campaign(int(chance.integers(2**31)))
    with TemporaryDirectory() as folder:
        made = make_campaign_book(
            Path(folder) / "demo", campaign_files(campaign), lambda _step: None, lambda _line: None
        )
        with opened(made) as book, book.reading() as connection:
            return conditions_by_outcome(
                Results(),
                Detections(connection, book.store, lambda _step: None),
                gather(connection, book.configuration, None),
                (Outcome.JOULES, Outcome.APEX),
            )


def intervals(conditions: Conditions) -> Mapping[str, tuple[float, float] | Undefined]:
    """Return the report's intervals: over all groups, of each, and of conditions alone."""
    joules, apexes = conditions[Outcome.JOULES], conditions[Outcome.APEX]
    contrasts = {group_label(pair.group): contrast_of(pair) for pair in pairs_pooled(joules, SWEPT)}
    found = {"saving, overall": overall_savings(contrasts, LEVEL).estimate.ci}
    found |= {f"saving, {group}": contrast.savings(LEVEL).ci for group, contrast in contrasts.items()}
    for pair in pairs_pooled(apexes, SWEPT):
        found[f"change of apex, {group_label(pair.group)}"] = contrast_of(pair).difference(LEVEL).ci
    for pair in pairs_each(joules, SWEPT):
        if (pair.group["foot"], int(pair.group["k_gain"]), int(pair.level)) in map(astuple, SHOWN):
            found[f"saving, {group_label(pair.group)}, {SWEPT} {pair.level}"] = contrast_of(pair).savings(LEVEL).ci
    found |= dict(_means(joules, "joules")) | dict(_means(apexes, "apex"))
    return found


def _means(conditions: Sequence[ConditionValues], what: str) -> Iterator[tuple[str, tuple[float, float] | Undefined]]:
    shown = {_name(what, condition) for one in SHOWN for condition in (one, replace(one, b_ad_gain=CONTROL_GAIN))}
    for one in conditions:
        name = _name(what, Condition(one.levels["foot"], int(one.levels["k_gain"]), int(one.levels[SWEPT])))
        if name in shown:
            mean = describe_shared(one.values, shared_of_mean([run.shared for run in one.runs]), LEVEL)
            if isinstance(mean.ci_low, Undefined):
                yield name, mean.ci_low
            elif not isinstance(mean.ci_high, Undefined):
                yield name, (mean.ci_low, mean.ci_high)


def _name(what: str, condition: Condition) -> str:
    return f"{what}, {group_label({name: str(level) for name, level in asdict(condition).items()})}"


def truths() -> dict[str, float]:
    """Return what is true of the intervals."""
    bed = CHAPTER_5
    found = {"saving, overall": 100.0 * float(np.mean([bed.saving(one.foot, one.k_gain) for one in bed.groups]))}
    for of_group in bed.groups:
        label = group_label({"foot": of_group.foot, "k_gain": str(of_group.k_gain)})
        found[f"saving, {label}"] = 100.0 * bed.saving(of_group.foot, of_group.k_gain)
        treated_m = np.mean([of_group.apex_height_m(gain) for gain in bed.ad_gains])
        found[f"change of apex, {label}"] = float(treated_m) - of_group.apex_height_m(CONTROL_GAIN)
    for one in SHOWN:
        found[_name("saving", one)] = 100.0 * bed.saving(*astuple(one))
        for condition in (one, replace(one, b_ad_gain=CONTROL_GAIN)):
            found[_name("joules", condition)] = bed.joules_per_jump(condition)
            found[_name("apex", condition)] = bed.apex_height_m(condition)
    return found
