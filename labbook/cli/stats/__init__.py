"""`labbook stats`: the statistics of the reports on any table, or on the book; its commands, one file each."""

import typer

from labbook.cli.stats import anova, blocked, compare, equivalence, power, savings

app = typer.Typer(no_args_is_help=True)

for module in (compare, anova, savings, equivalence, blocked, power):
    module.register(app)
