"""C3D files: force platforms and analog channels as one part, markers as another, read with ezc3d.

Channels that a platform is made of are kept as its forces and moments only. SGI files, which ezc3d does not read, are
turned into Intel order first. Integers of unsigned converters are corrected, which ezc3d takes for signed ones.
"""

from __future__ import annotations

import tempfile

import numpy as np

from ingest.channels.columns import Convention
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.formats.force_plates.c3d_plates import Plate, length_factor, plate
from ingest.formats.force_plates.c3d_sections import SGI, C3dDamagedError, C3dSections, read_sections
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
    data = head.data
    is_c3d = head.source is None and len(data) >= 512 and data[1] == 0x50 and 2 <= data[0] <= 0x20
    return Recognition(SIGNATURE, "byte 2 is 50 hex, as of a C3D file") if is_c3d else None


def _read(head: Head, findings: FindingCollector) -> Reading:
    try:
        sections = read_sections(head.data)
        points, analogs = _values(head.data, sections)
    except C3dDamagedError as damage:
        findings.add(FILE, "c3d_damaged", f"The C3D file cannot be read: {damage}; copy it again from its source.")
        return Reading()
    tables = []
    if analogs.shape[1]:
        tables.append(_analog_table(sections, analogs, findings))
    if points.shape[1]:
        tables.append(_marker_table(sections, points))
    return read_several(tables, head.declared, findings)


def _values(data: bytes, sections: C3dSections) -> tuple[FloatArray, FloatArray]:
    """Return points, shape (3, n_points, n_frames), and analog values, shape (n_samples, n_analogs)."""
    import ezc3d  # slow to load, and few files are of this format

    if sections.processor == SGI:
        data = _to_intel(data, sections)
    try:
        with tempfile.NamedTemporaryFile(suffix=".c3d") as copy:
            copy.write(data)
            copy.flush()
            found = ezc3d.c3d(copy.name)["data"]
    except Exception as error:  # whatever the library raises for a damaged file
        raise C3dDamagedError(f"ezc3d says {str(error).strip()[:120]!r}") from error
    points = np.asarray(found["points"], dtype=np.float64)
    analogs = np.asarray(found["analogs"], dtype=np.float64)
    read, wanted = analogs.shape[1:], (sections.n_analogs, sections.n_frames * sections.ratio)
    if sections.n_analogs and read != wanted:
        raise C3dDamagedError(f"of {wanted[1]} samples of {wanted[0]} analog channels {read[1]} of {read[0]} were read")
    if sections.n_points and points.shape[1:] != (sections.n_points, sections.n_frames):
        raise C3dDamagedError(f"of {sections.n_frames} frames {points.shape[2]} were read")
    return points[:3, : sections.n_points], _with_offsets(analogs[0, : sections.n_analogs].T, sections)


def _to_intel(data: bytes, sections: C3dSections) -> bytes:
    """Return the file with its numbers in the order of Intel processors."""
    turned = np.frombuffer(data, np.uint8).copy()
    for start, count, size in sections.fields:
        field = turned[start : start + count * size]
        field[:] = field.reshape(-1, size)[:, ::-1].ravel()
    turned[(data[0] - 1) * 512 + 3] = 84
    return turned.tobytes()


def _with_offsets(analogs: FloatArray, sections: C3dSections) -> FloatArray:
    """Return the values with the offsets of the file: ezc3d takes their absolute value, and every integer as signed."""
    offsets = sections.numbers("ANALOG:OFFSET")[: analogs.shape[1]]
    scales = sections.numbers("ANALOG:SCALE")[: analogs.shape[1]]
    if offsets.size < analogs.shape[1] or scales.size < analogs.shape[1]:
        return analogs
    step = scales * (sections.first("ANALOG:GEN_SCALE") or 1.0)
    unsigned = "UNSIGNED" in sections.texts("ANALOG:FORMAT")
    if unsigned and sections.fields[-1][2] == 2:
        with np.errstate(divide="ignore", invalid="ignore"):
            raw = np.rint(analogs / step + np.abs(offsets))
        analogs = analogs + np.where(raw < 0, 65536 * step, 0.0)
    true = offsets % 65536 if unsigned else offsets
    return analogs + step * (np.abs(offsets) - true) if (true != np.abs(offsets)).any() else analogs


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
    columns = [points[axis, number] * length_factor(sections) for number in range(len(labels)) for axis in range(3)]
    names = [f"{label} {axis}" for label in labels for axis in "xyz"]
    table = array_table(
        names, ["m"] * len(names), columns, Preamble(sections.point_rate_hz or None, None, "POINT:RATE")
    )
    return NamedTable(table, Instrument("markers", evidence="the C3D standard"))


def _padded(texts: tuple[str, ...], count: int, word: str) -> list[str]:
    """Return a text for each of `count` channels; those without one are numbered."""
    given = [*texts[:count], *[""] * (count - len(texts))]
    return [text or (f"{word} {number}" if word else "") for number, text in enumerate(given, start=1)]


FORMAT = Format("c3d", 1, _recognise, _read)
