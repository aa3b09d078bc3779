"""Three samples: analyses of variance, spreads, all pairs, against a control, over days."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pingouin
import scipy.stats
import statsmodels.api as sm
from statsmodels.stats.multicomp import pairwise_tukeyhsd
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.oneway import anova_oneway

from benchmarks.stats_evidence.speed.case import PINGOUIN, SCIPY, SEED, STATSMODELS, Call, Case, Inputs, Peer
from stats.days.blocked import blocked_by_day
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.dunnett import dunnett
from stats.groups.multiple import holm
from stats.groups.tukey import compare_all_pairs
from stats.groups.variances import bartlett, brown_forsythe, levene

DAYS = 5


def _on_frame(function: Callable[..., object], group: str = "between") -> Callable[[Inputs], Call]:
    def prepared(it: Inputs) -> Call:
        frame = it.frame()
        return lambda: function(data=frame, dv="y", **{group: "g"})

    return prepared


def _mixed(it: Inputs) -> Call:
    values, condition, day = _over_days(it)
    design = np.column_stack([np.ones(values.size), condition])
    return lambda: sm.MixedLM(values, design, groups=day).fit()


def _blocked(it: Inputs) -> Call:
    values, condition, day = _over_days(it)
    return lambda: blocked_by_day(values, condition, day)


def _over_days(it: Inputs) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two conditions on five days."""
    values = np.concatenate([it.a, it.b])
    day = np.tile(np.arange(it.n) % DAYS, 2)
    return values + 0.5 * day, np.repeat([0, 1], it.n), day


def _of_unequal_size(it: Inputs) -> dict[str, np.ndarray]:
    """A treatment of four times as many values as the control has, and one of a quarter."""
    rng = np.random.default_rng(SEED)
    return {"b": rng.normal(0.3, 1.0, 4 * it.n), "c": rng.normal(0.0, 1.0, it.n // 4)}


def _against_control(it: Inputs) -> Call:
    treatments = _of_unequal_size(it)
    return lambda: dunnett(it.a, treatments)


def _against_control_by_scipy(it: Inputs) -> Call:
    treatments = _of_unequal_size(it).values()
    return lambda: scipy.stats.dunnett(*treatments, control=it.a, rng=1).confidence_interval()


def _p_values(it: Inputs) -> dict[str, float]:
    return {str(number): p for number, p in enumerate(np.linspace(1e-6, 0.2, it.n).tolist())}


def _tukey(it: Inputs, equal: bool) -> Call:
    return lambda: scipy.stats.tukey_hsd(*it.groups.values(), equal_var=equal).confidence_interval()


def _tukey_of_statsmodels(it: Inputs) -> Call:
    frame = it.frame()
    return lambda: pairwise_tukeyhsd(frame["y"], frame["g"])


def _holm_of_statsmodels(it: Inputs) -> Call:
    p = list(_p_values(it).values())
    return lambda: multipletests(p, method="holm")


def _holm(it: Inputs) -> Call:
    p = _p_values(it)
    return lambda: holm(p, "the family")


CASES = (
    Case(
        "one_way_anova",
        lambda it: lambda: one_way_anova(it.groups),
        (
            Peer(SCIPY, "f_oneway", lambda it: lambda: scipy.stats.f_oneway(*it.groups.values())),
            Peer(
                STATSMODELS,
                "anova_oneway",
                lambda it: lambda: anova_oneway(list(it.groups.values()), use_var="equal"),
            ),
            Peer(PINGOUIN, "anova", _on_frame(pingouin.anova)),
        ),
    ),
    Case(
        "welch_anova",
        lambda it: lambda: welch_anova(it.groups),
        (
            Peer(SCIPY, "f_oneway", lambda it: lambda: scipy.stats.f_oneway(*it.groups.values(), equal_var=False)),
            Peer(STATSMODELS, "anova_oneway", lambda it: lambda: anova_oneway(list(it.groups.values()))),
            Peer(PINGOUIN, "welch_anova", _on_frame(pingouin.welch_anova)),
        ),
    ),
    Case(
        "bartlett",
        lambda it: lambda: bartlett(it.groups),
        (Peer(SCIPY, "bartlett", lambda it: lambda: scipy.stats.bartlett(*it.groups.values())),),
    ),
    Case(
        "levene",
        lambda it: lambda: levene(it.groups),
        (Peer(SCIPY, "levene, mean", lambda it: lambda: scipy.stats.levene(*it.groups.values(), center="mean")),),
    ),
    Case(
        "brown_forsythe",
        lambda it: lambda: brown_forsythe(it.groups),
        (
            Peer(SCIPY, "levene, median", lambda it: lambda: scipy.stats.levene(*it.groups.values())),
            Peer(PINGOUIN, "homoscedasticity", _on_frame(pingouin.homoscedasticity, "group")),
        ),
    ),
    Case(
        "compare_all_pairs (Tukey)",
        lambda it: lambda: compare_all_pairs(it.groups),
        (
            Peer(SCIPY, "tukey_hsd with intervals", lambda it: _tukey(it, True)),
            Peer(STATSMODELS, "pairwise_tukeyhsd", _tukey_of_statsmodels),
            Peer(PINGOUIN, "pairwise_tukey", _on_frame(pingouin.pairwise_tukey)),
        ),
    ),
    Case(
        "compare_all_pairs (Games-Howell)",
        lambda it: lambda: compare_all_pairs(it.groups, variances="unequal"),
        (
            Peer(SCIPY, "tukey_hsd with intervals", lambda it: _tukey(it, False)),
            Peer(PINGOUIN, "pairwise_gameshowell", _on_frame(pingouin.pairwise_gameshowell)),
        ),
    ),
    Case(
        "dunnett",
        lambda it: lambda: dunnett(it.a, {"b": it.b, "c": it.c}),
        (
            Peer(
                SCIPY,
                "dunnett with intervals",
                lambda it: lambda: scipy.stats.dunnett(it.b, it.c, control=it.a, rng=1).confidence_interval(),
            ),
        ),
    ),
    Case(
        "dunnett, n, 4 n and n / 4 values",
        _against_control,
        (Peer(SCIPY, "dunnett with intervals", _against_control_by_scipy),),
    ),
    Case("holm, n p-values", _holm, (Peer(STATSMODELS, "multipletests", _holm_of_statsmodels),), sizes=(25, 100)),
    Case(f"blocked_by_day, 2 n values on {DAYS} days", _blocked, (Peer(STATSMODELS, "MixedLM (z-tests)", _mixed),)),
)
