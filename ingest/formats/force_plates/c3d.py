"""C3D files: force platforms and analog channels as one part, markers as another.

Channels that a platform is made of are kept as its forces and moments only. A marker that was not seen has a negative
residual; its place is NaN.
"""

from __future__ import annotations

import numpy as np

from ingest.channels.columns import Convention
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.formats.force_plates.c3d_plates import Plate, length_factor, plate
from ingest.formats.force_plates.c3d_sections import C3dDamagedError, C3dSections, read_sections
from ingest.formats.format import SIGNATURE, Format, Recognition
from ingest.formats.head import Head
from ingest.instruments import Instrument
from ingest.model import FloatArray, Reading
from ingest.several import NamedTable, read_several
from ingest.tables.preamble import Preamble
from ingest.tables.table import array_table

_UNITS = {f"{quantity}_{axis}": unit for quantity, unit in (("force", "N"), ("moment", "N*m")) for axis in "xyz"}
_CONVENTION = Convention("the C3D standard", _UNITS)


def _recognise(head: Head) -> Recognition | None:
    """The second byte, 50 hex."""
    data = head.data
    is_c3d = head.source is None and len(data) >= 512 and data[1] == 0x50 and 2 <= data[0] <= 0x20
    return Recognition(SIGNATURE, "byte 2 is 50 hex, as of a C3D file") if is_c3d else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    tables = []
    try:
        with np.errstate(invalid="ignore", over="ignore"):  # values out of range are found with those of every format
            sections = read_sections(head.data)
            points, analogs = _values(head.data, sections)
            if analogs.shape[1]:
                tables.append(_analog_table(sections, analogs, findings))
            if points.shape[1]:
                tables.append(_marker_table(sections, points))
    except C3dDamagedError as damage:
        findings.add(FILE, "c3d_damaged", f"The C3D file cannot be read: {damage}; copy it again from its source.")
        return Reading()
    return read_several(tables, head.declared, findings)


def _values(data: bytes, sections: C3dSections) -> tuple[FloatArray, FloatArray]:
    """Return points, shape (3, n_points, n_frames), and analog values, shape (n_samples, n_analogs)."""
    rows = sections.values(data)
    points = rows[:, : 4 * sections.n_points].reshape(sections.n_frames, sections.n_points, 4)
    places = points[:, :, :3] * (1.0 if sections.scale < 0 else sections.scale)
    places[points[:, :, 3] < 0] = np.nan
    raw = rows[:, 4 * sections.n_points :].reshape(-1, sections.n_analogs) if sections.n_analogs else np.empty((0, 0))
    return places.transpose(2, 1, 0), _scaled(raw, sections)


def _scaled(raw: FloatArray, sections: C3dSections) -> FloatArray:
    """Return analog values in the units of the file: raw less its offset, times both scales."""
    count = raw.shape[1]
    offsets, scales = (sections.numbers(f"ANALOG:{name}")[:count] for name in ("OFFSET", "SCALE"))
    if min(offsets.size, scales.size) < count:
        raise C3dDamagedError(f"it has {count} analog channels and scales of {min(offsets.size, scales.size)}")
    if "UNSIGNED" in sections.texts("ANALOG:FORMAT"):
        offsets = offsets % 65536
        raw = raw % 65536 if sections.scale > 0 else raw
    general = sections.first("ANALOG:GEN_SCALE")
    return (raw - offsets) * (scales * (1.0 if general is None else general))


def _analog_table(sections: C3dSections, analogs: FloatArray, findings: FindingCollector) -> NamedTable:
    labels = _padded(sections.texts("ANALOG:LABELS"), analogs.shape[1], "channel")
    units = _padded(sections.texts("ANALOG:UNITS"), analogs.shape[1], "")
    plates = _plates(sections, analogs, units, findings)
    names: list[str] = []
    column_units: list[str | None] = []
    columns: list[FloatArray] = []
    for number, found in enumerate(plates, start=1):
        suffix = "" if number == 1 else f"_{number}"
        for quantity, unit, values in (("force", "N", found.force_n), ("moment", "N*m", found.moment_nm)):
            for at, axis in enumerate("xyz"):
                names.append(f"{quantity}_{axis}{suffix}")
                column_units.append(unit if found.units_stated else None)
                columns.append(np.ascontiguousarray(values[:, at]))
    used = {channel for found in plates for channel in found.channels}
    for channel in range(analogs.shape[1]):
        if channel not in used:
            # The word before it keeps a raw channel `Fz1` from being taken for the force of a platform.
            names.append(f"analog {labels[channel]}")
            column_units.append(units[channel] or None)
            columns.append(np.ascontiguousarray(analogs[:, channel]))
    preamble = Preamble((sections.point_rate_hz * sections.ratio) or None, None, "ANALOG:RATE")
    table = array_table(names, column_units, columns, preamble)
    return NamedTable(table, Instrument("force" if plates else "analog", _CONVENTION, evidence="C3D"))


def _plates(sections: C3dSections, analogs: FloatArray, units: list[str], findings: FindingCollector) -> list[Plate]:
    plates = []
    for number in range(min(16, int(sections.first("FORCE_PLATFORM:USED") or 0))):
        found = plate(sections, number, analogs, units)
        if found is None:
            message = (
                f"Force platform {number + 1} is of a type other than 1 to 4, or its channels or calibration are not "
                "in the file: its raw channels are kept as they are."
            )
            findings.add(NOTE, "plate_not_known", message, column=f"platform {number + 1}")
        else:
            plates.append(found)
    return plates


def _marker_table(sections: C3dSections, points: FloatArray) -> NamedTable:
    labels = _padded(sections.texts("POINT:LABELS"), points.shape[1], "point")
    metres = length_factor(sections)
    columns = [points[axis, number] * (metres or 1.0) for number in range(len(labels)) for axis in range(3)]
    names = [f"{label} {axis}" for label in labels for axis in "xyz"]
    units = ["m" if metres else None] * len(names)
    table = array_table(names, units, columns, Preamble(sections.point_rate_hz or None, None, "POINT:RATE"))
    return NamedTable(table, Instrument("markers", evidence="the C3D standard"))


def _padded(texts: tuple[str, ...], count: int, word: str) -> list[str]:
    """Return a text for each of `count` channels; those without one are numbered."""
    given = [*texts[:count], *[""] * (count - len(texts))]
    return [text or (f"{word} {number}" if word else "") for number, text in enumerate(given, start=1)]


FORMAT = Format("c3d", 2, _recognise, _read)
