"""`[analysis]`, `[hypotheses.NAME]` and `[simulation]` of labbook.toml: read, or refused with the nearest name."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.errors import InputRefused
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, ReasonCode
from labbook.config.model import (
    AnalysisSettings,
    Bounds,
    ClaimKind,
    Configuration,
    ContrastSettings,
    Family,
    HypothesisSettings,
    Side,
    SimulationSettings,
)
from labbook.config.parsing import parse_configuration
from labbook.demo.files import book_toml
from labbook.demo.truth import CHAPTER_5
from tests.helpers.wording import refuses

BARE = book_toml(CHAPTER_5, predicted=False, decided=False).decode()


def parsed(text: str, folder: Path | None = None) -> Configuration:
    return parse_configuration(BARE + text, "labbook.toml", folder)


def test_everything_is_read() -> None:
    found = parsed(
        '[analysis]\nprimary_outcome = "apex"\nfamily = "each"\nalpha = 0.01\napex_bounds_m = [-0.005, 0.004]\n'
        'exclusions = ["misfire"]\n'
    ).analysis
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


def test_everything_of_a_hypothesis_is_read() -> None:
    foot, level, most = parsed(
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
    ).hypotheses.values()
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
    found = parsed(CONTRASTS.format('{ kind = "trend" }')).analysis
    assert found is not None
    assert found.contrasts == (
        ContrastSettings(ContrastKind.DIFFERENCE, Outcome.JOULES, "foot", Side.CONTROL, ("small", "large")),
        ContrastSettings(ContrastKind.INTERACTION, Outcome.APEX, "k_gain"),
        ContrastSettings(ContrastKind.LEVELS_OFF, Outcome.JOULES, at=150.0),
        ContrastSettings(ContrastKind.TREND, Outcome.JOULES),
    )


WHOLE = """
[simulation]
scene = "sim2"
effects = "+drag,-added_mass"
accuracy = 1e-8
varied_by = 0.25
varied = { foot_mass = 0.5 }
assumed = ["foot_mass"]
parameters = { kg_scale = 1.2 }
factors = { k_gain = "k_extension" }
levels.foot = { small = { foot_radius = 0.04, foot_mass = 0.18 }, large = { foot_radius = 0.05 } }
"""


def test_everything_of_a_simulation_is_read() -> None:
    assert parsed(WHOLE).simulation == SimulationSettings(
        scene="sim2",
        scene_toml=None,
        effects="+drag,-added_mass",
        accuracy=1e-8,
        varied_by=0.25,
        varied={"foot_mass": 0.5},
        parameters={"kg_scale": 1.2},
        assumed=("foot_mass",),
        factors={"k_gain": "k_extension"},
        levels={"foot": {"small": {"foot_radius": 0.04, "foot_mass": 0.18}, "large": {"foot_radius": 0.05}}},
    )


OWN = '[simulation]\nscene = "scenes/own.toml"\n'
SCENE = 'title = "a \\"quoted\\" title" # \N{EURO SIGN}, \x7f\r\n[robot]\n'


def test_a_scene_of_one_s_own_is_read_beside_labbook_toml_and_kept_with_it(tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    own = tmp_path / "scenes" / "own.toml"
    own.write_bytes(SCENE.encode())
    read_once = parsed(OWN, tmp_path)
    kept = parse_configuration(read_once.text, "the book's configuration")
    for one in (read_once, kept):
        assert one.simulation is not None
        assert (one.simulation.scene, one.simulation.scene_toml) == ("scenes/own.toml", SCENE)
    assert (kept.text, kept.sha256) == (read_once.text, read_once.sha256)
    assert kept.text.startswith(BARE + OWN)
    own.write_bytes(SCENE.encode() + b"#")
    assert parsed(OWN, tmp_path).sha256 != read_once.sha256
    with refuses(InputRefused, "'scene_files'"):  # what the book keeps is not read from labbook.toml
        parse_configuration(kept.text, "labbook.toml", tmp_path)


def test_a_scene_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with refuses(InputRefused, "No such file"):
        parsed(OWN, tmp_path)
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "own.toml").write_bytes(b"\xff\xfe")
    with refuses(InputRefused, "own.toml is not text in UTF-8"):
        parsed(OWN, tmp_path)


IN_FOOT = [
    (('claim = "same"', 'claim = "equal"'), ["hypotheses.foot.claim", "same"]),
    (('between = "foot"', 'between = "feet"'), ["hypotheses.foot.between", "foot"]),
    (('between = "foot"', ""), ["hypotheses.foot.between", "is missing"]),
    (("within_percent = 10", "within_percent = 0"), ["within_percent", "> 0"]),
    (("within_percent = 10", "within_percent = 100"), ["within_percent", "< 100"]),
    (('side = "control"', 'side = "controls"'), ["hypotheses.foot.side", "control"]),
    (("within_percent = 10", 'within_percent = 10\nlevels = ["small", "huge"]'), ["levels", "huge"]),
    (("within_percent = 10", 'within_percent = 10\nlevels = ["small"]'), ["levels", "small alone"]),
    (("within_percent = 10", "within_percent = 10\ngroup = {}"), ["hypotheses.foot.group"]),
    (('claim = "same"', 'claim = "saves"'), ["hypotheses.foot.side"]),
    (('claim = "same"', 'claim = "largest_saving"'), ["hypotheses.foot.group", "is missing"]),
    (('text = "The foot does not matter"', ""), ["hypotheses.foot.text", "is missing"]),
]
IN_ANALYSIS = [
    ('primary_outcome = "joule"', ["'joules'"]),
    ("alpha = 0.7", ["< 0.5"]),
    ("apex_bounds_m = [0.001, 0.005]", ["apex_bounds_m"]),
    ("apex_bounds_m = [-0.005]", ["apex_bounds_m"]),
    ("apex_bounds_m = [-1, 1]\napex_bounds_percent = [-3, 3]", ["apex_bounds_percent"]),
    ('exclusions = ["bad_day"]', ["'dropped_packet'"]),
    ("aplha = 0.05", ["'alpha'"]),
]
SAME = 'claim = "same"\nwithin_percent = 5\nbetween = "b_ad_gain"\nside = '
LARGEST = 'claim = "largest_saving"\ngroup = '
OF_IT = [
    (f'{SAME} "control"', ["side", "one level"]),
    (f'{SAME} "treated"\nlevels = [0, 50]', ["levels", "control"]),
    (f'{LARGEST}{{ foot = "small" }}', ["group", "k_gain"]),
    (f'{LARGEST}{{ foot = "small", k_gain = 400, b_ad_gain = 50 }}', ["foot, k_gain"]),
    (f'{LARGEST}{{ fot = "small", k_gain = 450 }}', ["fot", "foot", "450", "400"]),
    ("", ["hypotheses.it.claim", "is missing"]),
    ('claim = "saves"\noutcome = "apex"', ["hypotheses.it.outcome", "joules"]),
]
CONTRAST = [
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
]
IN_SIMULATION = [
    ('scene = "bedd"', ["'bed'", "NAME.toml"]),
    ('scene = "own.toml"', ["own.toml"]),
    ('scene = "bed"\nvaried_by = 1.5', ["< 1"]),
    ('scene = "bed"\nvaryed_by = 0.1', ["'varied_by'"]),
    ('scene = "bed"\nassumed = [3]', ["assumed: 3"]),
    ('scene = "bed"\nfactors = { feet = "foot_radius" }', ["'foot'"]),
    ('scene = "bed"\nlevels.foot.smal = { foot_radius = 0.04 }', ["'small'"]),
    ('scene = "bed"\nlevels.foot.small = { foot_radius = "wide" }', ["'wide'"]),
    ('scene = "bed"\nparameters = { kg_scale = nan }', ["nan"]),
    ("", ["simulation.scene: is missing"]),
]


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        *((FOOT.replace(*change), facts) for change, facts in IN_FOOT),
        *((f"[analysis]\n{keys}\n", facts) for keys, facts in IN_ANALYSIS),
        *((f'[hypotheses.it]\ntext = "It"\n{keys}\n', facts) for keys, facts in OF_IT),
        *((CONTRASTS.format(contrast), [fact]) for contrast, fact in CONTRAST),
        *((f"[simulation]\n{keys}\n", facts) for keys, facts in IN_SIMULATION),
    ],
)
def test_what_cannot_be_meant_or_told_is_refused(text: str, facts: list[str]) -> None:
    assert text != FOOT
    with refuses(InputRefused, *facts):
        parsed(text)
