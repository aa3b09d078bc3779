"""The command `labbook`: its commands, one file each, and how errors become sentences and exit codes."""

from __future__ import annotations

import json
import sys

import typer

from data_schema.errors import LabbookError
from labbook.cli import (
    assign,
    charge,
    check,
    correct,
    db,
    demo,
    ingest,
    init,
    jumps,
    note,
    plan,
    plot,
    rebuild,
    report,
    runs,
    show,
    today,
    void,
    why,
)

app = typer.Typer(
    name="labbook",
    help="The lab notebook of a robotics lab that counts: raw instrument files in, a traceable report out.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

for module in (
    init,
    ingest,
    report,
    plan,
    today,
    show,
    plot,
    note,
    charge,
    check,
    correct,
    void,
    assign,
    why,
    demo,
    rebuild,
):
    module.register(app)
for name, group in (("runs", runs), ("jumps", jumps), ("db", db)):
    app.add_typer(group.app, name=name)


def run() -> None:
    """Run the command line: a `LabbookError` becomes its sentence and exit code, `--debug` shows where it arose."""
    debug = "--debug" in sys.argv
    arguments = [argument for argument in sys.argv[1:] if argument != "--debug"]
    try:
        app(arguments)
    except LabbookError as error:
        if debug:
            raise
        if "--json" in arguments:
            typer.echo(json.dumps({"error": str(error), "exit_code": error.exit_code}, ensure_ascii=False))
        typer.echo(f"labbook: {error}", err=True)
        sys.exit(error.exit_code)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(0)
    except OSError as error:
        if debug:
            raise
        where = f" {error.filename}" if error.filename else ""
        typer.echo(
            f"labbook: {error.strerror or error}{where}: check the path, its permissions and the disk.", err=True
        )
        sys.exit(2)
