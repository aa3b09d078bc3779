"""`[simulation]` of labbook.toml: what it says is read, what it cannot say is refused with the nearest name."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.errors import InputRefused
from labbook.config.model import SimulationSettings
from labbook.config.parsing import parse_configuration
from labbook.demo.files import book_toml
from labbook.demo.truth import CHAPTER_5
from tests.helpers.wording import refuses

BARE = book_toml(CHAPTER_5, predicted=False, decided=False).decode()
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


def test_everything_is_read() -> None:
    assert read(WHOLE) == SimulationSettings(
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


def test_a_scene_alone_is_enough() -> None:
    alone = read('[simulation]\nscene = "bed"\n')
    assert alone is not None
    assert (alone.accuracy, alone.varied_by, alone.assumed, alone.factors) == (1e-6, 0.1, (), {})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[simulation]\n", "simulation.scene: is missing"),
        ('[simulation]\nscene = "bedd"\n', "'bed'"),
        ('[simulation]\nscene = "bedd"\n', "NAME.toml"),
        ('[simulation]\nscene = "own.toml"\n', "own.toml"),
        ('[simulation]\nscene = "bed"\nvaried_by = 1.5\n', "< 1"),
        ('[simulation]\nscene = "bed"\nvaryed_by = 0.1\n', "'varied_by'"),
        ('[simulation]\nscene = "bed"\nassumed = [3]\n', "assumed: 3"),
        ('[simulation]\nscene = "bed"\nfactors = { feet = "foot_radius" }\n', "'foot'"),
        ('[simulation]\nscene = "bed"\nlevels.foot.smal = { foot_radius = 0.04 }\n', "'small'"),
        ('[simulation]\nscene = "bed"\nlevels.foot.small = { foot_radius = "wide" }\n', "'wide'"),
        ('[simulation]\nscene = "bed"\nparameters = { kg_scale = nan }\n', "nan"),
    ],
)
def test_what_cannot_be_meant_is_refused(text: str, said: str) -> None:
    with pytest.raises(InputRefused) as refusal:
        read(text)
    assert said in str(refusal.value)


OWN = '[simulation]\nscene = "scenes/own.toml"\n'
SCENE = 'title = "a \\"quoted\\" title" # \N{EURO SIGN}, \x7f\r\n[robot]\n'


def test_a_scene_of_one_s_own_is_read_beside_labbook_toml_and_kept_with_it(tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "own.toml").write_bytes(SCENE.encode())
    read_once = parse_configuration(BARE + OWN, "labbook.toml", tmp_path)
    kept = parse_configuration(read_once.text, "the book's configuration")
    for one in (read_once, kept):
        assert one.simulation is not None
        assert (one.simulation.scene, one.simulation.scene_toml) == ("scenes/own.toml", SCENE)
    assert (kept.text, kept.sha256) == (read_once.text, read_once.sha256)
    assert kept.text.startswith(BARE + OWN)
    (tmp_path / "scenes" / "own.toml").write_bytes(SCENE.encode() + b"#")
    assert parse_configuration(BARE + OWN, "labbook.toml", tmp_path).sha256 != read_once.sha256


@pytest.mark.parametrize(("made", "said"), [(None, "No such file"), (b"\xff\xfe", "own.toml is not text in UTF-8")])
def test_a_scene_that_cannot_be_read_is_refused(made: bytes | None, said: str, tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    if made is not None:
        (tmp_path / "scenes" / "own.toml").write_bytes(made)
    with pytest.raises(InputRefused, match=said):
        parse_configuration(BARE + OWN, "labbook.toml", tmp_path)


def test_what_the_book_keeps_of_a_scene_is_not_read_from_labbook_toml(tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "own.toml").write_bytes(SCENE.encode())
    kept = parse_configuration(BARE + OWN, "labbook.toml", tmp_path).text
    with refuses(InputRefused, "'scene_files'"):
        parse_configuration(kept, "labbook.toml", tmp_path)
