"""Values and currents that are asked about, and those that are not; all files are synthetic."""

from __future__ import annotations

import numpy as np
import pytest

from ingest.model import ColumnDeclaration, Declarations
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.reading import channel, read, refusal, rules
from tests.ingest.synthetic import text


def test_a_value_next_to_nothing_is_zero_and_no_damaged_byte() -> None:
    """Two thirds of the rows of a resting robot were left out for what a filter left of its speed."""
    speeds = [f"{0.01 * 0.4**k!r}" for k in range(300)]
    result = read(text("time [ms],leg_velocity [m/s]", [f"{3 * k},{v}" for k, v in enumerate(speeds)]))
    assert (result.refused, result.rows_kept) == (False, 300)
    assert result.parts[0].channels[0].values[[0, 100]] == pytest.approx([0.01, 0.0], abs=1e-30)


@pytest.mark.parametrize("word", ["DSC", "Dis", "D", "CC_DChg", "放电", "Entladen"])
def test_the_words_of_makers_for_discharging_are_known(word: str) -> None:
    rows = [f"{s},{word if s < 30 else 'CHG'},{2.0 if s < 30 else 1.5}" for s in range(60)]
    assert refusal(read(text("Time (s),Mode,Current (A)", rows))).rule == "current_unsigned"


@pytest.mark.parametrize("head", ["height [0.1 mm]", "height [0,1mm]", "height (0.1 mm)", "height [1/10 mm]"])
def test_a_count_of_a_column_may_be_a_part_of_a_unit(head: str) -> None:
    result = read(text(f"time [ms];{head}", [f"{10 * k};{3500 + k}" for k in range(100)]))
    assert result.parts[0].channels[0].values[[0, 99]] == pytest.approx([0.35, 0.3599])


def cycled(charging_a: float, discharging_a: float) -> bytes:
    """A battery that is charged, rests and is discharged, each for 30 s, with the name of each step."""
    steps = (("CC_Chg", charging_a), ("Rest", 0.0), ("CC_DChg", discharging_a))
    rows = [f"{30 * n + s},{name},{12 + s / 100:.2f},{a}" for n, (name, a) in enumerate(steps) for s in range(30)]
    return text("Time (s),Step Type,battery (V),Current (A)", rows)


@pytest.mark.parametrize("charging_a", [1.5, -1.5], ids=["without a sign", "turned round"])
def test_a_current_that_is_positive_while_discharging_is_asked_about(charging_a: float) -> None:
    """It was stored as `current, positive while charging`."""
    found = refusal(read(cycled(charging_a, 1.5)))
    assert found.rule == "current_unsigned"
    says(found.message, "Current (A)", "CC_DChg", "own.current_", "`sign = 1`")
    assert ("sign = -1" in found.message) is (charging_a < 0)
    as_is = read_file(cycled(charging_a, 1.5), Declarations(columns={"Current": ColumnDeclaration(sign=1)}))
    assert as_is.parts[0].channels[1].values[[0, 89]].tolist() == [charging_a, 1.5]


@pytest.mark.parametrize("remark", ["pack discharged yesterday", "entladen", ""])
def test_a_remark_that_something_was_discharged_is_no_step(remark: str) -> None:
    """A log of charging was refused as positive while it discharges."""
    for few in (True, False):
        rows = [f"{s},1.5,{remark if s == 0 or not few else ''}" for s in range(60)]
        result = read(text("Time (s),Current (A),remark", rows))
        assert not result.refused
        assert result.parts[0].channels[0].values[[0, 59]].tolist() == [1.5, 1.5]


@pytest.mark.parametrize(("header", "refused"), [("Step Type", True), ("Zustand", True), ("remark", False)])
def test_a_column_that_names_steps_is_asked_about_where_all_rows_discharge(header: str, refused: bool) -> None:
    assert read(text(f"Time (s),Current (A),{header}", [f"{s},1.5,CC_DChg" for s in range(60)])).refused is refused


def test_a_current_with_its_sign_is_read_beside_the_names_of_steps() -> None:
    result = read(cycled(1.5, -1.5))
    assert not result.refused
    assert channel(result, "current").values[[0, 89]].tolist() == [1.5, -1.5]


@pytest.mark.parametrize(("cop_m", "named"), [(0.1, False), (3.0, True)])
def test_a_centre_of_pressure_outside_the_plate_is_named_while_it_is_loaded(cop_m: float, named: bool) -> None:
    load_n = 500 * np.sin(np.pi * np.arange(400) / 50) + np.random.default_rng(2).normal(0, 1, 400)
    rows = [f"{k},{max(load, -2):.3f},{cop_m if load > 10 else 99.0}" for k, load in enumerate(load_n)]
    result = read(text("time [ms],Fz [N],COPx [m]", rows))
    assert ("cop_outside_plate" in rules(result)) is named
    assert not result.refused
