"""`labbook sim`: the simulator; its commands, one file each. It needs no book."""

import typer

from labbook.cli.common import add_commands
from labbook.cli.sim import accuracy, effects, figures, parts, published, run, sweep

app = typer.Typer(no_args_is_help=True)
add_commands(app, (run, sweep, parts, accuracy, effects, figures, published))
