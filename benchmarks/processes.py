"""Whole processes: their wall time, processor time and peak of resident memory."""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

LOOK_EVERY_S = 0.02
LABBOOK = Path(sys.executable).with_name("labbook")


@dataclass(frozen=True, slots=True)
class ProcessRun:
    """How a process went; `peak_mb` is None where /proc does not tell. `output` is what it printed."""

    wall_s: float
    cpu_s: float
    peak_mb: float | None
    output: str

    @property
    def cells(self) -> tuple[str, str, str]:
        """Wall and processor time in s, and the peak in MB, as text."""
        return f"{self.wall_s:.1f}", f"{self.cpu_s:.1f}", self.peak_text

    @property
    def peak_text(self) -> str:
        """The peak in MB, empty where it is not told."""
        return "" if self.peak_mb is None else f"{self.peak_mb:.0f}"


def run_process(command: Sequence[str | Path], codes: Sequence[int] = (0,)) -> ProcessRun:
    """Run a command to its end and measure all of it; raises when it ends with another code than one of these.

    The peak is the system's own high-water mark (VmHWM), read until the process ends: the one that wait4 gives begins
    at the size of the process that started it. It may keep what it compiles, as where labbook is installed.
    """
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        peak = None
        while True:
            peak = _high_water_mb(process.pid) or peak
            try:
                output, _ = process.communicate(timeout=LOOK_EVERY_S)
                break
            except subprocess.TimeoutExpired:
                continue
    wall_s, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if process.returncode not in codes:
        raise RuntimeError(f"{' '.join(map(str, command))} ended with {process.returncode}")
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return ProcessRun(wall_s, cpu_s, peak, output)


def _high_water_mb(pid: int) -> float | None:
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    except OSError:
        return None
    found = re.search(r"VmHWM:\s+(\d+) kB", status)
    return int(found.group(1)) * 1024 / 1e6 if found else None
