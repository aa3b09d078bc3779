"""Synthetic instrument files for tests, written in code: none of these bytes were recorded by an instrument.

Layouts follow what the instruments are known to write; values are smooth curves with seeded noise.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from labbook.demo.writers import checksum

LOG_HEADER = "time [ms],height [m],leg_length [m],k_gain"


def robot_rows(n: int = 600, rate_hz: float = 300.0, seed: int = 1) -> list[str]:
    """Rows of a string-pot log: whole milliseconds, height, leg length, gain."""
    noise = np.random.default_rng(seed)
    time_ms = np.floor(np.arange(n) * 1000.0 / rate_hz).astype(int)
    height = 0.42 + 0.05 * np.sin(np.arange(n) / 40.0) + noise.normal(0.0, 1e-3, n)
    leg = 0.20 + noise.normal(0.0, 1e-3, n)
    return [f"{t},{h:.6f},{x:.6f},400" for t, h, x in zip(time_ms, height, leg, strict=True)]


def text(header: str, rows: Sequence[str], end: str = "\n") -> bytes:
    """Header and rows as a text file."""
    return (end.join([header, *rows]) + end).encode()


def robot_log(n: int = 600, rate_hz: float = 300.0, seed: int = 1) -> bytes:
    """A clean string-pot log."""
    return text(LOG_HEADER, robot_rows(n, rate_hz, seed))


def bertec_acquire(
    n: int = 2000, plates: int = 1, load_n: float = 60.0, step_ms: float = 1.00002, seed: int = 2
) -> bytes:
    """A Bertec Acquire export: hops of `load_n` newtons, half more at touchdown, and unloaded noise on each plate."""
    noise = np.random.default_rng(seed)
    names = ["Seq", "Timestamp", "Sync", "Aux"] + ["Fx", "Fy", "Fz", "Mx", "My", "Mz", "COPx", "COPy"] * plates
    phase = np.arange(n) % 1000
    stance = np.where(phase < 400, load_n * (1 + np.maximum(0.5 - phase / 100, 0.0)), 0.0)
    columns: list[np.ndarray] = [np.arange(n), np.arange(n) * step_ms, np.zeros(n), np.zeros(n)]
    for _ in range(plates):
        fz = stance + noise.normal(0, 1.0, n)
        fx, fy = noise.normal(-6, 1, n), noise.normal(0, 1, n)
        my, mx = -0.1 * fz, 0.05 * fz
        columns += [fx, fy, fz, mx, my, noise.normal(0, 0.1, n), -my / fz, mx / fz]
    formats = ["%d", "%.5f", "%d", "%d"] + ["%.4f"] * (8 * plates)
    rows = [",".join(f % v for f, v in zip(formats, row, strict=True)) for row in zip(*columns, strict=True)]
    return text(",".join(names), rows, "\r\n")


def icharger_line(*fields: int) -> str:
    """One record of an iCharger log with its checksum."""
    body = "$" + ";".join(map(str, fields)) + ";"
    return body + str(checksum(body.encode()))


def icharger_rows(
    n: int = 400, channel: int = 1, mode: int = 1, current_a: float = 3.6, counter_scale: float = 1.0
) -> list[str]:
    """A charge (mode 1) or discharge (mode 2) at constant current: 1 mAh a second at 3.6 A."""
    sign = 1 if mode == 1 else -1
    rows = []
    for second in range(n):
        charge = sign * round(counter_scale * current_a * second / 3.6)
        cells = [3900 + second // 10] * 4 + [0] * 6
        pack = sum(cells)
        current = sign * round(current_a * 100)
        rows.append(icharger_line(channel, mode, second * 1000, 1, 0, current, 24000, pack, charge, 380, 0, *cells))
    return rows


SHEET = """run,mAh,minutes,end_voltage,pack
r001,461,12.5,16.8,A
r002,470,13,16.79,B
r003,455,12:30,16.81,A
"""


TWENTY_RULES = frozenset(
    {
        *("encoding_declared", "rate_contradicts", "unit_missing", "unit_not_convertible"),
        *("duplicate_column", "unknown_column", "text_column", "empty_column", "comment_line", "header_repeated"),
        *("ragged_row", "not_a_number", "value_missing", "not_finite", "out_of_range", "time_duplicate"),
        *("time_backwards", "time_spike", "time_missing", "thousands_separator", "quote_unbalanced"),
        *("decimal_sign_mixed", "nul_bytes", "ctrl_z", "packets_dropped", "recording_paused", "last_line_cut"),
        "channel_constant",
    }
)


def twenty_faults() -> tuple[bytes, frozenset[str]]:
    """A log with more than twenty faults of different kinds, and the rules that must find them."""
    rows = [
        f"{row},{spare},{row.split(',')[1]},{state},0.5,"
        for row, spare, state in zip(robot_rows(2000), range(2000), ["STANCE", "FLIGHT"] * 1000, strict=True)
    ]
    header = b"# rate: 1000 Hz \xb0C\r\n# written by hand\n"
    header += b"time [ms],height [m],leg_length,k_gain,counts,height [m],mode_text,leg_velocity [kg],unused\n"

    rows[100] = "# a remark in the middle"
    rows[101] = header.decode("latin-1").splitlines()[-1]
    rows[200] = "1,2,3"
    stamps = [row.split(",")[0] for row in rows]
    for row, place, cell in (
        *((210, 1, "ERROR"), (220, 1, ""), (230, 1, "1.#INF"), (240, 1, "2.2e35"), (250, 0, stamps[249])),
        *((260, 0, stamps[255]), (270, 0, "99999999"), (280, 0, ""), (290, 3, "1'234.5"), (300, 3, '"12')),
        *((310, 3, '"1,5"'), *((later, 0, str(int(stamps[later]) + 5000)) for later in range(1003, len(rows)))),
    ):
        cells = rows[row].split(",")
        rows[row] = ",".join([*cells[:place], cell, *cells[place + 1 :]])
    rows[320] = rows[320].replace(",", ",\0", 1)
    rows[330] = "\x1a"
    del rows[400:403]
    body = "\n".join(rows[:-1]) + "\n" + rows[-1][:12]
    return header + body.encode("latin-1"), TWENTY_RULES
