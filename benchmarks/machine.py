"""What the numbers were measured on."""

from __future__ import annotations

import datetime as dt
import importlib.metadata
import os
import platform
import sqlite3

from labbook.presenting.simulation.work_precision import processor

LIBRARIES = ("numpy", "scipy", "pandas", "pyarrow", "SQLAlchemy", "matplotlib", "typer")


def described() -> list[tuple[str, str]]:
    """Return the machine as (name, value) pairs."""
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in LIBRARIES)
    return [
        ("date", f"{dt.datetime.now(dt.UTC):%Y-%m-%d}"),
        ("processor", processor()),
        ("cores", str(os.cpu_count())),
        ("memory", f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.0f} GiB"),
        ("system", f"{_system()}, kernel {platform.release()}"),
        ("Python", f"{platform.python_implementation()} {platform.python_version()}"),
        ("libraries", f"{versions}, SQLite {sqlite3.sqlite_version}"),
    ]


def measured_on() -> str:
    """Say in a sentence the date, the load of the last minute, and what the machine is."""
    found = dict(described())
    date, cores = found.pop("date"), f"{found.pop('cores')} cores"
    return f"Measured on {date}, load at its start {load():.1f}: {', '.join([cores, *found.values()])}."


def load() -> float:
    """Return the load of the last minute: processes that wanted a core."""
    return os.getloadavg()[0]


def _system() -> str:
    try:
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    except OSError:
        return platform.platform(terse=True)
