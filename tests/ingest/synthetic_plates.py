"""Synthetic exports of force plates for tests, written in code: none of these bytes were recorded by a plate.

Every file holds the same hops on one plate or two: 0.4 s of stance under up to 60 N, with the centre of pressure at
x = 0.1 m, y = 0.05 m of the stored frame (z up), then 0.6 s of flight. Layouts follow what the programs are known to
write.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from labbook.demo.writers import PlateRecord, bertec_text

LOAD_N = 60.0
POUND_N, INCH_M = 4.4482216152605, 0.0254
COP_M = (0.1, 0.05)
SIDEWAYS_N = (6.0, -3.0)


def hops(n: int, rate_hz: float, load_n: float = LOAD_N) -> np.ndarray:
    """Vertical force of the hops, shape (n,), newtons: half a sine up to `load_n`, with a ripple."""
    phase = np.arange(n) % round(rate_hz) / (0.4 * rate_hz)
    return np.where(phase < 1, load_n * np.sin(np.pi * (0.9 * phase + 0.05)) + 0.25 * np.sin(np.arange(n)), 0.0)


def plate(fz: np.ndarray) -> dict[str, np.ndarray]:
    """Force, moment, centre of pressure and free moment of the stored frame, z up, reaction on the robot."""
    loaded = (fz != 0).astype(float)
    cop_x, cop_y = COP_M[0] * loaded, COP_M[1] * loaded
    fx, fy = (side * fz / LOAD_N for side in SIDEWAYS_N)
    return {
        "force_x": fx,
        "force_y": fy,
        "force_z": fz,
        "moment_x": cop_y * fz,
        "moment_y": -cop_x * fz,
        "moment_z": cop_x * fy - cop_y * fx + 0.01 * fz,
        "cop_x": cop_x,
        "cop_y": cop_y,
        "cop_z": 0 * fz,
        "free_moment_z": 0.01 * fz,
    }


def table(columns: Sequence[np.ndarray], form: str = "%.4f", delimiter: str = "\t") -> list[str]:
    """Rows of numbers, all in one form; a negative zero loses its sign."""
    return [delimiter.join(form % (cell + 0.0) for cell in row) for row in zip(*columns, strict=True)]


def y_up(stored: dict[str, np.ndarray], quantity: str) -> list[np.ndarray]:
    """The x, y, z components of a quantity in a frame with y up."""
    missing = 0 * stored["force_z"]
    along = {axis: stored.get(f"{quantity}_{axis}", missing) for axis in "xyz"}
    return [along["x"], along["z"], -along["y"]]


def opensim(n: int = 900, rate_hz: float = 300.0, load_n: float = LOAD_N) -> bytes:
    """An OpenSim .mot of two plates: y up, padded columns, force and point of both plates, then both torques."""
    stored = plate(hops(n, rate_hz, load_n))
    forces = y_up(stored, "force") + y_up(stored, "cop")
    names = [f"{foot}_ground_force_{part}{axis}" for foot in ("1", "2") for part in "vp" for axis in "xyz"]
    names += [f"{foot}_ground_torque_{axis}" for foot in ("1", "2") for axis in "xyz"]
    columns = [np.arange(n) / rate_hz, *forces, *forces, *y_up(stored, "free_moment"), *y_up(stored, "free_moment")]
    head = ["hops.mot", "version=1", f"nRows={n}", f"nColumns={len(columns)}", "inDegrees=yes", "endheader"]
    return ("\n".join([*head, "\t".join(["time", *names]), *table(columns, "%16.8f")]) + "\n").encode()


def cortex(n: int = 900, rate_hz: float = 450.0, up: str = "y", plates: int = 2, load_n: float = LOAD_N) -> bytes:
    """A Cortex .forces file: seven columns for each plate, points in millimetres, free moments in N mm."""
    stored = plate(hops(n, rate_hz, load_n))
    millimetres = stored | {f"cop_{axis}": 1000 * stored[f"cop_{axis}"] for axis in "xyz"}
    if up == "y":
        one = [*y_up(stored, "force"), *y_up(millimetres, "cop")]
    else:
        one = [stored[f"force_{axis}"] for axis in "xyz"] + [millimetres[f"cop_{axis}"] for axis in "xyz"]
    columns = [np.arange(1, n + 1), *[*one, 1000 * stored["free_moment_z"]] * plates]
    names = [f"{name}{number}" for number in range(1, plates + 1) for name in ("FX", "FY", "FZ", "X", "Y", "Z", "MZ")]
    head = ["[Force Data]", f"NumberOfForcePlates={plates}", f"SampleRate={rate_hz:f}", f"NumberOfSamples={n}"]
    rows = [f"{row.split(chr(9))[0].split('.')[0]}\t{row.split(chr(9), 1)[1]}" for row in table(columns, "%.2f")]
    return ("\r\n".join([*head, "\t".join(["#Sample", *names]), *rows]) + "\r\n").encode()


def bioware(
    n: int = 1200, rate_hz: float = 1000.0, version: str = "5.3.2.9", decimal: str = ".", load_n: float = LOAD_N
) -> bytes:
    """A BioWare export of two plates: metadata by column, names repeated, a row of units."""
    stored = plate(hops(n, rate_hz, load_n))
    names = ["Fx", "Fy", "Fz", "|Ft|", "Mx", "My", "Mz", "Ax", "Ay"]
    size = np.sqrt(sum(stored[f"force_{axis}"] ** 2 for axis in "xyz"))
    one = [*(stored[f"force_{axis}"] for axis in "xyz"), size, *(stored[f"moment_{axis}"] for axis in "xyz")]
    one += [stored["cop_x"], stored["cop_y"]]
    units = ["N", "N", "N", "N", "N*m", "N*m", "N*m", "m", "m"]

    def each(key: str, cell: str) -> str:
        return "\t".join([key, *[cell] * 18])

    head = [
        *(f"BioWare Version {version} Export", "\t".join(["Device:", *["9281"] * 9, *["9260"] * 9])),
        *(each("Samples (#):", str(n)), each("Rate (Hz):", f"{rate_hz:f}"), each("Contact period start (#):", "0")),
        *(each("Contact period end (#):", "9"), each("Contact period start (s):", "0"), each("First sample (s):", "0")),
        *(each("Normalized force (N):", "0"), each("Normalized length (m):", "0"), "File Information"),
        *("Date\tJan 01, 1980  03:02:40", "Name\thop", "ID\t1", "Classification\t", "Description\t"),
        *("\t".join(["abs time (s)", *names * 2]), "\t".join(["", *units * 2])),
    ]
    rows = table([np.arange(n) / rate_hz, *one, *one], "%.6f")
    return "\r\n".join([*head, *(row.replace(".", decimal) for row in rows), ""]).encode()


def vicon(
    n: int = 1000, rate_hz: float = 1000.0, per_frame: int = 10, padded: bool = True, load_n: float = LOAD_N
) -> bytes:
    """A Nexus export: two plates under Devices, two markers under Trajectories, perhaps padded with commas."""
    stored = plate(hops(n, rate_hz, load_n))
    blank, frames = "", np.arange(n) // per_frame + 1
    devices, columns, units, data = [], [], [], [frames, np.arange(n) % per_frame]
    for number in ("#1", "#2"):
        for what, letter, quantity, unit, scale in (
            ("Force", "F", "force", "N", 1),
            ("Moment", "M", "moment", "N.mm", 1000),
            ("CoP", "C", "cop", "mm", 1000),
        ):
            devices += [f"Imported Bertec Force Plate {number} - {what}", blank, blank]
            columns += [f"{letter}{axis}" for axis in "xyz"]
            units += [unit] * 3
            data += [scale * stored[f"{quantity}_{axis}"] for axis in "xyz"]
    lines = ["Devices", f"{rate_hz:g}", ",".join([blank, blank, *devices]), ",".join(["Frame", "Sub Frame", *columns])]
    lines += [",".join([blank, blank, *units])]
    lines += [row.replace(".0000,", ",", 2) for row in table(data, "%.4f", ",")]
    lines += ["", "Trajectories", f"{rate_hz / per_frame:g}", ",,Robot:HIP,,,Robot:TOE,,"]
    lines += ["Frame,Sub Frame,X,Y,Z,X,Y,Z", ",,mm,mm,mm,mm,mm,mm"]
    lines += [f"{frame},0,1,2,{400 + frame % 9},1,2,{frame % 7}" for frame in range(1, n // per_frame + 1)]
    if padded:
        lines = [line + "," * (20 - line.count(",")) for line in lines]
    return ("\r\n".join(lines) + "\r\n").encode()


def forcedecks(n: int = 1000, rate_hz: float = 500.0, version: str = "1.0") -> bytes:
    """A ForceDecks export: commas at the end of the metadata and not of the rows, the tare taken off already."""
    fz = hops(n, rate_hz)
    head = [f"ForceDecks Raw Data Export,{version},", "Weight (Kg),12.2,", f"Frequency,{rate_hz:g},"]
    head += ["Recording Date,2026-03-02T10:11:12.1234567,", 'Data Source,"Synthetic, no plate; none",']
    head += ["Analysis Date,2026-03-03,", "AthleteId,00000000-0000-0000-0000-000000000000,"]
    head += ["Tare,-12.5,7.25" if version.startswith("1") else "Z Tare,-18602.7,", ",,", "Time,Left,Right"]
    return "\r\n".join([*head, *table([np.arange(n) / rate_hz, fz, fz], "%.4f", ","), ""]).encode()


def pasco(n: int = 1000, rate_hz: float = 1000.0, second: int = 600) -> bytes:
    """A Capstone export of two runs, the second shorter: quoted decimal commas, a date to the minute."""
    names = ["Date and Time", "Time (s)", "Normal Force (N)", "Force Beam 1 (N)"]
    fz = hops(n, rate_hz)

    def quoted(number: float, decimals: int) -> str:
        return f'"{number:.{decimals}f}"'.replace(".", ",")

    rows = []
    for row in range(n):
        cells = ["02/03/2026 10:11", quoted(row / rate_hz, 3), quoted(fz[row], 4), quoted(fz[row] / 4, 4)]
        rows.append(",".join([*cells, *(cells if row < second else [""] * 4)]))
    return "\r\n".join([",".join(["Run #1"] * 4 + ["Run #2"] * 4), ",".join(names * 2), *rows, ""]).encode()


def qualisys(
    n: int = 1000, rate_hz: float = 500.0, longer: bool = True, up: str = "z down", load_n: float = LOAD_N
) -> bytes:
    """A QTM export of one plate in its own frame, of which the corners tell whether its third axis points down."""
    stored = plate(hops(n, rate_hz, load_n))
    # On a plate whose z axis points down, what is stored turns half a turn about x, and acts on the plate.
    signs = {"force": (-1, 1, 1), "moment": (-1, 1, 1), "cop": (1, -1, -1)} if up == "z down" else {}
    data = [
        sign * (1000 if quantity == "cop" else 1) * stored[f"{quantity}_{axis}"]
        for quantity in ("force", "moment", "cop")
        for axis, sign in zip("xyz", signs.get(quantity, (1, 1, 1)), strict=True)
    ]
    y_side = -1 if up == "z down" else 1
    head = [f"NO_OF_SAMPLES\t{n}", f"FREQUENCY\t{rate_hz:g}", "TIME_STAMP\t2026-03-02, 10:11:12.123\t7001.5"]
    head += ["FIRST_SAMPLE\t1", "DESCRIPTION\tForce data in local (force plate) coordinates", "DATA_INCLUDED\tForce"]
    head += ["FORCE_PLATE_TYPE\tBertec", "FORCE_PLATE_MODEL\tSynthetic", "FORCE_PLATE_NAME\tBERTEC 3"]
    for x_name, x in (("POSX", 300), ("NEGX", -300)):
        for y_name, y in (("POSY", 200), ("NEGY", -200)):
            place = zip("XYZ", (x, y * y_side, 0), strict=True)
            head += [f"FORCE_PLATE_CORNER_{x_name}_{y_name}_{axis}\t{value}" for axis, value in place]
    head += ["FORCE_PLATE_LENGTH\t600", "FORCE_PLATE_WIDTH\t400", *(f"FORCE_PLATE_OFFSET_{axis}\t0" for axis in "XYZ")]
    if longer:
        data = [np.arange(1, n + 1), np.arange(n) / rate_hz, *data]
    return "\r\n".join([*head, *table(data, "%.6f"), ""]).encode()


def amti(n: int = 300, rate_hz: float = 100.0, plates: int = 2, header: bool = True, load_n: float = LOAD_N) -> bytes:
    """A NetForce export with the header of a Polish program in cp1250, or none; force on a plate with z down."""
    stored = plate(hops(n, rate_hz, load_n))
    signs = zip(("force", "moment") * 3, "xxyyzz", (-1, -1, 1, 1, 1, 1), strict=True)
    one = {f"{quantity}_{axis}": sign * stored[f"{quantity}_{axis}"] for quantity, axis, sign in signs}
    data = [one[f"{quantity}_{axis}"] for quantity in ("force", "moment") for axis in "xyz"] * plates
    head = ["Nazwa profilu: hop", "Nazwa protokołu: hop", f"Częstotliwość akwizycji: {rate_hz:.2f}".replace(".", ",")]
    lines = [*([*head, "Zoffset: 0,170202"] if header else []), *table(data, "%.6f", " , "), ""]
    return "\r\n".join(lines).encode("cp1250")


def on_plate(stored: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What a plate with z down that tells the force on itself measures of what is stored."""
    turned = {"x": 1, "y": -1, "z": -1}
    return {name: turned[name[-1]] * (1 if name.startswith("cop") else -1) * column for name, column in stored.items()}


def bertec(n: int = 2000, load_n: float = LOAD_N) -> bytes:
    """A Bertec Acquire export of one plate: force on the plate with z down, metres."""
    told = on_plate(plate(hops(n, 1000.0, load_n)))
    force, moment = (np.stack([told[f"{of}_{axis}"] for axis in "xyz"], axis=1) for of in ("force", "moment"))
    cop = np.stack([told["cop_x"], told["cop_y"]], axis=1)
    return bertec_text(PlateRecord(np.arange(float(n)), force, moment, cop))


def bsf(rows: np.ndarray, rate_hz: int, version: int = 105, channels: int = 6) -> bytes:
    """A NetForce binary file of rows in pounds and inches, six columns a plate."""
    n, plates = len(rows), rows.shape[1] // 6
    header, own = bytearray(4 + 968), bytearray(948)
    struct.pack_into("<iii", header, 0, version, 968, plates)
    struct.pack_into("<d", header, 164, n / rate_hz)
    struct.pack_into("<i", header, 212, rate_hz)
    struct.pack_into("<i", own, 0, 948)
    struct.pack_into("<i", own, 32, channels)
    return bytes(header + own * plates) + rows.astype("<f8").tobytes()


def bsf_hops(n: int, load_n: float = LOAD_N) -> bytes:
    """A NetForce binary file of one plate at 100 Hz: the force on the plate with z down."""
    told = on_plate(plate(hops(n, 100.0, load_n)))
    forces = [told[f"force_{axis}"] / POUND_N for axis in "xyz"]
    moments = [told[f"moment_{axis}"] / POUND_N / INCH_M for axis in "xyz"]
    return bsf(np.column_stack([*forces, *moments]), 100)
