"""AMTI NetForce binary files: pounds and inches to SI, sizes compared with the header; files here are synthetic."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from tests.ingest.reading import read

SAMPLE = Path(__file__).parents[4] / "shared" / "samples" / "force" / "AMTIdata.bsf"
POUND_N, INCH_M = 4.4482216152605, 0.0254


def bsf(plates: int = 1, rate_hz: int = 500, version: int = 105, n: int = 100, channels: int = 6) -> bytes:
    header = bytearray(4 + 968)
    struct.pack_into("<iii", header, 0, version, 968, plates)
    struct.pack_into("<d", header, 164, n / rate_hz)
    struct.pack_into("<i", header, 212, rate_hz)
    own = bytearray(948)
    struct.pack_into("<i", own, 0, 948)
    struct.pack_into("<i", own, 32, channels)
    row = np.arange(1.0, 1 + 6 * plates)
    return bytes(header + own * plates) + np.tile(row, (n, 1)).astype("<f8").tobytes()


def test_pounds_and_inches_become_newtons_and_newton_metres() -> None:
    (part,) = read(bsf(plates=2)).parts
    values = {channel.name: channel.values[0] for channel in part.channels}
    assert part.rate_hz == 500.0
    assert values["force_z"] == pytest.approx(3 * POUND_N)
    assert values["force_z_2"] == pytest.approx(9 * POUND_N)
    assert values["moment_y"] == pytest.approx(5 * POUND_N * INCH_M)
    assert values["force_x"] == pytest.approx(-1 * POUND_N)  # z turned up


@pytest.mark.parametrize(
    ("data", "rule"),
    [
        (bsf(version=100), "bsf_version"),
        (bsf(channels=5), "bsf_damaged"),
        (bsf(plates=0), "bsf_damaged"),
        (bsf() + b"\0", "bsf_damaged"),
        (bsf()[:972], "bsf_damaged"),
        (bsf(rate_hz=-500), "bsf_damaged"),
        (bsf()[: len(bsf()) // 2], "bsf_damaged"),
    ],
)
def test_another_version_or_size_is_refused(data: bytes, rule: str) -> None:
    (finding,) = read(data).findings
    assert (finding.severity, finding.rule) == ("file", rule)


@pytest.mark.skipif(not SAMPLE.is_file(), reason="the sample files lie beside the project: ../shared/samples")
def test_the_sample_of_a_person_walking() -> None:
    (part,) = read(SAMPLE.read_bytes()).parts
    force = next(channel for channel in part.channels if channel.name == "force_z")
    assert (part.rate_hz, len(part.time_s)) == (500.0, 1000)
    assert force.values.max() == pytest.approx(165.90197455 * POUND_N)
    assert (force.unit, force.source_unit) == ("N", "lbf")
