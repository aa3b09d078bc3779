"""What is looked through: all runs with the plan's progress, two runs beside each other, files, the journal."""

from __future__ import annotations

import msgspec
from starlette.responses import Response

from data_schema.errors import UsageError
from data_schema.queries.files import newest_files, refused_files
from data_schema.queries.study import planned_runs
from labbook.actions.files.stored_files import list_files, show_file, show_lines
from labbook.actions.runs.run_view import compare_runs, difference_rows, overview, run_view
from labbook.actions.upkeep.journal_view import newest_commands
from labbook.web.rendering import Asked, view

_MOST_COMMANDS, _MOST_FILES, _MOST_REFUSED = 100, 200, 12


def _runs(asked: Asked) -> Response:
    """Return all runs, which the page sorts and filters."""
    configuration, connection = asked.book.configuration, asked.connection
    planned, newest = planned_runs(connection), newest_files(connection, 1)
    found = {
        "runs": overview(connection, asked.book.store, configuration, asked.given("where")),
        "factors": [
            {"name": name, "title": factor.title or name, "levels": [level.label for level in factor.levels]}
            for name, factor in configuration.factors.items()
        ],
        "last_in": {"name": newest[0].name, "at": asked.local(newest[0].at_utc)} if newest else None,
        "planned": len(planned),
        "planned_made": sum(row.run_name is not None for row in planned),
    }
    return Response(msgspec.json.encode(found), media_type="application/json")


def _two_runs(asked: Asked) -> Response:
    names = [(asked.given(which) or "").strip() for which in ("first", "second")]
    if not all(names):
        raise UsageError("two runs are compared: give the names of both.")
    first, second = (run_view(asked.detections, asked.book.configuration, name) for name in names)
    found = compare_runs(first, second)
    return asked.page(
        "run_diff.html.j2",
        "runs",
        first=found.first,
        second=found.second,
        rows=difference_rows(found, first.time_zone),
        both=all(isinstance(one.jumps_found, int) for one in (first, second)),
    )


def _files(asked: Asked) -> Response:
    number = asked.number("page") or 1
    every = list_files(asked.connection)[::-1]
    refused = refused_files(asked.connection, _MOST_REFUSED) if number == 1 else []
    shown = every[_MOST_FILES * (number - 1) : _MOST_FILES * number]
    return asked.page(
        "files.html.j2",
        "files",
        files=[(one, asked.local(one.reading.at_utc)) for one in shown],
        refused=[(one, asked.local(one.at_utc)) for one in refused],
        count=len(every),
        number=number,
        more=len(every) > _MOST_FILES * number,
    )


def _file(asked: Asked) -> Response:
    found = show_file(asked.connection, asked.path("uid"))
    lines = [line.removeprefix("  ") for line in show_lines(found)[1:]]
    return asked.page("file.html.j2", "files", file=found, lines=lines)


def _journal(asked: Asked) -> Response:
    found = newest_commands(asked.connection, _MOST_COMMANDS, asked.number("before"))
    older = found[-1].first if found and found[-1].first > 1 else None
    commands = [(one, asked.local(one.at_utc)) for one in found]
    return asked.page("journal.html.j2", "journal", commands=commands, older=older)


ROUTES = [
    view("/", lambda asked: asked.page("overview.html.j2", "runs")),
    view("/api/runs", _runs),
    view("/diff", _two_runs),
    view("/files", _files),
    view("/files/{uid}", _file),
    view("/journal", _journal),
]
