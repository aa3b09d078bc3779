"""The passive drain of each robot's electronics, from all its idle runs in the study (thesis 5.1.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.results import ResultRow
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import ChargeMode, Undefined
from labbook.analysis.results.facts import charge_input, idle_runs_input, run_input
from labbook.analysis.results.result_cache import Algorithm, Computed, NewNumber, Request, ResultCache
from labbook.analysis.study_data import StudyData
from stats.exact.finite import Interval
from stats.lines.passive_drain import PassiveDrain, fit_passive_drain, why_no_line

ALGORITHM = Algorithm("passive_drain", 15)
MAH_MIN = 60.0
"""mAh/s to mAh/min."""


@dataclass(frozen=True, slots=True)
class Drain:
    """One robot's drain line, and where it is stored."""

    robot: str
    line: PassiveDrain | Undefined
    result: ResultRow


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
                lambda line=line: _outcome(line, duration_s),  # type: ignore[misc]
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


def _outcome(drain: PassiveDrain | Undefined, duration_s: float | None) -> Computed:
    if isinstance(drain, Undefined):
        return Computed(
            tuple(
                NewNumber(name, drain, unit)
                for name, unit in (("slope", "mAh/min"), ("intercept", "mAh"), ("r_squared", "1"), ("at_run", "mAh"))
            )
        )
    low, high = _ends(drain.slope_ci_mah_s(), MAH_MIN)
    from_low, from_high = _ends(drain.intercept_ci_mah())
    line = (
        NewNumber(
            "slope", drain.slope_mah_s * MAH_MIN, "mAh/min", drain.slope_se_mah_s * MAH_MIN, ci_low=low, ci_high=high,
            ci_level=0.95, df=drain.df, n=drain.n,
        ),
        NewNumber(
            "intercept", drain.intercept_mah, "mAh", drain.intercept_se_mah, ci_low=from_low, ci_high=from_high,
            ci_level=0.95, df=drain.df, n=drain.n,
        ),
        NewNumber("r_squared", drain.r_squared, "1", n=drain.n),
    )  # fmt: skip
    if duration_s is None:
        none = Undefined("the protocol states no run duration")
        return Computed((*line, NewNumber("at_run", none, "mAh")))
    at_run = drain.at(duration_s)
    estimate = NewNumber(
        "at_run",
        at_run.charge_mah,
        "mAh",
        at_run.se,
        ci_low=at_run.ci_low,
        ci_high=at_run.ci_high,
        ci_level=at_run.level,
        df=at_run.df,
        n=drain.n,
    )
    return Computed((*line, estimate), {"run_duration_s": duration_s, "extrapolated": at_run.extrapolated})


def _ends(ci: Interval | Undefined, times: float = 1.0) -> tuple[float | Undefined, float | Undefined]:
    return (ci, ci) if isinstance(ci, Undefined) else (ci[0] * times, ci[1] * times)
