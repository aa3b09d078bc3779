"""The studies by name: a new one is a line here, and a file of `labbook/studies`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from data_schema.vocabulary import StudyKind


@dataclass(frozen=True, slots=True)
class StudyEntry:
    """What a study is made of: a sheet of a format, with such a header, or the runs of a book of some kind.

    `own_keys` are those that its table in labbook.toml has beside those of all such studies: fields of `StudyProtocol`.
    `help` is that of its command, with an example, where the command has no options of its own.
    """

    sheet: str = ""
    header: str = ""
    runs: StudyKind | None = None
    own_keys: tuple[str, ...] = ()
    help: str = ""

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of its table in labbook.toml."""
        return (*self.own_keys, *(("sheet", "decimal") if self.sheet else ("where",)), "level")


STUDIES: Mapping[str, StudyEntry] = {
    "force-plate": StudyEntry(runs=StudyKind.FORCE_PLATE, own_keys=("window",)),
    "characterisation": StudyEntry("trial_sheet", "file,gain,damping_gain,mass_kg"),
    "emulator": StudyEntry(runs=StudyKind.EMULATOR, own_keys=("constant", "ratio", "same_percent")),
    "bed": StudyEntry(
        runs=StudyKind.BED,
        help="""Compare active damping with compression-extension on the granular bed: energy and apex heights by foot
    and gain.

    As the report does, by the days that both sides share, with its intervals; beside each p that of the thesis's route
    over runs, and the thesis's (5.2). Where the book has a sheet of flasks, how densely the grains lie is said too.

    Example: labbook study bed --where "foot=small" --plot bed.pdf
    """,
    ),
    "compaction": StudyEntry("flask_sheet", "radius_mm,state,water_ml", own_keys=("grain_mm",)),
    "field": StudyEntry("walk_sheet", "walk,robot,mass_kg,distance_m,energy_Wh"),
}
"""In the order of the thesis (3.2.2, 4.2.6, 4.3, 5.2, 5.1.2, 2.2.3)."""
