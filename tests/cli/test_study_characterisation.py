"""`labbook study characterisation`: a known leg found again from logs of oscillations, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.signal
from numpy.typing import NDArray

from benchmarks.validation_document import STUDIES, covered, outside
from data_schema.errors import InputRefused
from labbook.demo.studies.sheets import DAMPING, POSITION_SD_M, STIFFNESS, VELOCITY_SD_M_S, oscillations
from labbook.studies.characterisation import Trial, characterisation
from stats.lines.stiffness import velocity_over_rate
from tests.cli.shell import good, labbook, refused
from tests.helpers.study_pages import study_page
from tests.helpers.wording import says

HEAD = "file,gain,damping_gain,mass_kg,neutral_cm\n"


def written(at: Path, drawn: list[Trial]) -> None:
    """Logs and their sheet, as a person keeps them."""
    rows = []
    for one in drawn:
        gain, damping_gain = one.condition.gain, one.condition.damping_gain
        name = f"g{gain:g}_{one.mass_kg:g}kg.csv"
        samples = zip(one.time_s, one.displacement_m, one.velocity_m_s, strict=True)
        log = "".join(f"{t * 1e3:.4f},{x * 1e3:.5f},{v:.6f}\n" for t, x, v in samples)
        (at / name).write_text("time_ms,position_mm,velocity (m/s)\n" + log, encoding="utf-8")
        rows.append(f"{name},{gain:g},{damping_gain:g},{one.mass_kg},20\n")
    (at / "trials.csv").write_text(HEAD + "".join(rows), encoding="utf-8")


@pytest.mark.soak
def test_intervals_cover_stiffness_and_damping() -> None:
    """Each count lies in the 99.9 % binomial band."""
    assert not outside(covered(STUDIES["characterisation"], 60))


def test_a_leg_without_errors_is_found_to_rounding() -> None:
    drawn = oscillations(np.random.default_rng(1), 0.0, 0.0)
    found = characterisation(drawn)
    for one in found.conditions:
        assert one.stiffness_n_m.value == pytest.approx(STIFFNESS[0] * one.gain + STIFFNESS[1], rel=1e-6)
        assert one.damping_kg_s.value == pytest.approx(DAMPING[0] * one.damping_gain + DAMPING[1], rel=1e-5)


def test_an_overdamped_leg_is_found_too() -> None:
    drawn = oscillations(np.random.default_rng(2), damping=(3.32, 60.0))
    slow = [one for one in characterisation(drawn).conditions if one.damping_gain == 0.0]
    assert slow[0].damping_kg_s.value == pytest.approx(60.0, rel=0.02)
    assert slow[0].stiffness_n_m.value == pytest.approx(STIFFNESS[0] * 60.0 + STIFFNESS[1], rel=0.02)


def correlated(chance: np.random.Generator, correlation: float) -> list[Trial]:
    """Masses on one pair of gains with errors that go together along each log."""

    def errors(n: int) -> NDArray[np.float64]:
        white = chance.normal(0.0, 1.0, n + 100)
        return np.asarray(scipy.signal.lfilter([(1.0 - correlation**2) ** 0.5], [1.0, -correlation], white)[100:])

    drawn = [one for one in oscillations(chance, 0.0, 0.0) if one.condition.gain == 200.0]
    return [
        replace(
            one,
            displacement_m=one.displacement_m + POSITION_SD_M * errors(one.time_s.size),
            velocity_m_s=one.velocity_m_s + VELOCITY_SD_M_S * errors(one.time_s.size),
        )
        for one in drawn
    ]


def test_errors_that_go_together_widen_the_interval_and_are_said() -> None:
    """A correlation of 0.8 has the long-run variance of independent errors of (1.8 / 0.2) ** 0.5 = 3 times the SD."""
    factors = []
    for seed in range(6):
        study = characterisation(correlated(np.random.default_rng(seed), 0.8))
        (one,) = study.conditions
        factors.append(one.widened)
        says(study.sentences()[-1], "gain 200", f"factor of {one.widened:.1f}")
        (alike,) = characterisation(correlated(np.random.default_rng(seed), 0.0)).conditions
        assert alike.widened < 1.25
        assert one.stiffness_n_m.se > 2.0 * alike.stiffness_n_m.se
    assert np.mean(factors) == pytest.approx(3.0, rel=0.2)


def test_the_page_s_command_finds_the_lines(tmp_path: Path) -> None:
    written(tmp_path, oscillations(np.random.default_rng(4)))
    page = study_page("characterisation.md")
    (tmp_path / "trials.csv").write_text(page.sheet, encoding="utf-8")
    shown = good(labbook(*page.words, at=tmp_path)).out
    assert "Stiffness at 20 cm = 2.5" in shown
    assert (tmp_path / "gains.pdf").read_bytes().startswith(b"%PDF")
    found = good(labbook("study", "characterisation", "trials.csv", "--json", at=tmp_path)).json
    (lines,) = found["lines"]
    assert lines["stiffness"]["slope"] == pytest.approx(STIFFNESS[0], rel=0.01)
    assert lines["damping"]["slope"] == pytest.approx(DAMPING[0], rel=0.05)


def test_conditions_with_few_points_are_left_out_and_named(tmp_path: Path) -> None:
    drawn = [one for one in oscillations(np.random.default_rng(5), dropped=0.0) if one.condition.gain < 300.0]
    written(tmp_path, drawn[:4])
    shown = good(labbook("study", "characterisation", "trials.csv", at=tmp_path)).out
    assert "Left out, as 250 points are needed: gain 200, damping gain 1.5 at 20 cm, with 150." in shown
    assert "no line, there are 1 gains" in shown
    (tmp_path / "trials.csv").write_text(HEAD + "g200_1kg.csv,200,1.5,1,20\n", encoding="utf-8")
    refused(labbook("study", "characterisation", "trials.csv", at=tmp_path), 2, "250 points", "150")


def test_a_mass_that_tells_nothing_alone_is_named(tmp_path: Path) -> None:
    first, *others = oscillations(np.random.default_rng(9))
    columns = {name: getattr(first, name)[:2] for name in ("time_s", "displacement_m", "velocity_m_s")}
    written(tmp_path, [replace(first, **columns), *others])
    shown = good(labbook("study", "characterisation", "trials.csv", at=tmp_path)).out
    says(shown, "No coefficients of 1 kg alone, gain 60, damping gain 0 at 20 cm", "the leg does not move")
    condition, *_ = good(labbook("study", "characterisation", "trials.csv", "--json", at=tmp_path)).json["conditions"]
    assert list(condition["masses_left_out"]) == ["1.0"]
    assert condition["masses_kg"] == [1.0, *(one["mass_kg"] for one in condition["masses"])]


@pytest.mark.parametrize(
    ("log", "said"),
    [
        ("time_ms,position_mm\n0,1\n", ("velocity (m/s)", "rate of compression")),
        ("time_ms,position_mm,velocity_m\n0,1,2\n", ("velocity",)),
        ("time_ms,position_mm,velocity (m/s)\n0,1,2\n0,x,2\n", ("'x'", "line 3")),
        ("time_ms,position_mm,velocity (m/s)\n0,1,2\n1,1,2\n1,1,2\n", ("a.csv", "not rise", "line 4")),
    ],
)
def test_logs_that_say_too_little_are_refused(log: str, said: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "trials.csv").write_text(HEAD + "a.csv,60,0,1,20\n", encoding="utf-8")
    (tmp_path / "a.csv").write_text(log, encoding="utf-8")
    refused(labbook("study", "characterisation", "trials.csv", at=tmp_path), 2, *said)


def test_a_log_that_is_named_twice_is_refused(tmp_path: Path) -> None:
    """It would count as two trajectories, and shorten the intervals."""
    written(tmp_path, oscillations(np.random.default_rng(7)))
    with (tmp_path / "trials.csv").open("a") as sheet:
        sheet.write("g60_1kg.csv,60,0,1.0,20\n")
    refused(labbook("study", "characterisation", "trials.csv", at=tmp_path), 2, "line 14", "that of line 2")


def test_positions_that_count_against_velocities_are_refused() -> None:
    drawn = [replace(one, displacement_m=-one.displacement_m) for one in oscillations(np.random.default_rng(6))]
    with pytest.raises(Exception, match="rise with the compression"):
        characterisation(drawn)


@pytest.mark.parametrize(("unit", "said"), [("mm/s", "times smaller"), ("km/s", "times larger")])
def test_a_velocity_of_another_unit_is_refused(unit: str, said: str, tmp_path: Path) -> None:
    """Least squares ended in a traceback, or took the log as it was."""
    written(tmp_path, oscillations(np.random.default_rng(10)))
    log = tmp_path / "g200_1.5kg.csv"
    log.write_text(log.read_text(encoding="utf-8").replace("(m/s)", f"({unit})", 1), encoding="utf-8")
    refused(labbook("study", "characterisation", "trials.csv", at=tmp_path), 2, log.name, said, "unit")


def test_motions_of_no_spring_are_told_or_refused() -> None:
    """No error of linear algebra, and no warning, whatever the logs hold."""
    chance = np.random.default_rng(11)

    def noise(one: Trial, sd: float) -> NDArray[np.float64]:
        return chance.normal(0.0, sd, one.time_s.size)

    changes: tuple[Callable[[Trial], dict[str, Any]], ...] = (
        lambda one: {"displacement_m": noise(one, 1e-4), "velocity_m_s": noise(one, 5e-3)},
        lambda one: {"displacement_m": noise(one, 0.0) + 0.07, "velocity_m_s": noise(one, 0.0)},
        lambda one: {"velocity_m_s": chance.permutation(one.velocity_m_s) / 1e3},
        lambda one: {"mass_kg": 1e9},
        lambda one: {"mass_kg": 1e-9},
    )
    drawn = oscillations(chance)[:3]
    for change in changes:
        try:
            found = characterisation([replace(one, **change(one)) for one in drawn])
        except InputRefused:
            continue
        assert found.sentences()


def test_noise_lost_packets_and_few_samples_are_no_other_unit() -> None:
    for seed in range(5):
        for one in oscillations(np.random.default_rng(seed), 3e-3, 0.15, dropped=0.2):
            share = velocity_over_rate(one.time_s[::4], one.displacement_m[::4], one.velocity_m_s[::4])
            assert share is None or 0.5 < share < 2.0
