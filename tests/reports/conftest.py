"""A report's content as a whole campaign would fill it, made from a seeded generator; no book is needed."""

import dataclasses
import math
from datetime import date, timedelta

import numpy as np
import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import ContrastKind, Rule, Undefined
from labbook.analysis.comparison.comparisons import thesis_route
from labbook.analysis.comparison.deciding import decide_by_contrast, equivalence_by_contrast
from labbook.analysis.prediction.checking import agreement
from labbook.config.model import Bounds
from reports import results as parts
from reports.claims import group_claim
from reports.display import LogGap, LogJump, RunLog
from reports.numbers import Number
from reports.page.writing import report_files, write_report
from reports.results import Factor, Flow, Hypothesis, HypothesisPart, Level, PredictedQuantity, Verdict
from stats.compare.summary import describe
from stats.days.decision import contrast_by_day
from stats.groups.anova import one_way_anova
from stats.lines.passive_drain import fit_passive_drain
from tests.helpers.judged import judged
from tests.helpers.once import made_once

FACTORS = (
    Factor("foot", "Foot", symbol="r", unit="m"),
    Factor("k_gain", "Extension stiffness", symbol="k", unit="N/m", slope=2.56, offset=67.36),
    Factor(
        "b_ad_gain",
        "Active-damping coefficient",
        symbol="d",
        unit="kg/s",
        slope=3.32,
        offset=19.67,
        control="0",
        swept=True,
        treatment="active damping",
        control_name="CE",
    ),
)
RADIUS_M = {"small": 0.038, "large": 0.051}
CE_J = {("small", 300): 17.6, ("small", 400): 18.1, ("large", 300): 17.2, ("large", 400): 17.7}
SAVED = {("small", 300): 0.10, ("small", 400): 0.15, ("large", 300): 0.04, ("large", 400): 0.08}
AD_GAINS = (0, 50, 100, 150, 200, 250)


class Maker:
    """Draws values and counts provenance ids."""

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)
        self.provenance = []

    def id(self, what, inputs):
        name = f"{0xA1F03 + 7919 * len(self.provenance):07x}"
        self.provenance.append(parts.Provenance(name, what, inputs))
        return name

    def mean(self, values, unit, what):
        found = describe(values)
        shared, df, key = 0.21 if unit == "J" else None, found.n - 1.0, self.id(what, found.n)
        ends = {"ci_low": found.ci_low, "ci_high": found.ci_high}
        return Number(found.mean, unit, found.se, shared, **ends, df=df, n=found.n, provenance=key), found.sd


def _levels(foot, k_gain, ad_gain):
    return (
        Level("foot", foot, RADIUS_M[foot], "m"),
        Level("k_gain", str(k_gain), 2.56 * k_gain + 67.36, "N/m", float(k_gain)),
        Level("b_ad_gain", str(ad_gain), 3.32 * ad_gain + 19.67 if ad_gain else 0.0, "kg/s", float(ad_gain)),
    )


def _condition(maker, foot, k_gain, ad_gain):
    n = 14 if ad_gain == 0 else 10
    true_j = CE_J[foot, k_gain] * (1 - (SAVED[foot, k_gain] if ad_gain else 0))
    true_m = 0.4385 + (0.004 if k_gain == 400 else 0) + (0.0018 if ad_gain else 0)
    joules = maker.random.normal(true_j, 1.3, n)
    apexes = maker.random.normal(true_m, 0.0014, n)
    names = [f"r{foot[0]}{k_gain}{ad_gain:03d}{i:02d}" for i in range(n)]
    text = f"{foot} foot, k gain {k_gain}, AD gain {ad_gain}"
    summaries = []
    for values, unit, what in ((joules, "J", "joules a jump"), (apexes, "m", "apex height")):
        mean, sd = maker.mean(values, unit, f"mean {what}, {text}")
        runs = tuple((name, float(value)) for name, value in zip(names, values, strict=True))
        summaries.append(parts.ConditionSummary(mean, Number(sd, unit), runs))
    return parts.Condition(_levels(foot, k_gain, ad_gain), ad_gain == 0, dict(zip(Outcome, summaries, strict=False)))


def _values(condition, quantity):
    summary = condition.summaries[quantity]
    return [value for _run, value in summary.runs]


def _comparison(maker, quantity, group, level, control, treated, family, headline=False):
    """Decide by five days, each with runs of both sides; the thesis's route stands beside."""
    label, n = " ".join([*group.values(), level]), len(control) + len(treated)
    found = contrast_by_day(treated, control, days_treated=[place % 5 for place in range(len(treated))],
                            days_control=[place % 5 for place in range(len(control))])  # fmt: skip
    saves = quantity is Outcome.JOULES
    decision = decide_by_contrast(found, quantity.unit, 0.05, with_savings=saves, shares_error=False)

    def named(number, what):
        return None if number is None else dataclasses.replace(number, provenance=maker.id(f"{what}, {label}", n))

    decision = dataclasses.replace(
        decision,
        difference=named(decision.difference, f"difference in {quantity}"),
        savings=named(decision.savings, "savings"),
        equivalence=None if saves else _equivalence(maker, label, found),
    )
    if headline:
        adjusted = Number(min(1.0, 4 * decision.p.value), "1", n=4, provenance=maker.id(f"adjusted p, {label}", 4))
        decision = dataclasses.replace(decision, adjusted=adjusted, adjusted_rejected=adjusted.value <= 0.05)
    route = thesis_route(control, treated, quantity.unit, 0.05)
    route = dataclasses.replace(route, difference=named(route.difference, "difference over runs"))
    over_jumps = route if not saves and level == "pooled" else None
    return parts.Comparison(label, quantity, group, level, family, decision, route, over_jumps)


def _equivalence(maker, label, found):
    tested = equivalence_by_contrast(found, Bounds(-0.005, 0.005, percent=False), 0.05)
    estimate = dataclasses.replace(tested.estimate, provenance=maker.id(f"equivalence, {label}", sum(found.n)))
    return dataclasses.replace(tested, estimate=estimate)


def _comparisons(maker, conditions):
    made, anovas = [], []
    for quantity in (Outcome.JOULES, Outcome.APEX):
        for foot, k_gain in CE_J:
            of_group = [c for c in conditions if (c.levels[0].label, c.levels[1].label) == (foot, str(k_gain))]
            group = {"foot": foot, "k_gain": str(k_gain)}
            control = _values(of_group[0], quantity)
            pooled = [value for condition in of_group[1:] for value in _values(condition, quantity)]
            made.append(_comparison(maker, quantity, group, "pooled", control, pooled, "pooled over the AD gain", True))
            for condition in of_group[1:]:
                level = condition.levels[2].label
                values = _values(condition, quantity)
                made.append(_comparison(maker, quantity, group, level, control, values, "each AD gain"))
            found = one_way_anova([_values(c, quantity) for c in of_group[1:]])
            p = Number(found.p, "1", provenance=maker.id(f"ANOVA {foot} {k_gain}", 50))
            anovas.append(parts.Anova(f"{foot} {k_gain}", quantity, group, Number(found.f, "1"), p, 4, 45, 50))
    made.sort(key=lambda c: c.family != "pooled over the AD gain")
    return tuple(made), tuple(anovas)


def _drain(maker):
    minutes = np.repeat([20.0, 24.0, 30.0, 40.0, 50.0, 60.0], 2)
    charge = np.round(5.62 * minutes + 18.7 + maker.random.normal(0, 1.2, minutes.size))
    fit = fit_passive_drain((60 * minutes).tolist(), charge.tolist(), resolution_mah=1.0)
    at_run, key = fit.at(720), maker.id("passive-drain fit", minutes.size)

    def number(value, unit, error, ci):
        return Number(value, unit, se=error, ci_low=ci[0], ci_high=ci[1], df=fit.df, n=fit.n, provenance=key)

    a_minute = [60 * end for end in fit.slope_ci_mah_s()]
    numbers = parts.DrainFit(
        slope=number(60 * fit.slope_mah_s, "mAh/min", 60 * fit.slope_se_mah_s, a_minute),
        intercept=number(fit.intercept_mah, "mAh", fit.intercept_se_mah, fit.intercept_ci_mah()),
        r_squared=Number(fit.r_squared, "1", provenance=key),
        at_run=number(at_run.charge_mah, "mAh", at_run.se, (at_run.ci_low, at_run.ci_high)),
        run_duration_s=720.0,
    )
    runs = enumerate(zip(minutes.tolist(), charge.tolist(), strict=True))
    idle = tuple(parts.IdleRun(f"idle{i:02d}", 60 * at, mah) for i, (at, mah) in runs)
    return parts.Drain("hopper", fit, numbers, idle)


def _runs(conditions):
    found, today, position = {}, date(2021, 5, 3), 0
    for condition in conditions:
        for run, _value in condition.summaries[Outcome.JOULES].runs:
            position += 1
            if position > 14:
                position, today = 1, today + timedelta(days=1)
            found[run] = parts.Run(today.isoformat(), position, "AB"[today.day % 2], "hopper")
    return found


def _packs(maker, conditions, runs):
    deviations = {run: off for each in conditions for run, off in parts.joule_deviations(each).items()}
    by_pack = {pack: [off for run, off in deviations.items() if runs[run].pack == pack] for pack in "AB"}
    return {pack: parts.PackDeviation(maker.mean(off, "J", f"pack {pack}")[0]) for pack, off in by_pack.items()}


def _days(runs):
    names = list(dict.fromkeys(run.day for run in runs.values()))
    return tuple(
        parts.Day(
            name,
            tuple(run for run, about in runs.items() if about.day == name),
            conditions=("small foot, k = 1091 N/m: CE, d = 186, 352 kg/s",),
            packs=tuple(dict.fromkeys(about.pack for about in runs.values() if about.day == name)),
            checks_made=("rail angle", "lubrication"),
            checks_not_made=("sensor zero",) if index == 2 else (),
        )
        for index, name in enumerate(names)
    )


def _variations(comparisons, days):
    found = []
    for comparison in comparisons:
        base = comparison.decision.savings
        if not comparison.opens or base is None:
            continue
        labels = {"without exclusions": "", "with the published detector": ""}
        labels |= {f"without {day.date}": day.date for day in days}
        for i, (label, day) in enumerate(labels.items()):
            off = 0.4 * math.sin(i)
            ends = {"ci_low": base.ci_low + off, "ci_high": base.ci_high + off}
            moved = dataclasses.replace(base, value=base.value + off, **ends, provenance="")
            decision = dataclasses.replace(comparison.decision, savings=moved)
            found.append(parts.Varied(comparison.label, label, comparison.quantity, decision, day))
    return tuple(found)


def _prediction(maker, quantity, group, level, control, n, measured, value, se):
    key = maker.id(f"predicted {quantity}, {' '.join([*group.values(), level])}", 3)
    predicted = Number(value, measured.unit, se=se, provenance=key)
    check = parts.PredictionCheck(predicted, *agreement(measured, value, se), {}, 1e-7 * abs(value))
    return parts.Prediction(quantity, group, level, control, n, measured, check)


def _predictions(maker, conditions, comparisons):
    items = []
    for quantity, outcome in ((PredictedQuantity.JOULES, Outcome.JOULES), (PredictedQuantity.APEX, Outcome.APEX)):
        for condition in conditions:
            summary, levels = condition.summaries[outcome], {level.factor: level.label for level in condition.levels}
            level, scale = levels.pop("b_ad_gain"), 1.04 if levels["foot"] == "large" else 0.995
            mean = summary.mean
            items.append(_prediction(maker, quantity, levels, level, condition.control, mean.n, mean,
                                     mean.value * scale, 0.002 * mean.value))  # fmt: skip
    items += [
        _prediction(maker, PredictedQuantity.SAVINGS, c.group, c.level, False, saved.n, saved, saved.value - 2.0, 0.7)
        for c in comparisons
        for saved in [c.decision.savings]
        if saved is not None
    ]  # fmt: skip
    return parts.Predictions(
        "bed", 1e-6, ("active_damping", "motor_heat"), ("surface",), {"b_ad_gain": "kg/m"}, tuple(items),
        judged(items, lambda what: maker.id(what, 60)),
        (parts.AssumedInput("kg_scale", parts.AssumedParameter(1.4, "1", "fitted", 0.1), {
             PredictedQuantity.JOULES: 1.25, PredictedQuantity.APEX: 0.0042, PredictedQuantity.CONTACT_TIME: 0.002,
             PredictedQuantity.SAVINGS: 0.61,
         }),
         parts.AssumedInput("foot_mass", parts.AssumedParameter(0.2, "kg", "a tenth of the robot", 0.05), {
             PredictedQuantity.JOULES: 0.3, PredictedQuantity.APEX: Undefined(Reason.AS_SAID, said="it folds"),
         })),
        branched=1, on_edge=2, grown=3,
    )  # fmt: skip


def _hypotheses(maker, comparisons):
    def part(c, low, high, value, **other):
        key = maker.id(f"hypothesis, {c.group}", 30)
        saved = c.decision.savings
        measured = Number(-saved.value, "%", saved.se, None, -saved.ci_high, -saved.ci_low, 0.9, 12.0, 26, key)
        return HypothesisPart(c.group, {}, measured, Number(value, "%", se=0.8), Verdict.HOLDS, Verdict.CANNOT_TELL,
                              low, high, **other)  # fmt: skip

    pooled = [c for c in comparisons if c.decision.savings is not None and c.level == "pooled"]
    days = {"days_treated": ["2021-06-01"] * 2, "days_control": ["2021-06-02"] * 2}
    untold = contrast_by_day([41.0, 42.0], [40.0, 41.0], **days).savings().ci
    feet = HypothesisPart(
        {"k_gain": "400", "foot": "small"}, {"foot": "large"}, Number(2.4, "%", n=20, provenance=maker.id("feet", 30)),
        Number(Undefined(Reason.NOT_SIMULATED), "%"), Verdict.CANNOT_TELL, Verdict.CANNOT_TELL, -10.0, 10.0, untold,
    )  # fmt: skip
    return (
        Hypothesis("saves", "Active damping saves", "thesis 5.2.1", "p < .05",
                   tuple(part(c, None, 0.0, -3.0 - i) for i, c in enumerate(pooled))),
        Hypothesis("feet", "CE costs the same with either foot", "", "", (feet,)),
        Hypothesis("stiffness", "Stiffness does not matter", "", "", ()),
    )  # fmt: skip


def _contrasts(maker):
    def contrast(kind, levels, side="", estimate=None, **more):
        found = {
            "kind": kind, "quantity": Outcome.JOULES, "factor": "foot", "levels": levels, "side": side, "per": 1.0,
            "at": None, "left_out": 0, "estimate": estimate, "t": Number(2.9, "1", df=4.0), "p": Number(0.044, "1"),
            "adjusted": Number(0.088, "1", n=5), "rejected": False, "rule": Rule.PAIRED,
            "days": ("2021-06-01", "2021-06-02", "2021-06-03", "2021-06-04", "2021-06-05"),
        }  # fmt: skip
        return parts.MeansContrast(**(found | more))

    points = Number(3.1, "%", se=1.1, ci_low=0.1, ci_high=6.1, n=253, df=4.0, provenance=maker.id("contrast", 12))
    joules = Number(-2.1, "J", se=0.8, ci_low=-4.3, ci_high=0.1, n=80, df=4.0, provenance=maker.id("contrast", 4))
    return (
        contrast(
            ContrastKind.DIFFERENCE, ("large", "small"), "control", joules, exploratory="no contrasts were planned"
        ),
        contrast(ContrastKind.INTERACTION, ("large", "small"), estimate=points, rejected=True),
        contrast(ContrastKind.TREND, ("50", "100", "250"), estimate=points, factor="b_ad_gain", per=100.0),
        contrast(ContrastKind.LEVELS_OFF, ("50", "250"), estimate=points, factor="b_ad_gain", per=100.0, at=150.0),
    )


def _budget():
    def sizes(*joules):
        return {name: Number(size, "J", n=10) for name, size in zip(names, joules, strict=True)}

    sources = (
        parts.BudgetSource("scatter between runs", shared=False, in_scatter=False, assumed=False),
        parts.BudgetSource(parts.OF_DRAIN, shared=True, in_scatter=False, assumed=False),
        parts.BudgetSource("charger resolution", shared=False, in_scatter=True, assumed=False),
        parts.BudgetSource("reference voltage", shared=True, in_scatter=False, assumed=True),
    )
    names = [*(source.name for source in sources), parts.IN_ALL]
    means = sizes(0.41, 0.21, 0.20, 0.12, 0.48)
    levels = {"foot": "small", "k_gain": "400", "b_ad_gain": "0"}
    return parts.JouleBudget(sources, sizes(1.3, 0.21, 0.64, 0.12, 1.32), means, Number(2.2, "J", n=10), levels)


def make_content(seed=5):
    """A campaign of 24 conditions as chapter 5 of the thesis describes it."""
    maker = Maker(seed)
    conditions = tuple(_condition(maker, foot, k, ad) for foot, k in CE_J for ad in AD_GAINS)
    comparisons, anovas = _comparisons(maker, conditions)
    runs = _runs(conditions)
    days, packs = _days(runs), _packs(maker, conditions, runs)
    predictions = _predictions(maker, conditions, comparisons)
    hypotheses = _hypotheses(maker, comparisons)
    content = parts.StudyResults(
        title="Active damping on a granular bed", study="granular bed", selection="k_gain in (300, 400)",
        made_at="2021-07-30 14:05", software_version="0.1.0", configuration_hash="9c41f2e07ab3",
        detector="robust", people=("Ada Nwosu (AN)", "Li Wei (LW)"), days=days,
        flow=Flow(280, 272, 4, 12, {}, {Outcome.JOULES: 253, Outcome.APEX: 255},
                  {Outcome.JOULES: {"no charge record": 2, "pack swapped during the run": 1},
                   Outcome.APEX: {"no log with a body_height channel": 1}}, 6375, 6361,
                  {"first jumps of a run": 506, "touches a dropped packet": 83, "rejected on review": 21}, 5751),
        factors=FACTORS, conditions=conditions, claims=(), comparisons=comparisons, anovas=anovas,
        drains=(_drain(maker),),
        budget=_budget(),
        contrasts=_contrasts(maker), runs=runs, packs=packs,
        confounded=("The large foot was measured on other days than the small foot: foot and day are confounded.",),
        variations=_variations(comparisons, days),
        methods=("Energy is the charge that went back into the pack, less the passive drain, times 15.4 V.",
                 "The unit of analysis is the run; jumps of one run are not independent."),
        limitations=("The bed was stirred by hand.", "The rail angle was read by eye."),
        assumed=(parts.Assumed("uncertainty of the reference voltage", "0.1 V", "no source"),),
        provenance=tuple(maker.provenance), predictions=predictions, hypotheses=hypotheses,
    )  # fmt: skip
    claims = tuple(group_claim(content, c) for c in comparisons if c.opens)
    return dataclasses.replace(content, claims=claims)


def make_minimal():
    """One condition, no control, no drain, nothing compared."""
    maker = Maker(1)
    condition = _condition(maker, "small", 400, 50)
    return parts.StudyResults(
        title="One condition", study="granular bed", selection="", made_at="2021-07-30 14:05",
        software_version="0.1.0", configuration_hash="9c41f2e07ab3", detector="published", people=(), days=(),
        flow=Flow(None, 10, 0, 0, {}, dict.fromkeys(Outcome, 10), {key: {} for key in Outcome}, 250, 250, {}, 250),
        factors=FACTORS, conditions=(condition,), runs=_runs((condition,)),
        claims=(parts.Claim("Nothing is claimed from one condition."),),
    )  # fmt: skip


def make_log():
    """Two minutes of a bed log: rest, lift, drop, stance, apex, catch; two gaps and a rejected jump."""
    time = np.arange(0, 120, 1 / 300)
    height = np.full(time.size, 0.50)
    jumps = []
    for number in range(1, 9):
        start = 14.0 * number - 8.0
        inside = (time > start) & (time < start + 1.2)
        phase = time[inside] - start
        height[inside] = 0.42 + 0.02 * np.cos(2 * np.pi * phase / 1.2)
        flight = (phase > 0.5) & (phase < 0.8)
        shape = 0.44 - 4.9 * (phase - 0.65) ** 2
        height[np.flatnonzero(inside)[flight]] = shape[flight]
        jumps.append(LogJump(number, start + 0.65, 0.44, start + 0.25, start + 0.5,
                             excluded="touched by hand" if number == 5 else ""))  # fmt: skip
    keep = ~((time > 40.2) & (time < 41.0)) & ~((time > 77.0) & (time < 79.5))
    gaps = (LogGap(40.2, 41.0, "dropped"), LogGap(77.0, 79.5, "pause"))
    return RunLog("r0042", "small foot, CE", time[keep], height[keep], tuple(jumps), gaps)


@pytest.fixture(scope="session")
def content():
    return make_content()


@pytest.fixture(scope="session")
def plated(content):
    """The content with contact times and jump heights of a plate, predicted a tenth too large."""
    about, plate = content.predictions, (PredictedQuantity.CONTACT_TIME, PredictedQuantity.IMPULSE_HEIGHT)
    more = [
        dataclasses.replace(
            item,
            quantity=quantity,
            measured=Number(0.2, unit, se=0.001, ci_low=0.198, ci_high=0.202, n=item.n),
            check=dataclasses.replace(item.check, predicted=Number(0.22, unit, se=0.0001)),
        )
        for quantity, unit in zip(plate, ("s", "m"), strict=True)
        for item in about.of(PredictedQuantity.JOULES)
    ]
    return dataclasses.replace(content, predictions=dataclasses.replace(about, items=(*about.items, *more)))


@pytest.fixture(scope="session")
def minimal():
    return make_minimal()


@pytest.fixture(scope="session")
def run_log():
    return make_log()


@pytest.fixture(scope="session")
def written(content):
    """The page of the campaign's report, written once for all tests that look at it."""
    return made_once("report", lambda folder: write_report(report_files(content, every_figure=True), folder / "out"))
