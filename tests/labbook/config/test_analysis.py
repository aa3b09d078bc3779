"""`[analysis]` and `[hypotheses.NAME]` of labbook.toml: what they say is read, what they cannot say is refused."""

from __future__ import annotations

import pytest

from data_schema.errors import InputRefused
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, ReasonCode
from labbook.config.model import (
    AnalysisSettings,
    Bounds,
    ClaimKind,
    ContrastSettings,
    Family,
    HypothesisSettings,
    Side,
)
from labbook.config.parsing import parse_configuration
from labbook.demo.files import book_toml
from labbook.demo.truth import CHAPTER_5
from tests.helpers.wording import refuses

BARE = book_toml(CHAPTER_5, predicted=False, decided=False).decode()


def read(text: str) -> AnalysisSettings | None:
    return parse_configuration(BARE + text, "labbook.toml").analysis


def test_everything_is_read() -> None:
    found = read(
        '[analysis]\nprimary_outcome = "apex"\nfamily = "each"\nalpha = 0.01\napex_bounds_m = [-0.005, 0.004]\n'
        'exclusions = ["misfire"]\n'
    )
    assert found == AnalysisSettings(
        primary_outcome=Outcome.APEX,
        family=Family.EACH,
        alpha=0.01,
        apex_bounds_m=(-0.005, 0.004),
        exclusions=(ReasonCode.MISFIRE,),
    )
    assert found.apex_bounds == Bounds(-0.005, 0.004, percent=False)


FOOT = """
[hypotheses.foot]
text = "The foot does not matter"
claim = "same"
side = "control"
between = "foot"
within_percent = 10
"""


def read_hypotheses(text: str) -> tuple[HypothesisSettings, ...]:
    return tuple(parse_configuration(BARE + text, "labbook.toml").hypotheses.values())


def test_everything_of_a_hypothesis_is_read() -> None:
    foot, level, most = read_hypotheses(
        FOOT
        + """
[hypotheses.level]
text = "It levels off"
source = "thesis 5.2.1"
published = "p > .15"
claim = "same"
outcome = "apex"
side = "treated"
between = "b_ad_gain"
levels = [150, 200, 250.0]
within_percent = 2.5

[hypotheses.most]
text = "The small foot saves most"
claim = "largest_saving"
group = { foot = "small", k_gain = 400 }
"""
    )
    assert (foot.outcome, foot.levels, foot.source, foot.published) == (Outcome.JOULES, (), "", "")
    assert level == HypothesisSettings(
        name="level",
        text="It levels off",
        source="thesis 5.2.1",
        published="p > .15",
        claim=ClaimKind.SAME,
        outcome=Outcome.APEX,
        side=Side.TREATED,
        between="b_ad_gain",
        levels=("150", "200", "250"),
        group={},
        within_percent=2.5,
    )
    assert (most.claim, most.group) == (ClaimKind.LARGEST_SAVING, {"foot": "small", "k_gain": "400"})


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        (('claim = "same"', 'claim = "equal"'), ("hypotheses.foot.claim", "same")),
        (('between = "foot"', 'between = "feet"'), ("hypotheses.foot.between", "foot")),
        (('between = "foot"', ""), ("hypotheses.foot.between", "is missing")),
        (("within_percent = 10", "within_percent = 0"), ("within_percent", "> 0")),
        (("within_percent = 10", "within_percent = 100"), ("within_percent", "< 100")),
        (('side = "control"', 'side = "controls"'), ("hypotheses.foot.side", "control")),
        (("within_percent = 10", 'within_percent = 10\nlevels = ["small", "huge"]'), ("levels", "huge")),
        (("within_percent = 10", 'within_percent = 10\nlevels = ["small"]'), ("levels", "small alone")),
        (("within_percent = 10", "within_percent = 10\ngroup = {}"), ("hypotheses.foot.group",)),
        (('claim = "same"', 'claim = "saves"'), ("hypotheses.foot.side",)),
        (('claim = "same"', 'claim = "largest_saving"'), ("hypotheses.foot.group", "is missing")),
        (('text = "The foot does not matter"', ""), ("hypotheses.foot.text", "is missing")),
    ],
)  # fmt: skip
def test_what_no_hypothesis_can_be_is_refused(change: tuple[str, str], facts: tuple[str, ...]) -> None:
    assert change[0] in FOOT
    with refuses(InputRefused, *facts):
        read_hypotheses(FOOT.replace(*change))


_SAME = 'claim = "same"\nwithin_percent = 5\nbetween = "b_ad_gain"\nside = '


@pytest.mark.parametrize(
    ("table", "keys", "facts"),
    [
        ("analysis", 'primary_outcome = "joule"', ["'joules'"]),
        ("analysis", "alpha = 0.7", ["< 0.5"]),
        ("analysis", "apex_bounds_m = [0.001, 0.005]", ["apex_bounds_m"]),
        ("analysis", "apex_bounds_m = [-0.005]", ["apex_bounds_m"]),
        ("analysis", "apex_bounds_m = [-1, 1]\napex_bounds_percent = [-3, 3]", ["apex_bounds_percent"]),
        ("analysis", 'exclusions = ["bad_day"]', ["'dropped_packet'"]),
        ("analysis", "aplha = 0.05", ["'alpha'"]),
        ("hypotheses.it", f'{_SAME} "control"', ["side", "one level"]),
        ("hypotheses.it", f'{_SAME} "treated"\nlevels = [0, 50]', ["levels", "control"]),
        ("hypotheses.it", 'claim = "largest_saving"\ngroup = { foot = "small" }', ["group", "k_gain"]),
        (
            "hypotheses.it",
            'claim = "largest_saving"\ngroup = { foot = "small", k_gain = 400, b_ad_gain = 50 }',
            ["foot, k_gain"],
        ),
        ("hypotheses.it", "", ["hypotheses.it.claim", "is missing"]),
        ("hypotheses.it", 'claim = "saves"\noutcome = "apex"', ["hypotheses.it.outcome", "joules"]),
        (
            "hypotheses.it",
            'claim = "largest_saving"\ngroup = { fot = "small", k_gain = 450 }',
            ["fot", "foot", "450", "400"],
        ),
    ],
)
def test_what_has_no_meaning_or_no_runs_could_tell_is_refused(table: str, keys: str, facts: list[str]) -> None:
    text = 'text = "It"\n' if table == "hypotheses.it" else ""
    with refuses(InputRefused, *facts):
        read(f"\n[{table}]\n{text}{keys}\n")


CONTRASTS = """
[analysis]
contrasts = [
  {{ kind = "difference", factor = "foot", side = "control", levels = ["small", "large"] }},
  {{ kind = "interaction", factor = "k_gain", outcome = "apex" }},
  {{ kind = "levels_off", at = 150 }},
  {}
]
"""


def test_contrasts_are_read() -> None:
    found = read(CONTRASTS.format('{ kind = "trend" }'))
    assert found is not None
    assert found.contrasts == (
        ContrastSettings(ContrastKind.DIFFERENCE, Outcome.JOULES, "foot", Side.CONTROL, ("small", "large")),
        ContrastSettings(ContrastKind.INTERACTION, Outcome.APEX, "k_gain"),
        ContrastSettings(ContrastKind.LEVELS_OFF, Outcome.JOULES, at=150.0),
        ContrastSettings(ContrastKind.TREND, Outcome.JOULES),
    )


@pytest.mark.parametrize(
    ("contrast", "fact"),
    [
        ('{ kind = "slope" }', "slope"),
        ('{ kind = "interaction" }', "factor"),
        ('{ kind = "interaction", factor = "feet" }', "foot"),
        ('{ kind = "interaction", factor = "b_ad_gain" }', "k_gain"),
        ('{ kind = "difference", factor = "foot" }', "side"),
        ('{ kind = "interaction", factor = "foot", levels = ["small"] }', "alone"),
        ('{ kind = "interaction", factor = "foot", levels = ["small", "lareg"] }', "large"),
        ('{ kind = "trend", levels = [50, 51] }', "51"),
        ('{ kind = "levels_off" }', "at"),
        ('{ kind = "trend", at = 50 }', "at"),
        ('{ kind = "levels_off", at = 150 }', "2 times"),
    ],
)
def test_a_contrast_that_asks_nothing_is_refused(contrast: str, fact: str) -> None:
    with refuses(InputRefused, fact):
        read(CONTRASTS.format(contrast))
