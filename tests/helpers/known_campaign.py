"""A campaign of known truth as files: labbook.toml, run sheet, a charger sheet a day, a log a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.cli.shell import good, labbook
from tests.helpers.hopping_log import REST_LENGTH_M, RISE_M, hopping_log

CONTROL_MAH = 200.0
"""What a control run takes beyond the passive drain."""
DURATION_S, DRAIN_MAH, DRAIN_MAH_S = 720.0, 2.0, 0.01
JUMPS = 5

EQUIPMENT = """
[robots.hopper]
body_mass_kg = 1.8
foot_mass_kg = 0.2
link_1_m = 0.1
link_2_m = 0.2
rest_length_m = 0.27
leg_min_m = 0.1
leg_max_m = 0.3

[batteries.A]
cells = 4
capacity_mah = 6600
"""

TOML = f"""
[study]
name = "known"
kind = "bed"
reference_voltage_v = 15.4
jumps_nominal = 5
time_zone = "UTC"
run_names = "r{{:03d}}"

[people]
"Ada Nwosu" = "AN"

[factors.foot]
kind = "label"
levels = ["large", "small"]

[factors.gain]
kind = "number"
levels = [0, 100]
control = 0

[protocol]
run_duration_s = 720
exclude_first_jumps = 0
{EQUIPMENT}
[analysis]
apex_bounds_percent = [-3, 3]
"""


Order = Sequence[tuple[str, int]]
"""The runs of a day in their order, each with its foot and gain."""


@dataclass(frozen=True)
class KnownCampaign:
    """What is true, and how runs are made.

    `saved_percent` by foot; `apex_percent`: by how much the treated apexes are higher; `days`: the runs of each day in
    their order, foot and gain, of every day; scatter of runs and days as shares of the control's; `drift` over a day's
    runs likewise; charges are read to `step_mah`; `analysis` are further lines of `[analysis]`.
    """

    saved_percent: Mapping[str, float]
    days: Sequence[Order]
    apex_percent: float = 0.0
    run_sd: float = 0.03
    day_sd: float = 0.03
    drift: float = 0.0
    step_mah: float = 1.0
    analysis: str = ""
    idle_minutes: Sequence[int] = field(default=(10, 15, 20, 30, 40, 60))

    def write(self, folder: Path, seed: int) -> None:
        """Write the files into an empty folder: `runs.csv`, `charges/`, `logs/`, and labbook.toml beside them."""
        rng = np.random.default_rng(seed)
        (folder / "charges").mkdir(parents=True)
        (folder / "logs").mkdir()
        (folder / "labbook.toml").write_text(TOML + self.analysis, encoding="utf-8")
        runs = ["run,date,position,kind,foot,gain,battery,robot,duration_s,jumps_made"]
        number = 0
        for day, order in enumerate(self.days):
            date, of_day = f"2026-03-{day + 2:02d}", rng.normal(0.0, self.day_sd)
            charges = ["run,mAh"]
            for position, (foot, gain) in enumerate(order, 1):
                number += 1
                name = f"r{number:03d}"
                runs.append(f"{name},{date},{position},jumps,{foot},{gain},A,hopper,{DURATION_S:.0f},{JUMPS}")
                share = 1.0 - (self.saved_percent[foot] / 100.0 if gain else 0.0)
                wanders = of_day + self.drift * (position - 1) / max(1, len(order) - 1)
                net = CONTROL_MAH * share * (1.0 + wanders + rng.normal(0.0, self.run_sd))
                charges.append(f"{name},{self._read(net + DRAIN_MAH + DRAIN_MAH_S * DURATION_S)}")
                higher = 1.0 + (self.apex_percent / 100.0 if gain else 0.0)
                apex_m = (REST_LENGTH_M + RISE_M) * (higher + rng.normal(0.0, 0.004))
                (folder / "logs" / f"{name}.csv").write_bytes(hopping_log(JUMPS, rise_m=apex_m - REST_LENGTH_M))
            for position, minutes in enumerate(self.idle_minutes if day == 0 else (), len(order) + 1):
                number += 1
                name, drained = f"r{number:03d}", DRAIN_MAH + DRAIN_MAH_S * 60.0 * minutes + rng.normal(0.0, 0.2)
                runs.append(f"{name},{date},{position},idle,,,A,hopper,{60 * minutes},")
                charges.append(f"{name},{self._read(drained)}")
            (folder / "charges" / f"{date}.csv").write_text("\n".join(charges) + "\n", encoding="utf-8")
        (folder / "runs.csv").write_text("\n".join(runs) + "\n", encoding="utf-8")

    def _read(self, mah: float) -> str:
        return f"{round(mah / self.step_mah) * self.step_mah:.10g}"


def begun(folder: Path) -> Path:
    """Make a book below a folder with the runs of the files in it."""
    good(labbook("init", "book", "--as", "Ada Nwosu", at=folder))
    book = folder / "book"
    (book / "labbook.toml").write_bytes((folder / "files" / "labbook.toml").read_bytes())
    good(labbook("runs", "import", "../files/runs.csv", at=book))
    return book


def shuffled(days: int, runs: Mapping[tuple[str, int], int], seed: int) -> list[Order]:
    """Return so many runs of each foot and gain for every day, in random order."""
    rng = np.random.default_rng([seed, 1])
    every = [condition for condition, n in runs.items() for _ in range(n)]
    return [[every[at] for at in rng.permutation(len(every))] for _ in range(days)]
