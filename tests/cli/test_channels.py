"""What a column may be declared as: a channel or the nearest one is named, and a quantity of one's own is marked."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.vocabulary import CHANNELS
from ingest.formats.chargers import sheet
from tests.cli.shell import good, labbook, refused, rows, unchanged
from tests.helpers.books import SmallBook

TIMED = '\n[profiles.logger]\nrecognise = ["z"]\ntime = { column = "t", unit = "UNIT" }\n'
PROFILE = '\n[profiles.logger]\nrecognise = ["z"]\ncolumns = { z = { channel = "%s", unit = "%s" } }\n'


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "foreign.csv"
    path.write_text("t [ms],z,left\n" + "".join(f"{3 * i},{420 + i % 7},{i}\n" for i in range(300)))
    return path


def test_all_channels_are_listed_with_unit_and_meaning(tmp_path: Path) -> None:
    answer = good(labbook("channels", "--json", at=tmp_path)).json
    listed = {row["name"]: row for row in answer if row["of"] == "log"}
    assert {name: (row["unit"], row["meaning"]) for name, row in listed.items() if name in CHANNELS} == {
        name: (kind.unit, kind.meaning) for name, kind in CHANNELS.items()
    }
    shown = good(labbook("channels", at=tmp_path)).out
    assert all(name in shown for name in [*CHANNELS, "own.NAME"])
    assert {row["name"] for row in answer if row["of"] == "charger sheet"} == set(sheet.ROLES)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (("--column", "z=body_hieght:mm"), ["'body_hieght'", "'body_height'", "`labbook channels`"]),
        (("--column", "z=CHANNEL:UNIT"), ["'CHANNEL'", "`labbook channels`", "own.NAME"]),
        (("--column", "z=body_height:kg"), ["'kg'", "'m'"]),
        (("--column", "z=own.pot:UNIT"), ["'UNIT'"]),
        (("--column", "z=own.body_height:mm"), ["own.body_height", "write body_height"]),
        (("--unit", "z=UNIT"), ["'UNIT'"]),
    ],
)
def test_a_flag_with_a_name_that_is_none_is_refused_with_the_nearest(
    fresh: SmallBook, log: Path, said: tuple[str, str], words: list[str]
) -> None:
    """It was imported, with a channel `body_hieght` that nothing uses."""
    with unchanged(fresh.folder):
        refused(labbook("ingest", log, *said, at=fresh.folder), 2, *words)


@pytest.mark.parametrize(
    ("profile", "place"),
    [
        (PROFILE % ("body_hieght", "mm"), "columns.z"),
        (PROFILE % ("body_height", "UNIT"), "columns.z"),
        (TIMED, "time.unit: 'UNIT'"),
    ],
)
def test_a_profile_with_a_name_that_is_none_is_refused_with_its_place(
    fresh: SmallBook, log: Path, profile: str, place: str
) -> None:
    with fresh.toml.open("a") as toml:
        toml.write(profile)
    with unchanged(fresh.folder):
        refused(labbook("ingest", log, at=fresh.folder), 2, "labbook.toml", f"profiles.logger.{place}")


def test_a_quantity_of_ones_own_is_marked_by_flag_and_profile(fresh: SmallBook, log: Path) -> None:
    with fresh.toml.open("a") as toml:
        toml.write(PROFILE % ("own.pot", "mm"))
    good(labbook("ingest", log, "--column", "left=own.encoder:1", at=fresh.folder))
    assert rows(fresh.folder, "SELECT name, unit FROM channel ORDER BY position") == [("pot", "mm"), ("encoder", "1")]
