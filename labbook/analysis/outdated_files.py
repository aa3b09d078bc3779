"""Which files were read with a profile that labbook.toml has otherwise now; no file is read to tell."""

from __future__ import annotations

import json

import sqlalchemy as sa

from data_schema.queries.readings import configurations_of_readings, settings_under
from labbook.config.parsing import Configuration, parse_configuration


def outdated_files(connection: sa.Connection, configuration: Configuration) -> tuple[str, ...]:
    """Return the names of the files in use whose reading used a profile that `configuration` lacks or has otherwise."""
    found = []
    for key, text in configurations_of_readings(connection).items():
        then, now = parse_configuration(text, "the book's configuration").profiles, configuration.profiles
        changed = {name for name, profile in then.items() if profile != now.get(name)}
        if not changed:
            continue
        for file_name, settings in settings_under(connection, key):
            used = {profile["name"] for profile in json.loads(settings)["declared"]["profiles"]}
            found += [file_name] if used & changed else []
    return tuple(found)


def outdated_sentence(files: tuple[str, ...]) -> str:
    """Say how many files are outdated and what reads them again."""
    named = f"{', '.join(files[:3])}{', ...' if len(files) > 3 else ''}"
    was = "1 file was" if len(files) == 1 else f"{len(files)} files were"
    return (
        f"{was} read with a profile that labbook.toml has otherwise now ({named}), and count as they were read: "
        "`labbook files reread --all` reads them again"
    )
