"""AMTI NetForce binary files: pounds and inches to SI, sizes compared with the header; files here are synthetic."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.ingest import synthetic_plates as made
from tests.ingest.reading import channel, read, values
from tests.ingest.synthetic_plates import INCH_M, POUND_N

SAMPLE = Path(__file__).parents[4] / "shared" / "samples" / "force" / "AMTIdata.bsf"


def bsf(plates: int = 1, rate_hz: int = 500, n: int = 100, **header: int) -> bytes:
    return made.bsf(np.tile(np.arange(1.0, 1 + 6 * plates), (n, 1)), rate_hz, **header)


def test_pounds_and_inches_become_newtons_and_newton_metres() -> None:
    (part,) = read(bsf(plates=2)).parts
    stored = {name: column[0] for name, column in values(part).items()}
    assert part.rate_hz == 500.0
    assert (stored["force_z"], stored["force_z_2"]) == pytest.approx((3 * POUND_N, 9 * POUND_N))
    assert stored["moment_y"] == pytest.approx(5 * POUND_N * INCH_M)
    assert stored["force_x"] == pytest.approx(-1 * POUND_N)  # z turned up


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
    result = read(SAMPLE.read_bytes())
    force = channel(result, "force_z")
    assert (result.parts[0].rate_hz, len(force.values)) == (500.0, 1000)
    assert force.values.max() == pytest.approx(165.90197455 * POUND_N)
    assert (force.unit, force.source_unit) == ("N", "lbf")
