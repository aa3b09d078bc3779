"""`labbook channels`: what a column may hold."""

import typer

from labbook.cli.common import JsonOption, columns, emit


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("channels")(channels)


def channels(as_json: JsonOption = False) -> None:
    """List the channels that a column of a log can be declared as, with unit and meaning.

    Units are those that values are stored in; a file's own unit is declared with the column and converted.

    Example: labbook channels
    """
    from data_schema.vocabulary import CHANNELS
    from labbook.config.channels import OWN, TIME

    known = [{"name": name, "unit": kind.unit, "meaning": kind.meaning} for name, kind in CHANNELS.items()]
    known.append({"name": TIME, "unit": "s", "meaning": "the time column"})
    own = {"name": f"{OWN}NAME", "unit": "any", "meaning": "a quantity of your own, kept as NAME; it feeds no result"}
    rows = [(row["name"], row["unit"], row["meaning"]) for row in (*known, own)]
    lines = [
        *columns(("channel", "unit", "meaning"), rows),
        "A second plate's forces, moments and centres of pressure have the ending _2, a third's _3.",
        'On the command line: `labbook ingest FILE --column "COLUMN=CHANNEL:UNIT"`; in labbook.toml: [profiles.NAME].',
    ]
    emit([*known, own], lines, as_json)
