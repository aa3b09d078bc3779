"""`labbook check`: the checks before a day's first run."""

from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, emit


def check(
    kind: Annotated[str, typer.Argument(help="rail_angle, lubrication, battery_conditioned or sensor_zero.")],
    value: Annotated[float | None, typer.Option("--value", help="What was measured.")] = None,
    unit: Annotated[str | None, typer.Option("--unit", help="Its unit.")] = None,
    failed: Annotated[bool, typer.Option("--failed", help="The check was made and did not pass.")] = False,
    day: Annotated[str | None, typer.Option("--day", metavar="DATE", help="Another day, as 2021-06-01.")] = None,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Record a check of the day (thesis 5.1.3): the rail's angle, lubrication, battery, sensor zero.

    Example: labbook check rail_angle --value 0.4 --unit deg
    """
    from data_schema.queries.study import checks_by_day
    from labbook.actions.runs.day_checks import state_check
    from labbook.actions.runs.remarks import remark_lines, remarks_on_check
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.session(person) as session:
        earlier = [check for checks in checks_by_day(session.connection).values() for check in checks]
        date = state_check(session, opened_book.configuration, kind, value, unit, not failed, day)
    remarks = remarks_on_check(earlier, kind, value, unit)
    emit(
        {"day": date, "kind": kind, "passed": not failed, "remarks": remarks},
        [f"{date}: {kind} {'did not pass' if failed else 'passed'}.", *remark_lines(remarks)],
        as_json,
    )
