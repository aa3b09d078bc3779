"""What is said of a chosen set of effects at the corners of a sweep."""

from __future__ import annotations

from labbook.presenting.simulation.swept import corners_data, corners_lines
from simulator.ablation.corners import Corner, Corners
from simulator.ablation.outputs import Difference
from tests.helpers.scenes import is_sentence
from tests.labbook.presenting.simulation.test_effects_ablation import FOLDED, WORTH

NEAR = Corner({"b_ad": 0.0, "gain": 300.0}, Difference(0.001, -0.002, 0.0))
FAR = Corner({"b_ad": 300.0, "gain": 600.0}, Difference(0.012, -0.002, 0.0))
FOLDS = Corner({"b_ad": 300.0, "gain": 900.0}, Difference(FOLDED, FOLDED, FOLDED))


def said(*corners: Corner, refused: int = 0) -> str:
    (line,) = corners_lines(Corners(corners, refused), WORTH)
    assert is_sentence(line) or line.startswith("warning: at no corner")
    return line


def test_within_the_tolerance() -> None:
    assert said(NEAR, NEAR) == (
        "Of 2 corners of what is swept, the set is farthest off at b_ad = 0, gain = 300: there it changes cost by "
        "+0.1 %, apex by -0.2 %, depth by 0."
    )


def test_beyond_the_tolerance_is_a_warning_with_what_to_do() -> None:
    line = said(NEAR, FAR, refused=1)
    assert line == (
        "warning: the chosen set of effects does not stay within 1 % in all of this sweep. Of 2 corners of what is "
        "swept (1 more cannot be simulated), the set is farthest off at b_ad = 300, gain = 600: there it changes "
        "cost by +1.2 %, apex by -0.2 %, depth by 0. Sweep less far, give a smaller --within, or name the effects "
        "instead of auto."
    )
    ends = "gain = 900: there the jump ends otherwise than with all effects (leg_folded). Sweep less far, give"
    assert ends in said(FAR, FOLDS)


def test_no_corner_and_no_set() -> None:
    assert said(refused=4).startswith("warning: at no corner of what is swept can all effects be simulated")
    assert corners_lines(None, WORTH) == corners_lines(Corners((), 0), None) == []
    assert corners_data(None, WORTH) == {}


def test_data() -> None:
    found = corners_data(Corners((NEAR, FAR), 1), WORTH)["corners"]
    assert found == {
        "compared": 2,
        "refused": 1,
        "worst": {"at": dict(FAR.at), "cost": 0.012, "apex": -0.002, "depth": 0.0, "undefined": None},
        "within": False,
    }
    folded = corners_data(Corners((FOLDS,), 0), WORTH)["corners"]["worst"]
    assert (folded["cost"], folded["undefined"]) == (None, "leg_folded")
    nothing = corners_data(Corners((), 4), WORTH)["corners"]
    assert (nothing["worst"], nothing["within"]) == (None, False)
