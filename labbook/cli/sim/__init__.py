"""`labbook sim`: the simulator; its commands, one file each. It needs no book."""

import typer

from labbook.cli.sim import figures, run

app = typer.Typer(help="Simulate jumps: one scene, from robot to ground.", no_args_is_help=True)

for module in (run, figures):
    module.register(app)
