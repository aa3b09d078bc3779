"""The passive drain of each robot's electronics, from all its idle runs in the study (thesis 5.1.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import ChargeMode, Undefined
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.facts import charge_input, idle_runs_input, run_input
from labbook.analysis.results.result_cache import Request, ResultCache, ends_of
from labbook.analysis.study_data import StudyData
from reports.numbers import Number
from stats.lines.passive_drain import PassiveDrain, fit_passive_drain, why_no_line

MAH_MIN = 60.0
"""mAh/s to mAh/min."""


@dataclass(frozen=True, slots=True)
class DrainFit(StoredResult):
    """What is stored of a robot's drain line: it, its fit, and what it gives at the protocol's run duration.

    `run_duration_s` and `extrapolated` (that duration lies outside those of the idle runs) are None without a line or
    where the protocol states no duration.
    """

    slope: Number
    intercept: Number
    r_squared: Number
    at_run: Number
    run_duration_s: float | None = None
    extrapolated: bool | None = None


ALGORITHM = Algorithm("passive_drain", 15, DrainFit)


@dataclass(frozen=True, slots=True)
class Drain:
    """One robot's drain line, and where it is stored."""

    robot: str
    line: PassiveDrain | Undefined
    result: DrainFit


def recharge_of(run: RunRow, charges: Sequence[ChargeOfRun]) -> ChargeOfRun | str:
    """Return the one charge that says what a run of known duration took, or why there is none."""
    charged = [item for item in charges if item.mode == ChargeMode.CHARGE]
    if not charged:
        return "no charge recorded"
    if len(charged) > 1:
        return f"{len(charged)} charges recorded"
    return "no duration recorded" if run.duration_s is None else charged[0]


def idle_charges(evidence: StudyData) -> list[tuple[RunRow, ChargeOfRun]]:
    """Return the idle runs that can be fitted: with a duration and exactly one charge."""
    found = [(run, recharge_of(run, evidence.charges.get(run.uid, []))) for run in evidence.idle]
    return [(run, charge) for run, charge in found if not isinstance(charge, str)]


def unused_idle(evidence: StudyData) -> list[tuple[RunRow, str]]:
    """Return the idle runs that cannot be fitted, and why."""
    found = [(run, recharge_of(run, evidence.charges.get(run.uid, []))) for run in evidence.idle]
    return [(run, reason) for run, reason in found if isinstance(reason, str)]


def drain_lines(evidence: StudyData) -> dict[str, PassiveDrain | Undefined]:
    """Fit a line through the idle runs of each robot that has idle or jump runs, by the robot's uid."""
    idle = idle_charges(evidence)
    robots = dict.fromkeys(run.robot_uid for run in (*evidence.idle, *evidence.runs))
    return {robot: _fit([item for item in idle if item[0].robot_uid == robot]) for robot in robots}


def passive_drains(cache: ResultCache, evidence: StudyData, variant: str | None = None) -> dict[str, Drain]:
    """Store each robot's line and what it gives at the protocol's run duration; `variant` names a recomputation."""
    duration_s = evidence.configuration.protocol.run_duration_s
    names = {run.robot_uid: run.robot for run in (*evidence.idle, *evidence.runs)}
    idle = idle_charges(evidence)
    lines = drain_lines(evidence)
    rows = cache.ensure(
        [
            Request(
                ALGORITHM,
                {"robot": names[robot]} | ({"variant": variant} if variant else {}),
                (
                    idle_runs_input(robot),
                    *(
                        item
                        for run, charge in idle
                        if run.robot_uid == robot
                        for item in (run_input(run), charge_input(charge))
                    ),
                ),
                {"run_duration_s": duration_s},
                lambda line=line: _drain_fit(line, duration_s),  # type: ignore[misc]
            )
            for robot, line in lines.items()
        ]
    )
    return {robot: Drain(names[robot], line, row) for (robot, line), row in zip(lines.items(), rows, strict=True)}


def _fit(idle: list[tuple[RunRow, ChargeOfRun]]) -> PassiveDrain | Undefined:
    durations_s = [run.duration_s or 0.0 for run, _ in idle]
    none = why_no_line(durations_s)
    if none is not None:
        return Undefined(none)
    return fit_passive_drain(
        durations_s,
        [charge.charge_mah for _, charge in idle],
        resolution_mah=max((charge.resolution_mah for _, charge in idle)),
    )


def _drain_fit(drain: PassiveDrain | Undefined, duration_s: float | None) -> DrainFit:
    if isinstance(drain, Undefined):
        slope, intercept, r_squared, at_run = (Number(drain, unit) for unit in ("mAh/min", "mAh", "1", "mAh"))
        return DrainFit(slope, intercept, r_squared, at_run)
    low, high = ends_of(drain.slope_ci_mah_s(), MAH_MIN)
    from_low, from_high = ends_of(drain.intercept_ci_mah())
    slope = Number(
        drain.slope_mah_s * MAH_MIN, "mAh/min", drain.slope_se_mah_s * MAH_MIN, ci_low=low, ci_high=high, df=drain.df,
        n=drain.n,
    )  # fmt: skip
    intercept = Number(
        drain.intercept_mah, "mAh", drain.intercept_se_mah, ci_low=from_low, ci_high=from_high, df=drain.df, n=drain.n
    )
    r_squared = Number(drain.r_squared, "1", n=drain.n)
    if duration_s is None:
        none = Undefined("the protocol states no run duration")
        return DrainFit(slope, intercept, r_squared, Number(none, "mAh"))
    found = drain.at(duration_s)
    return DrainFit(
        slope=slope,
        intercept=intercept,
        r_squared=r_squared,
        at_run=Number(
            found.charge_mah,
            "mAh",
            found.se,
            ci_low=found.ci_low,
            ci_high=found.ci_high,
            ci_level=found.level,
            df=found.df,
            n=drain.n,
        ),
        run_duration_s=duration_s,
        extrapolated=found.extrapolated,
    )
