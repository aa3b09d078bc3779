"""What a study of accuracy says in words."""

from __future__ import annotations

import pytest

from labbook.presenting.machine import processor
from labbook.presenting.work_precision import as_data, as_lines, plain_number, work_precision_of
from simulator.accuracy.outputs import NAMES
from simulator.accuracy.reference_of import Reference
from simulator.accuracy.study import AccuracyStudy, Point, Series
from simulator.scene_file import load_scene


def made(floor: float = 1e-14) -> AccuracyStudy:
    levels: dict[str, float | None] = dict.fromkeys(NAMES, floor)
    reference = Reference("a made-up truth", True, "apex", dict.fromkeys(NAMES, 1.0), levels, levels)

    def point(setting: float, error: float, seconds: float) -> Point:
        return Point(setting, "apex", dict.fromkeys(NAMES, max(error, floor)), 100, seconds)

    gave_up = Point(1e-6, failure="gave up at 0.1 s of a jump")
    return AccuracyStudy(
        load_scene("sim2"),
        reference,
        (
            Series("Euler", "step", "s", (point(1e-3, 2e-2, 1e-5), point(1e-4, 3e-3, 2e-4))),
            Series("peer", "rtol", "", (point(1e-3, 1e-4, 1e-2), gave_up)),
            Series("absent", "rtol", "", (), "it knows no sand"),
            Series("labbook", "accuracy", "", (point(1e-2, 1e-3, 1e-4), point(1e-6, 1e-8, 2e-4))),
        ),
    )


def test_the_sentences_a_user_wants() -> None:
    lines = as_lines(made())
    assert (
        "for 1 % of the cost in joules you need step 1e-4 s with Euler; you pay 200 µs, 2 times what labbook takes."
        in lines
    )
    assert "for 1 % of the cost in joules no setting of peer that was tried will do." in lines
    assert "for 1 % of the cost in joules you need accuracy 1e-2 with labbook; you pay 100 µs." in lines
    assert (
        "for 1e-6 of the cost in joules no setting of Euler that was tried will do: step 1e-4 s is off by 3.0e-03, "
        "after 200 µs." in lines
    )
    assert "for 1e-6 of the cost in joules you need accuracy 1e-6 with labbook; you pay 200 µs." in lines


def test_under_the_floor_nobody_can_say() -> None:
    lines = as_lines(made(floor=1e-5))
    assert "for 1e-6 of the cost in joules nobody can say what is needed: 1.0e-05 is all that can be known." in lines
    assert any("hangs on the last bits" in line for line in lines)
    assert any("<1.0e-05" in line for line in lines)


def test_what_failed_or_is_not_covered_stays_visible() -> None:
    study = made()
    table = "\n".join(as_lines(study))
    assert "gave up at 0.1 s of a jump" in table
    assert "it knows no sand" in table
    drawn = work_precision_of(study)
    against, times, *not_drawn = drawn.notes
    assert against == "Errors are against: a made-up truth."
    assert times == f"Times are of one run, on one core of: {processor()}."
    assert times.lower() in table.lower()
    assert not_drawn == ["peer at rtol 1e-6: gave up at 0.1 s of a jump.", "absent: it knows no sand."]
    assert [mark.setting for mark in drawn.panels[0].curves[-1].marks] == ["1e-2", "1e-6"]
    assert drawn.methods == ("Euler", "peer", "absent", "labbook")
    assert [len(curve.marks) for curve in drawn.panels[0].curves] == [2, 1, 2]
    data = as_data(study)
    assert data["methods"][1]["points"][1]["failure"] == "gave up at 0.1 s of a jump"
    assert data["methods"][2]["why_not"] == "it knows no sand"


@pytest.mark.parametrize(("value", "text"), [(1e-4, "1e-4"), (1e-12, "1e-12"), (0.5, "0.5"), (2.5e-7, "2.5e-7")])
def test_settings_in_their_shortest_form(value: float, text: str) -> None:
    assert plain_number(value) == text
