"""Signs of force plates: a foot that stands gives a positive vertical reaction, friction forward the same `force_x`,
whatever the maker's axes are, and whether its file tells the force on the plate or the reaction.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from ingest.model import Declarations, ReadFile
from ingest.read import read_file
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
    "amti_bsf": lambda load_n: made.bsf(made.plate(made.hops(N, 100.0, load_n)), 100),
    "bertec_text": lambda load_n: made.bertec(load_n=load_n),
    "c3d": c3d,
}


def read(data: bytes) -> ReadFile:
    result = read_file(data, Declarations())
    assert not result.refused, result.findings
    return result


def values(data: bytes) -> dict[str, np.ndarray]:
    return {channel.name: channel.values for channel in read(data).parts[0].channels}


@pytest.mark.parametrize("load_n", [60.0, -60.0], ids=["as the maker tells it", "with the opposite sign"])
@pytest.mark.parametrize("name", WRITERS)
def test_standing_is_positive_and_friction_forward_has_one_sign(name: str, load_n: float) -> None:
    stored = values(WRITERS[name](load_n))
    loaded = stored["force_z"] > 40
    expected = made.plate(stored["force_z"])
    assert np.count_nonzero(loaded) > 100
    assert stored["force_z"].min() > -1
    for channel in expected.keys() & stored.keys():
        if channel.startswith("cop_") and channel != "cop_z":
            continue  # where the force acts has no sign to turn round
        assert stored[channel][loaded] == pytest.approx(expected[channel][loaded], abs=0.02), channel
    for cop in {"cop_x", "cop_y"} & stored.keys():
        assert stored[cop][loaded] == pytest.approx(expected[cop][loaded], abs=1e-3)


@pytest.mark.parametrize("load_n", [60.0, -60.0])
def test_a_trial_of_amti_is_one_in_text_and_binary(load_n: float) -> None:
    text, binary = values(made.amti(n=N, plates=1, load_n=load_n)), values(WRITERS["amti_bsf"](load_n))
    assert text.keys() == binary.keys()
    for channel, column in text.items():
        assert column == pytest.approx(binary[channel], abs=1e-5), channel
