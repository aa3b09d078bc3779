"""`labbook sim parts`: what scenes are made of."""

from typing import Annotated

import typer

from labbook.cli.common import JsonOption, columns, emit


def parts(
    name: Annotated[
        str | None, typer.Argument(help="An effect, a parameter or a word; without it, all of them.")
    ] = None,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Print the tables as Markdown, as docs/scenes.md has them.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """List what scenes are made of: effects, parameters with unit and range, and words that --set takes beside them.

    Of one effect: what it needs, what it excludes and why, what it reads, which shipped scenes have it. Of one
    parameter: its unit and range, which effects read it, and its value and source in the shipped scenes.

    Example: labbook sim parts k_extension
    """
    from labbook.presenting.simulation.scene_parts import (
        part_data,
        part_lines,
        parts_data,
        parts_markdown,
        parts_rows,
        parts_tables,
    )

    if name is not None:
        emit(part_data(name), part_lines(name), as_json)
        return
    lines = parts_markdown().splitlines()
    if not markdown:
        tables = parts_tables().values()
        lines = [line for table in tables for line in (table.caption, "", *columns(*_headed(parts_rows(table))), "")]
        lines.append("labbook sim parts NAME says more of one of them.")
    emit(parts_data(), lines, as_json)


def _headed(rows: list[list[str]]) -> tuple[list[str], list[list[str]]]:
    return rows[0], rows[1:]
