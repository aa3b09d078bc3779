"""`labbook channels`: what a column may hold."""

from labbook.cli.common import JsonOption, columns, emit


def channels(as_json: JsonOption = False) -> None:
    """List what a column of a log or of a charger sheet can be declared as, with unit and meaning.

    Units are those that values are stored in; a file's own unit is declared with the column and converted.

    Example: labbook channels
    """
    from data_schema.vocabulary import CHANNELS
    from labbook.config.channels import DATE, OWN, SHEET_COLUMNS, TIME

    of_log = {
        **{name: (kind.unit, kind.meaning) for name, kind in CHANNELS.items()},
        TIME: ("s", "the time column"),
        DATE: ("-", "the dates beside a column of times of day"),
        f"{OWN}NAME": ("any", "a quantity of your own, kept as NAME; it feeds no result"),
    }
    rows = [(name, unit, meaning) for name, (unit, meaning) in of_log.items()]
    sheet = list(SHEET_COLUMNS.items())
    data = [
        *({"of": "log", "name": name, "unit": unit, "meaning": meaning} for name, unit, meaning in rows),
        *({"of": "charger sheet", "name": name, "unit": None, "meaning": meaning} for name, meaning in sheet),
    ]
    lines = [
        *columns(("channel", "unit", "meaning"), rows),
        *columns(("charger sheet", "meaning"), sheet),
        "A second plate's forces, moments and centres of pressure have the ending _2, a third's _3.",
        'On the command line: `labbook ingest FILE --column "COLUMN=CHANNEL:UNIT"`; in labbook.toml: [profiles.NAME].',
    ]
    emit(data, lines, as_json)
