"""Signs of force plates: a foot that stands gives a positive vertical reaction, friction forward the same `force_x`,
whatever the maker's axes are, and whether its file tells the force on the plate or the reaction.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations, ReadFile, RobotFacts
from ingest.read import read_file
from stats.force_plate import find_contacts
from tests.ingest import reading
from tests.ingest import synthetic_plates as made
from tests.ingest.synthetic_c3d import c3d_bytes, platform

N = 1200


def c3d(load_n: float) -> bytes:
    """A platform of type 2 whose z is down, x is the room's y and y the room's x; it tells the reaction."""
    stored = made.plate(made.hops(N, 200.0, load_n))
    fx, fy, fz, mx, my, mz = (stored[f"{quantity}_{axis}"] for quantity in ("force", "moment") for axis in "xyz")
    nothing = np.zeros(N)
    own = [fy, fx, -fz, 1000 * my, 1000 * mx, -1000 * mz, nothing, nothing]
    parameters = {**platform(2), "FORCE_PLATFORM:ORIGIN": np.array([[0.0], [0.0], [0.0]])}
    return c3d_bytes(np.column_stack(own), parameters)


WRITERS: dict[str, Callable[[float], bytes]] = {
    "opensim": lambda load_n: made.opensim(load_n=load_n),
    "cortex y up": lambda load_n: made.cortex(load_n=load_n),
    "cortex z up": lambda load_n: made.cortex(up="z", load_n=load_n),
    "bioware": lambda load_n: made.bioware(load_n=load_n),
    "vicon_csv": lambda load_n: made.vicon(load_n=load_n),
    "qualisys z down": lambda load_n: made.qualisys(load_n=load_n),
    "qualisys z up": lambda load_n: made.qualisys(up="z up", load_n=load_n),
    "amti_text": lambda load_n: made.amti(load_n=load_n),
    "amti_bsf": lambda load_n: made.bsf_hops(N, load_n),
    "bertec_text": lambda load_n: made.bertec(load_n=load_n),
    "c3d": c3d,
}


def read(data: bytes, declared: Declarations | None = None) -> ReadFile:
    result = read_file(data, declared or Declarations())
    assert not result.refused, result.findings
    return result


def values(data: bytes, declared: Declarations | None = None) -> dict[str, np.ndarray]:
    return reading.values(read(data, declared))


def rules(data: bytes, declared: Declarations | None = None) -> set[str]:
    return reading.rules(read(data, declared))


@pytest.mark.parametrize("load_n", [60.0, -60.0], ids=["as the maker tells it", "with the opposite sign"])
@pytest.mark.parametrize("name", WRITERS)
def test_standing_is_positive_and_friction_forward_has_one_sign(name: str, load_n: float) -> None:
    stored = values(WRITERS[name](load_n))
    loaded = stored["force_z"] > 40
    expected = made.plate(stored["force_z"])
    assert np.count_nonzero(loaded) > 60
    assert stored["force_z"].min() > -1
    for channel in expected.keys() & stored.keys():
        if channel.startswith("cop_") and channel != "cop_z":
            continue  # where the force acts has no sign to turn round
        assert stored[channel][loaded] == pytest.approx(expected[channel][loaded], abs=0.02), channel
    for cop in {"cop_x", "cop_y"} & stored.keys():
        assert stored[cop][loaded] == pytest.approx(expected[cop][loaded], abs=1e-3)


HOPS_N = made.hops(N, 200.0)


def noise(sd_n: float, mean_n: float = 0.0, n: int = N) -> np.ndarray:
    return np.random.default_rng(5).normal(mean_n, sd_n, n)


def plain(**forces: np.ndarray) -> bytes:
    """A table of any maker: times in s, then these columns in newtons."""
    header = ",".join(["time (s)", *(f"{name} (N)" for name in forces)])
    return "\n".join([header, *made.table([np.arange(N) / 200, *forces.values()], "%.4f", ","), ""]).encode()


@pytest.mark.parametrize("offset_n", [-150.0, -45.0, -30.0, 0.0, 150.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_load_counts_from_the_level_of_the_unloaded_plate(offset_n: float, sign: int) -> None:
    """45 N less than zero turned the sign of 60 N."""
    written = sign * HOPS_N + offset_n + noise(0.5)
    data = plain(Fz=written)
    stored = values(data)["force_z"]
    assert stored == pytest.approx(sign * written, abs=1e-3)
    assert stored.max() - np.median(stored[HOPS_N == 0]) == pytest.approx(60.0, abs=2.0)
    assert ("force_sign_flipped" in rules(data)) is (sign == -1)


@pytest.mark.parametrize("offset_n", [-150.0, -45.0, 45.0, 150.0])
def test_a_zero_that_is_off_turns_no_sign_of_a_maker(offset_n: float) -> None:
    rows = [line.split(",") for line in made.bertec().decode().splitlines()]
    moved = [[*row[:6], f"{float(row[6]) + offset_n:.4f}", *row[7:]] for row in rows[1:]]
    data = "\r\n".join(",".join(row) for row in [rows[0], *moved, []]).encode()
    stored, right = values(data), values(made.bertec())
    assert stored.pop("force_z") == pytest.approx(right.pop("force_z") + offset_n, abs=1e-3)
    for channel, column in right.items():
        assert stored[channel] == pytest.approx(column), channel
    assert not rules(data) & {"force_sign_flipped", "cop_disagrees"}


@pytest.mark.parametrize("sd_n", [0.3, 9.0])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("idle_first", [False, True])
def test_an_idle_plate_has_the_sign_of_the_plate_beside_it(sd_n: float, sign: int, idle_first: bool) -> None:
    """It was turned where its noise was more often below zero than above."""
    hopped, idle = sign * HOPS_N + noise(0.3), noise(sd_n, -0.45)
    stored = values(plain(Fz1=idle, Fz2=hopped) if idle_first else plain(Fz1=hopped, Fz2=idle))
    both = [stored["force_z"], stored["force_z_2"]]
    loaded, unloaded = reversed(both) if idle_first else both
    assert loaded == pytest.approx(sign * hopped, abs=1e-3)
    assert unloaded == pytest.approx(sign * idle, abs=1e-3)


@pytest.mark.parametrize(
    "written",
    [953 + 3 * np.sin(np.arange(N) / 20) + noise(0.1), -953 + noise(5.0), noise(9.0, -0.45)],
    ids=["quietly loaded", "quietly loaded, downwards", "idle"],
)
def test_where_no_load_tells_the_sign_it_stands_as_written_and_a_note_says_so(written: np.ndarray) -> None:
    """Of 953 N that sway by 3 N it was said that hops carry a mean of 2.94 N, and the file was refused."""
    data = plain(Fz=written)
    person = Declarations(robots=(RobotFacts(953 / 9.80665, 0.9),))
    assert values(data, person)["force_z"] == pytest.approx(written, abs=1e-3)
    assert rules(data, person) == {"force_sign_assumed"}


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    "load_n",
    [
        np.where(np.arange(N) > 600, 50.0, 0.0),
        300 + 300 * np.cos(np.pi * np.clip((np.arange(N) - 1000) / 200, 0, 1)),
        600 - 300 * np.sin(np.pi * np.clip((np.arange(N) - 500) / 100, -1, 1)),
    ],
    ids=["a weight put on", "a step off the plate", "a push without a flight"],
)
def test_a_force_that_changes_without_showing_its_load_is_asked_about(load_n: np.ndarray, sign: int) -> None:
    written = sign * load_n + noise(0.5)
    assert reading.rules(read_file(plain(Fz=written), Declarations())) == {"force_sign_unclear"}
    declared = Declarations(axes="z up" if sign == 1 else "z down")
    stored = values(plain(Fz=written), declared)["force_z"]
    assert stored == pytest.approx(sign * written, abs=1e-3)


def test_standing_before_and_after_hops_does_not_hide_which_way_the_load_goes() -> None:
    """A robot stands, hops with contacts of 0.16 s, and stands; written z down it was stored so."""
    contact_n, t = 100.0, np.arange(0, 8, 1 / 1000)
    phase = t % 0.4 / 0.16
    load_n = np.where((t < 2) | (t >= 6), 25.5, np.where(phase < 1, contact_n * np.sin(np.pi * phase), 0.0))
    written = -load_n + noise(0.1, n=t.size)
    data = "\n".join(["time (s),Fz (N)", *made.table([t, written], "%.4f", ","), ""]).encode()
    stored = values(data)["force_z"]
    assert stored == pytest.approx(-written, abs=1e-3)
    contacts = find_contacts(t, stored)
    assert isinstance(contacts, tuple)
    assert np.median([one.end_s - one.start_s for one in contacts]) == pytest.approx(0.16, abs=0.005)


def test_nothing_is_said_against_moments_of_a_plate_without_a_load() -> None:
    """An idle second plate 45 N below zero was called loaded, and its moment of 100 N*m one in N*mm."""
    idle, zero = noise(0.5, -45.0), np.zeros(N)
    data = plain(Fz1=HOPS_N + noise(0.5), Fz2=idle).decode().splitlines()
    rows = [f"{row},100.0,{cop}" for row, cop in zip(data[1:], zero + 9.0, strict=True)]
    found = rules("\n".join([f"{data[0]},My2 (N*m),COPx2 (m)", *rows, ""]).encode())
    assert not found & {"moment_unit_implausible", "cop_outside_plate", "cop_disagrees"}


DECLARED = [
    Declarations(instrument="reaction_z_up"),
    Declarations(axes="z up"),
    Declarations(columns={"Fz": ColumnDeclaration(sign=1)}),
    Declarations(profile_columns={"Fz": ColumnDeclaration("force_z", "N", 1)}),
]


@pytest.mark.parametrize("declared", DECLARED, ids=["instrument", "axes", "sign", "sign of a profile"])
@pytest.mark.parametrize("offset_n", [0.0, -45.0])
def test_what_is_declared_stands_against_the_load(declared: Declarations, offset_n: float) -> None:
    downward = -HOPS_N + offset_n
    data = plain(Fx=HOPS_N / 10, Fz=downward)
    stored = values(data, declared)
    assert stored["force_z"] == pytest.approx(downward, abs=1e-3)
    assert stored["force_x"] == pytest.approx(HOPS_N / 10, abs=1e-3)
    assert "force_sign_contradicts" in rules(data, declared)
    assert "force_sign_contradicts" not in rules(plain(Fz=HOPS_N + offset_n), declared)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("load_n", [60.0, -60.0])
def test_a_sign_declared_of_the_vertical_force_is_that_of_its_instrument(sign: int, load_n: float) -> None:
    data = made.bertec(load_n=load_n)
    right = values(made.bertec())
    stored = values(data, Declarations(columns={"Fz": ColumnDeclaration(sign=sign)}))
    for channel, column in right.items():
        turned = 1 if channel.startswith(("cop", "sequence", "sync", "aux")) else sign * np.sign(load_n)
        assert stored[channel] == pytest.approx(turned * column, abs=0.6), channel  # their ripple is not turned


def test_a_declared_frame_keeps_what_the_maker_says_of_it() -> None:
    right = values(made.bertec())
    for declared in (Declarations(axes="z down"), Declarations(instrument="bertec_acquire")):
        for channel, column in values(made.bertec(), declared).items():
            assert column == pytest.approx(right[channel]), channel
    as_written = values(made.bertec(), Declarations(axes="z up"))
    assert as_written["force_x"] == pytest.approx(-right["force_x"])


def test_plates_that_contradict_each_other_have_the_sign_of_the_larger_load() -> None:
    data = plain(Fz1=HOPS_N / 2, Fz2=-HOPS_N)
    stored = values(data)
    assert stored["force_z_2"] == pytest.approx(HOPS_N, abs=1e-3)
    assert stored["force_z"] == pytest.approx(-HOPS_N / 2, abs=1e-3)
    assert rules(data) == {"force_sign_flipped", "force_sign_contradicts"}
