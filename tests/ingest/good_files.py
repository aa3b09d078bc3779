"""A small good file of every format, synthetic: what truncation and fuzzing start from.

A format joins with a line in `GOOD_FILES`: its name, and a function that returns the bytes. Keep them near 1 kB.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ingest.model import ColumnDeclaration, Declarations
from tests.ingest import synthetic_plates as plates
from tests.ingest.formats import synthetic_chargers as chargers
from tests.ingest.formats.synthetic_labview import labview
from tests.ingest.formats.synthetic_minitaur import new_log
from tests.ingest.synthetic import LOG_HEADER, SHEET, bertec_acquire, icharger_rows, robot_rows, text
from tests.ingest.synthetic_c3d import c3d_bytes, platform


def lines_of(head: str, *rows: str) -> bytes:
    """A sheet of nine times these rows, each numbered from 15 on."""
    return "\n".join([head, *(row.format(15 + n) for n in range(9) for row in rows), ""]).encode()


GOOD_FILES: Mapping[str, Callable[[], bytes]] = {
    "delimited_log": lambda: text(LOG_HEADER, robot_rows(24)),
    "debug_lines": lambda: "".join(f"motor1: {7 * n % 13}\nmotor2: {n}\n" for n in range(30)).encode(),
    "labelled_values": lambda: "".join(
        f"t={4 * n} ms, height={0.4 + n / 100:.2f} m, k={n % 7}\n" for n in range(30)
    ).encode(),
    "labview": lambda: labview(24),
    "bertec_text": lambda: bertec_acquire(n=12),
    "amti_text": lambda: plates.amti(n=12),
    "bioware": lambda: plates.bioware(n=12),
    "vicon_csv": lambda: plates.vicon(n=20),
    "forcedecks": lambda: plates.forcedecks(n=20),
    "pasco": lambda: plates.pasco(n=20, second=10),
    "qualisys_tsv": lambda: plates.qualisys(n=20),
    "cortex_forces": lambda: plates.cortex(n=12),
    "opensim": lambda: plates.opensim(n=12),
    "c3d": lambda: c3d_bytes(np.tile(np.arange(1.0, 9.0), (10, 1)), platform(2)),
    "amti_bsf": lambda: plates.bsf_hops(6),
    "flask_sheet": lambda: lines_of("radius_mm,state,water_ml", "{0},loose,6.29", "{0},compacted,5.85"),
    "walk_sheet": lambda: lines_of("walk;robot;mass_kg;distance (km);energy_Wh", "dune {0};thin;8.1;0.43;12.4"),
    "trial_sheet": lambda: lines_of("file,gain,damping_gain,mass_kg", "{0}.csv,60,0,1.0"),
    "charger_sheet": SHEET.encode,
    "icharger_log": lambda: ("\n".join(icharger_rows(14)) + "\n").encode(),
    "icharger_serial": lambda: chargers.lines(chargers.serial_rows(14)),
    "cheali_log": lambda: chargers.lines(chargers.cheali_rows(14)),
    "logview_openformat": lambda: chargers.lines(chargers.bare_rows(20)),
    "minitaur_log": lambda: new_log(12),
}

DECLARED: Mapping[str, Declarations] = {
    "debug_lines": Declarations(rate_hz=100.0),
    "icharger_serial": Declarations(rate_hz=0.5),
    "logview_openformat": Declarations(
        time_unit="ms",
        columns={"value_1": ColumnDeclaration("battery_voltage", "mV"), "value_2": ColumnDeclaration("current", "mA")},
    ),
}
"""What has to be said of files that do not say all themselves."""
