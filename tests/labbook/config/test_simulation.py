"""`[simulation]` of labbook.toml: what it says is read, what it cannot say is refused with the nearest name."""

from __future__ import annotations

import pytest

from data_schema.errors import InputRefused
from labbook.config.model import SimulationSettings
from labbook.config.parsing import parse_configuration
from labbook.config.template import template
from labbook.demo.book_toml import book_toml
from labbook.demo.truth import CHAPTER_5

BARE = book_toml(CHAPTER_5, predicted=False).decode()
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


def read(text: str) -> SimulationSettings | None:
    return parse_configuration(BARE + text, "labbook.toml").simulation


def test_a_book_without_the_table_names_no_scene() -> None:
    assert read("") is None
    assert parse_configuration(template("a study", "Ada Nwosu"), "labbook.toml").simulation is None


def test_everything_is_read() -> None:
    assert read(WHOLE) == SimulationSettings(
        scene="sim2",
        effects="+drag,-added_mass",
        accuracy=1e-8,
        varied_by=0.25,
        varied={"foot_mass": 0.5},
        parameters={"kg_scale": 1.2},
        assumed=("foot_mass",),
        factors={"k_gain": "k_extension"},
        levels={"foot": {"small": {"foot_radius": 0.04, "foot_mass": 0.18}, "large": {"foot_radius": 0.05}}},
    )


def test_a_scene_alone_is_enough_and_the_example_of_a_new_book_can_be_taken() -> None:
    alone = read('[simulation]\nscene = "bed"\n')
    assert alone is not None
    assert (alone.accuracy, alone.varied_by, alone.assumed, alone.factors) == (1e-6, 0.1, (), {})
    lines = template("a study", "Ada Nwosu").split("\n")
    example = "\n".join(lines[lines.index("#[simulation]") :][:4]).replace("#", "")
    taken = read(example)
    assert taken is not None
    assert set(taken.factors.values()) == {"foot_radius", "k_extension", "b_ad"}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[simulation]\n", "simulation.scene: is missing"),
        ('[simulation]\nscene = "bedd"\n', "did you mean 'bed'?"),
        ('[simulation]\nscene = "bed"\nvaried_by = 1.5\n', "write one below 1"),
        ('[simulation]\nscene = "bed"\nvaryed_by = 0.1\n', "'varied_by'"),
        ('[simulation]\nscene = "bed"\nassumed = [3]\n', "3 is not a name"),
        ('[simulation]\nscene = "bed"\nfactors = { feet = "foot_radius" }\n', "'foot'"),
        ('[simulation]\nscene = "bed"\nlevels.foot.smal = { foot_radius = 0.04 }\n', "'small'"),
        ('[simulation]\nscene = "bed"\nlevels.foot.small = { foot_radius = "wide" }\n', "is not a number"),
        ('[simulation]\nscene = "bed"\nparameters = { kg_scale = nan }\n', "is not a number"),
    ],
)
def test_what_cannot_be_meant_is_refused(text: str, said: str) -> None:
    with pytest.raises(InputRefused) as refusal:
        read(text)
    assert said in str(refusal.value)
