"""A sensor that is calibrated, moved, or whose zero is off: from the command line to the report."""

from __future__ import annotations

import itertools
import math
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.shell import good, labbook, refused
from tests.helpers.attention import told
from tests.helpers.known_campaign import EQUIPMENT
from tests.helpers.standing_log import REST_LENGTH_M, as_csv, standing_log
from tests.helpers.wording import says

DAYS = ("2024-03-04", "2024-03-05")
AT_0_2_M = {DAYS[0]: 812, DAYS[1]: 800}
"""What the sensor shows at 0.2 m: it was moved between the days."""
PER_M = (3071 - 812) / 0.65
SE_M = 0.001
FACTOR = """
[factors.b_ad_gain]
kind = "number"
levels = [0, 100]
control = 0
"""
PROFILE = """
[profiles.adc]
recognise = ["t", "adc_h"]
time = { column = "t", unit = "ms" }
[profiles.adc.columns.adc_h]
channel = "body_height"
unit = "m"
calibrations = [
  { raw = [812, 3071], height = [0.20, 0.85], se = 0.001, source = "ruler, page 12", until = 2024-03-04 },
  { raw = [800, 3059], height = [0.20, 0.85], se = 0.001, source = "ruler, page 14", from = 2024-03-05 },
]
"""


def book(folder: Path, more: str = "") -> Path:
    good(labbook("init", "book", "--as", "Ada Nwosu", at=folder))
    toml = folder / "book" / "labbook.toml"
    equipment = EQUIPMENT.replace("rest_length_m = 0.27", f"rest_length_m = {REST_LENGTH_M}")
    toml.write_text(f"{toml.read_text(encoding='utf-8')}\n{FACTOR}{equipment}{more}", encoding="utf-8")
    lines = ["run,position,date,kind,b_ad_gain,battery,robot,duration_s,jumps_made"]
    lines += [f"r{n:03},{n},{DAYS[n > 4]},jumps,{0 if n % 2 else 100},A,hopper,720,10" for n in range(1, 9)]
    (folder / "runs.csv").write_text("\n".join(lines) + "\n")
    good(labbook("runs", "import", "../runs.csv", at=folder / "book"))
    return folder / "book"


def counted(folder: Path, n: int, at_0_2_m: int) -> tuple[Path, float]:
    """Write the log of run n in counts of a sensor; returns it and its mean apex height in m."""
    time_s, height_m, apexes_m = standing_log(n, 10)
    log = folder / f"r{n:03}.txt"
    log.write_text(as_csv("t,adc_h", time_s, np.round(at_0_2_m + (height_m - 0.2) * PER_M), 0))
    return log, float(apexes_m.mean())


def page(at: Path) -> str:
    good(labbook("report", "--out", "out", at=at))
    return (at / "out" / "report.html").read_text(encoding="utf-8")


def shown(at: Path, run: str) -> Any:
    return good(labbook("show", run, "--json", at=at)).json


def test_a_moved_sensor_is_read_by_the_calibration_of_the_day_of_its_run(tmp_path: Path) -> None:
    at = book(tmp_path, PROFILE)
    logs = [counted(tmp_path, n, AT_0_2_M[DAYS[n > 4]]) for n in range(1, 9)]
    good(labbook("ingest", *(log for log, _mean_m in logs), at=at))
    says(page(at), "ruler, page 12", "ruler, page 14", "Ada Nwosu")
    for log, mean_m in logs:
        found = shown(at, log.stem)
        assert found["mean_apex_height"]["value"] == pytest.approx(mean_m, abs=0.0005)
        assert [channel["person"] for channel in found["calibrated"]] == ["Ada Nwosu"]
    says(good(labbook("show", "r001", at=at)).out, "ruler, page 12", "Ada Nwosu")

    # Both calibrations err on their own; half of each condition's runs have the one, half the other.
    table = (at / "out" / "tables" / "apex_by_condition.csv").read_text().splitlines()
    cells = dict(zip(table[0].split(","), table[1].split(","), strict=True))
    raw = AT_0_2_M[DAYS[0]] + (float(cells["mean_m"]) - 0.2) * PER_M
    of_one = SE_M * math.hypot(3071 - raw, raw - 812) / 2259
    assert float(cells["shared_se_m"]) == pytest.approx(of_one / math.sqrt(2), rel=1e-3)
    difference = good(labbook("stats", "compare", "--quantity", "apex", "--json", at=at)).json["decisions"][0]
    assert difference["p"] > 0.05
    good(labbook("rebuild", at=at))
    assert shown(at, "r001")["calibrated"][0]["calibrated_unit"] == "m"


def test_heights_follow_the_calibration_of_the_day_of_the_run(tmp_path: Path) -> None:
    """A log without a date that moves to a run of another day, and a run whose date is corrected."""
    at = book(tmp_path, PROFILE)
    log, true_m = counted(tmp_path, 1, AT_0_2_M[DAYS[1]])
    says(good(labbook("ingest", log, "--explain", at=at)).out, "ruler, page 12")
    good(labbook("ingest", log, at=at))

    def mean_m(run: str) -> Any:
        good(labbook("report", "--out", "out", at=at))
        return shown(at, run)["mean_apex_height"]["value"]

    as_of_first_day = mean_m("r001")
    assert as_of_first_day == pytest.approx(true_m - 12 / PER_M, abs=0.0005)
    good(labbook("assign", "r001.txt", "r005", "--why", "its log", at=at))
    assert mean_m("r005").keys() == {"reason"}
    says(good(labbook("show", "r005", at=at)).out, "labbook files reread r001.txt")
    good(labbook("files", "reread", "--all", at=at))
    assert mean_m("r005") == pytest.approx(true_m, abs=0.0005)
    says(good(labbook("files", "reread", "--all", at=at)).out, "no file")
    good(labbook("correct", "r005", "date=2024-03-04", "--why", "made the day before", at=at))
    assert mean_m("r005").keys() == {"reason"}
    good(labbook("files", "reread", "r001.txt", at=at))
    good(labbook("rebuild", at=at))
    assert mean_m("r005") == as_of_first_day


def test_logs_read_with_an_earlier_calibration_are_named_until_they_are_read_again(tmp_path: Path) -> None:
    at = book(tmp_path, PROFILE)
    logs = [counted(tmp_path, n, AT_0_2_M[DAYS[0]])[0] for n in (1, 2)]
    (tmp_path / "r003.csv").write_text(as_csv("t [ms],body_height [m]", *standing_log(3, 10)[:2], 5))
    good(labbook("ingest", *logs, "../r003.csv", at=at))
    today = ("today", "--day", DAYS[0])
    assert "file_outdated" not in told(at, *today)
    toml = at / "labbook.toml"
    toml.write_text(toml.read_text(encoding="utf-8").replace("height = [0.20, 0.85]", "height = [0.21, 0.86]"))
    advice = ("2 files", "r001.txt, r002.txt", "labbook files reread --all")
    says(page(at).partition("Limitations")[2], *advice)
    outdated = told(at, *today)["file_outdated"]
    assert [one["file"] for one in outdated] == ["r001.txt", "r002.txt"]
    assert {one["command"] for one in outdated} == {"labbook files reread --all"}
    said = good(labbook("ingest", *logs, "../r003.csv", at=at)).out
    says(said, "r001.txt, r002.txt", "labbook files reread --all")
    assert said.count("reread") == 1
    good(labbook("files", "reread", "--all", at=at))
    assert "file_outdated" not in told(at, *today)
    assert "reread --all" not in page(at)


def test_a_zero_that_is_off_is_named_with_the_command_that_mends_it(tmp_path: Path) -> None:
    at = book(tmp_path)
    time_s, height_m, apexes_m = standing_log(1, 10, zero_m=0.059)
    (tmp_path / "r001.txt").write_text(as_csv("t,h", time_s, 100 * height_m, 3))
    answer = good(labbook("ingest", "../r001.txt", "--column", "h=body_height:cm", "--unit", "t=ms", at=at))
    sentence = says(answer.out, "height_zero_doubtful", "labbook files reread")
    says(answer.out, "10 of 10 jumps found")
    today = ("today", "--day", DAYS[0])
    says(page(at).partition("Limitations")[2], "r001", "too high", "labbook files show r001.txt")
    (command,) = re.findall(r"`labbook (files reread .*?)`", sentence)
    (doubtful,) = told(at, *today)["zero_doubtful"]
    assert shlex.split(doubtful["command"])[1:] == shlex.split(command)
    says(good(labbook("files", "show", "r001.txt", at=at)).out, command)
    good(labbook(*shlex.split(command), at=at))
    assert "too high" not in page(at)
    assert "zero_doubtful" not in told(at, *today)
    assert shown(at, "r001")["mean_apex_height"]["value"] == pytest.approx(float(apexes_m.mean()), abs=0.003)


def test_a_log_in_which_no_stance_can_be_found_says_so(tmp_path: Path) -> None:
    at = book(tmp_path)
    time_s, height_m, _apexes_m = standing_log(1, 10)
    moving = (time_s > 1.0) & (time_s < time_s[-1] - 1.0)
    (tmp_path / "r001.txt").write_text(as_csv("t [ms],h [m]", time_s[moving], height_m[moving] + 0.4, 5))
    answer = labbook("ingest", "../r001.txt", "--column", "h=body_height:m", at=at)
    says(answer.out, "no_stance_found", "0.260 m")
    (tmp_path / "r002.txt").write_text(as_csv("t [ms],h [m]", time_s, np.full(time_s.size, 0.2), 5))
    answer = labbook("ingest", "../r002.txt", "--column", "h=body_height:m", at=at)
    says(answer.out, "no_stance_found", "0.200 and 0.200 m", "loose")


def test_a_sensor_is_calibrated_from_a_log_of_known_heights(tmp_path: Path) -> None:
    levels = [812.0, 1507.0, 2202.0, 3071.0]
    pieces = [np.full(900, levels[0])]
    for before, after in itertools.pairwise(levels):
        pieces += [np.linspace(before, after, 250), np.full(900, after)]
    values = np.concatenate(pieces) + np.random.default_rng(1).normal(0, 1.5, 900 * 4 + 750)
    (tmp_path / "heights.csv").write_text(as_csv("t,adc_h", np.arange(values.size) / 500, values, 0))
    words = ("calibrate-sensor", "heights.csv", "--column", "adc_h", "--points", "0.2,0.4,0.6,0.85", "--time", "t:ms")
    found = good(labbook(*words, "--source", "ruler", "--json", at=tmp_path)).json
    assert {"column", "calibration", "rests", "left"} <= found.keys()
    slope, level = np.polyfit(levels, [0.2, 0.4, 0.6, 0.85], 1)
    assert found["calibration"]["scale"] == pytest.approx(slope, rel=1e-3)
    assert found["calibration"]["offset"] == pytest.approx(level, abs=2e-4)
    line = good(labbook(*words, at=tmp_path)).out.splitlines()[-1]
    at = book(tmp_path, f'\n[profiles.adc]\nrecognise = ["t", "adc_h"]\n[profiles.adc.columns]\n{line}\n')
    good(labbook("ingest", "../heights.csv", "--unit", "t=ms", "--dry-run", at=at))
    assert labbook(*words[:3], "nothing", *words[4:], at=tmp_path).code == 2
    for points, fact in (("0.2,0.4,0.85", "4 times"), ("0.2,0.6,0.4,0.85", "4 rests")):
        refused(labbook(*words[:5], points, *words[6:], at=tmp_path), 2, fact, "order of time")
