"""What a study of accuracy says in words."""

from __future__ import annotations

from dataclasses import replace

import pytest

from labbook.presenting.simulation.work_precision import as_data, as_lines, plain_number, processor, work_precision_of
from reports.display import time_text
from simulator.accuracy.methods import NAMES
from simulator.accuracy.reference_of import Reference
from simulator.accuracy.study import AccuracyStudy, Point, Series
from simulator.changes import changed_by_words
from simulator.scene_file import load_scene
from tests.helpers.wording import says


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
    says(lines, "1 %", "1e-4 s", "200 µs", "2 times")
    says(lines, "1 %", "1e-3", "10 ms", "100 times")
    says(lines, "1e-6", "no setting of", "peer")
    says(lines, "1 %", "you need accuracy", "1e-2", "100 µs")
    says(lines, "1e-6", "joules no setting", "1e-4 s", "3.0e-03", "200 µs")
    says(lines, "1e-6", "you need accuracy", "200 µs")


def test_one_setting_that_was_tried_is_called_that() -> None:
    study = made()
    one = replace(study, series=tuple(replace(series, points=series.points[:1]) for series in study.series))
    says(as_lines(one), "1e-6", "tried will not", "1e-3 s", "2.0e-02", "10 µs")


def test_title_and_data_tell_what_was_changed() -> None:
    study = replace(made(), scene=changed_by_words(load_scene("sim2"), ["b_ad=100"]))
    says(as_lines(study)[0], "but with", "b_ad=100")
    says(work_precision_of(study).title, "but with", "b_ad=100")
    folded = replace(study, reference=replace(study.reference, outcome="leg_folded"))
    says(work_precision_of(folded).title, "b_ad=100", "leg_folded")
    assert as_data(study)["set_by_user"] == {"b_ad": 100.0}


def test_under_the_floor_nobody_can_say() -> None:
    lines = as_lines(made(floor=1e-5))
    says(lines, "1e-6", "nobody can say", "1.0e-05")
    says(lines, "the last bits")
    assert any("<1.0e-05" in line for line in lines)


def test_what_failed_or_is_not_covered_stays_visible() -> None:
    study = made()
    table = "\n".join(as_lines(study))
    says(table, "gave up at", "0.1 s")
    says(table, "knows no sand")
    drawn = work_precision_of(study)
    against, times, *not_drawn = drawn.notes
    says(against, "Errors are against")
    assert processor() in times
    assert times.lower() in table.lower()
    says(not_drawn, "peer", "rtol 1e-6", "0.1 s", "absent", "no sand")
    assert [mark.setting for mark in drawn.panels[0].curves[-1].marks] == ["1e-2", "1e-6"]
    assert drawn.methods == ("Euler", "peer", "absent", "labbook")
    assert [len(curve.marks) for curve in drawn.panels[0].curves] == [2, 1, 2]
    data = as_data(study)
    says(data["methods"][1]["points"][1]["failure"], "gave up at", "0.1 s")
    says(data["methods"][2]["why_not"], "knows no sand")


@pytest.mark.parametrize(("value", "text"), [(1e-4, "1e-4"), (1e-12, "1e-12"), (0.5, "0.5"), (2.5e-7, "2.5e-7")])
def test_settings_in_their_shortest_form(value: float, text: str) -> None:
    assert plain_number(value) == text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(2.0, "2 s"), (0.9996, "1 s"), (1234.5, "1234 s"), (0.0123, "12.3 ms"), (65.4e-6, "65.4 µs"), (1e-7, "0.1 µs")],
)
def test_times_with_the_unit_that_suits_them(seconds: float, text: str) -> None:
    assert time_text(seconds) == text
