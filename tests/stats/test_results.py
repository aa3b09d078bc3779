"""Results as plain data: reasons beside what is undefined, parts within parts, the same columns in every row."""

import json
import math
from dataclasses import dataclass

import numpy as np

from data_schema.reasons import Reason
from data_schema.vocabulary import RunKind, Undefined
from stats.results import Result, frame_of


@dataclass(frozen=True, slots=True)
class Inner:
    se: float | Undefined


@dataclass(frozen=True, slots=True)
class Outer(Result):
    name: str
    kind: RunKind
    slope: float | Undefined
    slope_ci: tuple[float, float] | Undefined
    df: float
    inner: Inner
    parts: tuple[float | Undefined, ...]
    by_name: dict[str, float]
    points: np.ndarray

    @property
    def doubled(self) -> float | Undefined:
        return undefined("not asked") if isinstance(self.slope, Undefined) else 2.0 * self.slope


def undefined(said):
    return Undefined(Reason.AS_SAID, said=said)


PARTS, POINTS = (1.0, undefined("gone")), np.arange(2)
FULL = Outer("x", RunKind.IDLE, 1.5, (1.0, 2.0), 7.0, Inner(0.1), PARTS, {"a": 1.0}, POINTS)
BARE = Outer(
    "y", RunKind.IDLE, undefined("flat"), undefined("flat too"), math.inf, Inner(undefined("one")), (), {}, POINTS
)


def test_plain_data_carry_the_reasons():
    data = json.loads(BARE.to_json())
    assert (data["slope"], data["slope_reason"]) == (None, "flat")
    assert (data["slope_ci"], data["slope_ci_reason"]) == (None, "flat too")
    assert (data["df"], data["df_reason"]) == (None, "infinite")
    assert data["inner"] == {"se": None, "se_reason": "one"}
    assert data["doubled_reason"] == "not asked"
    full = FULL.to_dict()
    assert (full["doubled"], full["kind"], full["points"]) == (3.0, "idle", [0, 1])
    assert full["parts"] == [1.0, {"value": None, "reason": "gone"}]
    assert "slope_reason" not in full
    assert json.loads(FULL.to_json()) == full


def test_frames_have_one_row_a_result_and_the_same_columns():
    frame = frame_of([FULL, BARE])
    assert len(frame) == 2
    assert list(FULL.to_frame().columns) == list(BARE.to_frame().columns)
    np.testing.assert_array_equal(frame["slope"], [1.5, math.nan])
    assert frame["slope"].dtype == np.float64
    assert frame["slope_ci_high"][0] == 2.0
    assert (frame["slope_ci_reason"][1], frame["inner_se_reason"][1]) == ("flat too", "one")
