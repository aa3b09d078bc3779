"""C3D files: encodings agree with each other and with ezc3d; what is cut or contradicts itself is refused."""

from __future__ import annotations

import struct
from pathlib import Path

import ezc3d
import numpy as np
import pytest

from ingest.model import ReadFile, SignalPart
from tests.ingest.reading import read, rules
from tests.ingest.synthetic_c3d import c3d_bytes, platform

SAMPLES = Path(__file__).parents[4] / "shared" / "samples" / "c3d"
AXES = ("x", "y", "z")

needs_samples = pytest.mark.skipif(
    not SAMPLES.is_dir(), reason="the sample files lie beside the project: ../shared/samples"
)


def vector(part: SignalPart, quantity: str, plate: int) -> np.ndarray:
    channels = {channel.name: channel.values for channel in part.channels}
    suffix = "" if plate == 1 else f"_{plate}"
    return np.array([channels[f"{quantity}_{axis}{suffix}"] for axis in AXES])


def check_against_ezc3d(result: ReadFile, path: Path) -> None:
    part, markers = result.parts
    found = ezc3d.c3d(str(path), extract_forceplat_data=True)["data"]
    places = np.array([channel.values for channel in markers.channels])
    points = found["points"][:3].transpose(1, 0, 2).reshape(places.shape)
    assert np.allclose(places, points / 1000, rtol=0, atol=1e-6, equal_nan=True)
    plates = found["platform"]
    for number, plate in enumerate(plates, start=1):
        assert np.abs(vector(part, "force", number) - plate["force"]).max() < 1e-3
        assert np.abs(vector(part, "moment", number) - plate["moment"] / 1000).max() < 1e-3


@needs_samples
@pytest.mark.parametrize("name", ["pc_int", "dec_real", "Gait", "Qualisys"])
def test_platforms_agree_with_ezc3d(name: str) -> None:
    path = SAMPLES / f"{name}.c3d"
    result = read(path.read_bytes())
    assert (result.refused, result.role) == (False, "force")
    check_against_ezc3d(result, path)


@needs_samples
def test_three_encodings_of_one_trial_agree() -> None:
    intel, dec, sgi = (read((SAMPLES / f"{name}.c3d").read_bytes()) for name in ("pc_int", "dec_real", "sgi_int"))
    for other in (dec, sgi):
        for part, same in zip(intel.parts, other.parts, strict=True):
            assert (part.part, part.rate_hz) == (same.part, same.rate_hz)
            for channel, again in zip(part.channels, same.channels, strict=True):
                assert channel.name == again.name
                step = 3e-4 if part.part == "markers" else 1e-3  # half a marker's step is 0.14 mm
                assert np.allclose(channel.values, again.values, rtol=0, atol=step, equal_nan=True)
    assert np.abs(vector(intel.parts[0], "force", 1)[2]).max() == pytest.approx(815.51, abs=0.01)


@needs_samples
@pytest.mark.parametrize("share", [0.99, 0.8, 0.5, 0.2])
def test_a_cut_file_is_refused(share: float) -> None:
    data = (SAMPLES / "Gait.c3d").read_bytes()
    result = read(data[: int(share * len(data))])
    assert result.refused
    assert not result.parts


def forces(n: int = 40) -> np.ndarray:
    noise = np.random.default_rng(4).normal(0, 1, (n, 8))
    noise[:, 2] -= 400
    noise[:, 4:] -= 100
    return noise


@pytest.mark.parametrize("kind", [2, 3, 4])
def test_every_type_of_platform_agrees_with_ezc3d(kind: int, tmp_path: Path) -> None:
    matrix = np.eye(6) + np.random.default_rng(1).normal(0, 0.01, (6, 6))
    path = tmp_path / "plate.c3d"
    path.write_bytes(c3d_bytes(forces(), platform(kind, matrix)))
    check_against_ezc3d(read(path.read_bytes()), path)


def test_a_platform_that_gives_the_point_of_force_has_moments_that_agree() -> None:
    analog = forces()
    analog[:, 3], analog[:, 4] = 30.0, -40.0  # mm, in axes of which z points down
    force, moment = (vector(read(c3d_bytes(analog, platform(1))).parts[0], name, 1) for name in ("force", "moment"))
    assert (force[2] > 300).all()
    assert -moment[1] / force[2] == pytest.approx(-0.040)  # the platform's y lies along the room's x
    assert moment[0] / force[2] == pytest.approx(0.030)


@pytest.mark.parametrize(
    ("unit", "moment", "newtons", "newton_metres"),
    [("N", "Nmm", 400.0, 1.0), ("nt", "ntmm", 400.0, 1.0), ("kN", "Nm", 400e3, 1e3), ("Newtons", "N.m", 400.0, 1e3)],
)
def test_units_of_platforms(unit: str, moment: str, newtons: float, newton_metres: float) -> None:
    analog = np.tile([0.0, 0.0, -400.0, 0.0, 0.0, 1000.0, 0.0, 0.0], (40, 1))
    data = c3d_bytes(analog, platform(2), units=[unit] * 3 + [moment] * 3 + ["V"] * 2)
    result = read(data)
    if newtons > 1e5:
        assert result.refused
        return
    (part,) = (part for part in result.parts if part.part == "force")
    assert vector(part, "force", 1)[2] == pytest.approx(newtons)
    assert np.abs(vector(part, "moment", 1)[2]) == pytest.approx(newton_metres)


def test_a_length_that_is_stated_nowhere_is_assumed_for_levers_and_for_no_marker() -> None:
    result = read(c3d_bytes(forces(), platform(2), length="?"))
    assert "unit_assumed" in rules(result)
    _, markers = result.parts
    assert {channel.unit for channel in markers.channels} == {None}
    assert [channel.values[0] for channel in markers.channels] == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(("length", "metres"), [("mm", 1e-3), ("cm", 1e-2), ("mete", 1.0)])
def test_markers_are_in_metres(length: str, metres: float) -> None:
    _, markers = read(c3d_bytes(forces(), platform(2), length=length)).parts
    assert [channel.values[0] for channel in markers.channels] == pytest.approx([metres, 2 * metres, 3 * metres])
    assert {channel.unit for channel in markers.channels} == {"m"}


def test_units_that_are_none_of_a_force_are_assumed_and_said() -> None:
    result = read(c3d_bytes(forces(), platform(2), units=["V"] * 8))
    assert "unit_assumed" in rules(result)
    assert result.parts[0].channels[0].assumed


@pytest.mark.parametrize(("offset", "unsigned"), [(0, False), (-100, False), (100, False), (40_000, True)])
def test_integers_are_read_with_their_own_offset(offset: int, unsigned: bool) -> None:
    analog = np.rint(forces())
    whole = read(c3d_bytes(analog, platform(2), integers=True, offset=offset, unsigned=unsigned))
    assert vector(whole.parts[0], "force", 1)[2] == pytest.approx(-analog[:, 2])


def test_a_room_with_y_up_has_the_load_along_z() -> None:
    data = c3d_bytes(forces(), platform(2, up="y"))
    assert (vector(read(data).parts[0], "force", 1)[2] > 300).all()


def test_a_file_without_a_rate_asks_for_it() -> None:
    data = c3d_bytes(forces(), platform(2), rate_hz=0.0)
    assert "rate_missing" in rules(read(data))
    assert read(data, rate_hz=500.0).parts[0].rate_hz == 500.0


def test_a_platform_of_another_type_leaves_its_raw_channels() -> None:
    result = read(c3d_bytes(forces(), platform(21)))
    assert "plate_not_known" in rules(result)
    assert {part.part for part in result.parts} == {"analog", "markers"}


@pytest.mark.parametrize(
    ("at", "other"),
    [
        *((at, None) for at in (3, 5, 9, 17, 21, 523)),  # points, analog, frames, beginning, rate and step
        *((6, struct.pack("<2H", *frames)) for frames in ((9, 8), (1, 0), (0, 0))),
    ],
)
def test_frames_that_cannot_be_and_a_header_against_the_parameters_are_refused(at: int, other: bytes | None) -> None:
    data = bytearray(c3d_bytes(forces(), platform(2)))
    other = other or bytes([data[at] ^ 0x55])
    data[at : at + len(other)] = other
    assert read(bytes(data)).refused


def test_a_file_without_a_frame_is_refused() -> None:
    assert read(c3d_bytes(forces()[:0], platform(2))).refused
