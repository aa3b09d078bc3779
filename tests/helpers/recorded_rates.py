"""Every simulated error rate, read once a process."""

from __future__ import annotations

from benchmarks.stats_evidence.sizes.record import every_rate

EVERY = every_rate()
