"""`labbook db`: the database itself."""

from pathlib import Path

import typer

from labbook.cli.common import BookOption, JsonOption, emit

app = typer.Typer(help="The database: its revision, and upgrading it.", no_args_is_help=True)


@app.command("status")
def status_command(book: BookOption = None, as_json: JsonOption = False) -> None:
    """Show the database's revision and its rows by table.

    Example: labbook db status
    """
    from data_schema import migrations
    from data_schema.engine import reading
    from labbook.book.opening import engine_of, find_folder, read_configuration, shown
    from labbook.book.upgrading import count_rows

    folder = find_folder(book or Path.cwd())
    engine = engine_of(folder, read_configuration(folder))
    with reading(engine) as connection:
        revision = migrations.current(connection)
        rows = count_rows(connection)
    engine.dispose()
    found = {"database": shown(engine), "revision": revision, "newest": migrations.newest(), "rows": rows}
    lines = [f"{found['database']}: revision {revision}, newest {found['newest']}."]
    emit(found, [*lines, *(f"  {name}: {count}" for name, count in rows.items() if count)], as_json)


@app.command("upgrade")
def upgrade_command(book: BookOption = None, as_json: JsonOption = False) -> None:
    """Bring the database to this labbook's revision: backup first, rows counted before and after.

    Example: labbook db upgrade
    """
    from labbook.book.opening import engine_of, find_folder, read_configuration
    from labbook.book.upgrading import upgrade_database

    folder = find_folder(book or Path.cwd())
    engine = engine_of(folder, read_configuration(folder))
    try:
        done = upgrade_database(folder, engine)
    finally:
        engine.dispose()
    line = (
        f"revision {done.after} already, nothing to do."
        if done.before == done.after
        else f"upgraded from {done.before} to {done.after}; backup: {done.backup or 'yours (PostgreSQL)'}."
    )
    emit(done, [line], as_json)
