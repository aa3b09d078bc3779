"""Commands that state what a person knows: note, charge, check, correct, void, assign."""

from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, RunArgument, opened, stating, tell
from labbook.terminal import Shown


def note(
    run: RunArgument,
    text: Annotated[str, typer.Argument(help="What is to be remembered.")],
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Write a note on a run.

    Example: labbook note r017 "left rail squeaked"
    """
    from data_schema.errors import UsageError
    from data_schema.vocabulary import Action
    from labbook.book.naming import run_named
    from labbook.book.write_session import Statement, new_uid

    if not text.strip():
        raise UsageError("the note is empty: say what is to be remembered.")
    with stating(book, person) as (_opened_book, session):
        target = run_named(session.connection, run)
        new = {"target_kind": "run", "target_uid": target.uid, "text": text}
        session.state(Statement(Action.NOTE, "note", new_uid(), new=new))
    return tell({"run": run, "text": text}, [f"noted on run {run}."])


def charge(
    run: Annotated[str, typer.Argument(help="The run after which the pack was charged.")],
    charge_mah: Annotated[
        float, typer.Argument(metavar="MAH", help="What the charger put back, in mAh: 0 or more, without a sign.")
    ],
    minutes: Annotated[float | None, typer.Option(help="How long charging took.")] = None,
    end_voltage: Annotated[float | None, typer.Option(help="The pack's voltage at the end, V.")] = None,
    add: Annotated[bool, typer.Option("--add", help="One more part of the run's charge: the sum counts.")] = False,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Type in one charge, where nobody keeps a sheet.

    Example: labbook charge r017 128 --minutes 14 --end-voltage 15.4
    """
    from labbook.actions.runs.correcting import state_charge
    from labbook.actions.runs.remarks import remarks_on
    from labbook.actions.runs.rig_line import rig_lines_of_runs
    from labbook.book.report_numbers import outdated_reports

    with opened(book) as opened_book:
        with opened_book.session(person) as session:
            uid = state_charge(session, opened_book.configuration, run, charge_mah, minutes, end_voltage, add=add)
            remarks = remarks_on(session.connection, opened_book.configuration, [run], ["charge_mah"])
            reports = outdated_reports(session)
        rig = [line.text for line in rig_lines_of_runs(opened_book, [run])]
    data = {"run": run, "charge": uid, "charge_mah": charge_mah, "rig": rig, "reports": reports, "remarks": remarks}
    return tell(data, [f"run {run}: {charge_mah:g} mAh{' more' if add else ''} (charge:{uid})."])


def check(
    kind: Annotated[str, typer.Argument(help="A check that [protocol] checks of labbook.toml lists.")],
    value: Annotated[float | None, typer.Option(help="What was measured.")] = None,
    unit: Annotated[str | None, typer.Option(help="Its unit.")] = None,
    failed: Annotated[bool, typer.Option("--failed", help="The check was made and did not pass.")] = False,
    day: Annotated[str | None, typer.Option(metavar="DATE", help="Another day, as 2021-06-01.")] = None,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Record a check made before the day's first run, one of those that `checks` of [protocol] lists.

    Example: labbook check rail_angle --value 0.4 --unit deg
    """
    from labbook.actions.runs.correcting import state_check

    with stating(book, person) as (opened_book, session):
        date = state_check(session, opened_book.configuration, kind, value, unit, not failed, day)
    data = {"day": date, "kind": kind, "passed": not failed}
    return tell(data, [f"{date}: {kind} {'did not pass' if failed else 'passed'}."])


def correct(
    target: Annotated[str, typer.Argument(help="A run, or study, robot:NAME, battery:NAME, charge:UID.")],
    fields: Annotated[list[str], typer.Argument(metavar="FIELD=VALUE...", help="What it should say.")],
    why: Annotated[str, typer.Option("--why", "--reason", help="Why the old value was wrong.")],
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Correct a fact: the old value stays in the journal, and reports with numbers that depend on it are named.

    The words of the run sheet stand beside the columns' names: started=09:20 date=2021-06-05 minutes=12 jumps=24
    position=3 run=NEWNAME, the factors, and mah=812 for the charge of a run. A new date takes the start along.

    A run that was idle: kind=idle jumps_made=0 levels=none in one command, for an idle run has neither.

    Example: labbook correct r017 foot=large --why "typed wrong"
    """
    from data_schema.queries.charges import waiting_charges
    from labbook.actions.runs.correcting import correct as state_correction
    from labbook.actions.runs.correcting import known_now, runs_corrected
    from labbook.actions.runs.remarks import remarks_on
    from labbook.actions.runs.rig_line import OF_JOULES, rig_lines_of_runs
    from labbook.book.naming import changes_in_words
    from labbook.book.report_numbers import outdated_reports
    from labbook.config.places import toml_changes

    with opened(book) as opened_book:
        configuration = opened_book.configuration
        with opened_book.session(person, correcting=True) as session:
            waiting = waiting_charges(session.connection)
            changed = state_correction(opened_book, session, target, fields, why)
            shown = {name: values for name, values in changed.items() if name != "planned_run"}
            old, new = ({name: values[place] for name, values in shown.items()} for place in (0, 1))
            words = changes_in_words(session.connection, old, new)
            runs = runs_corrected(session.connection, target, changed)
            remarks = remarks_on(session.connection, configuration, runs, changed)
            settled = known_now(session.connection, waiting)
            reports = outdated_reports(session)
        about = runs if OF_JOULES & changed.keys() else ()
        rig = [line.text for line in rig_lines_of_runs(opened_book, about, jumps="jumps_made" in changed)]
    data = {"changed": changed, "remarks": remarks, "settled": settled, "reports": reports, "rig": rig}
    in_file = toml_changes(configuration, target, {name: new for name, (_old, new) in changed.items()})
    said = [f"{target}: {', '.join(fields)}.", f"changed: {words}."]
    lines = [
        *(said if changed else [f"{target} says that already: nothing was changed."]),
        *in_file,
        *(f"{row} waited and says so too: it waits no more." for row in settled),
    ]
    return tell({"target": target, **data, "labbook_toml": in_file}, lines)


def void(
    run: RunArgument,
    reason: Annotated[
        str, typer.Option("--reason", "--why", help="Why it does not count, or with --undo why it does.")
    ],
    undo: Annotated[bool, typer.Option("--undo", help="The run counts after all.")] = False,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Declare a run void: it stays in the book with its files, no result uses it, reports count it.

    Where [analysis] of labbook.toml says for which reasons, begin with one of them: "sensor_fault: the string was off".

    A run that is void already stays so, and nothing is stated a second time.

    Example: labbook void r017 --reason "foot came loose"; labbook void r017 --undo --reason "it was r018"
    """
    from labbook.actions.runs.correcting import other_reason, unvoid
    from labbook.actions.runs.correcting import void as state_void
    from labbook.actions.runs.jump_review import reason_remarks
    from labbook.book.report_numbers import outdated_reports

    with stating(book, person) as (opened_book, session):
        change = (unvoid if undo else state_void)(session, run, reason)
        reports = outdated_reports(session)
        remarks = []
        if change.made and not undo:
            remedy = f"If one of these is meant, {other_reason(run)}."
            remarks = reason_remarks(session.connection, opened_book.configuration, reason, remedy=remedy)
    return tell({"run": run, "reports": reports, "remarks": remarks}, [f"{change.text}."])


def assign(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="Files by name or uid; NAME#ROW or NAME#PART for a part of one."),
    ],
    run: Annotated[str, typer.Argument(help="The run they belong to; none takes them off their run.")],
    why: Annotated[
        str | None, typer.Option("--why", "--reason", help="Why, where it belonged to a run before.")
    ] = None,
    add: Annotated[
        bool,
        typer.Option("--add", help="A row of a charger sheet is one more part of the run's charge: the sum counts."),
    ] = False,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Say to which run files, or rows of a charger sheet, belong; no result uses them before.

    NAME#ROW is one row of a charger sheet, NAME#PART one of several runs in a file (`labbook files show NAME`).

    Example: labbook assign log_0007.csv r007; labbook assign charges.csv#3 none --why "read a line too low"
    """
    from labbook.actions.files.assigning import NO_RUN
    from labbook.actions.files.assigning import assign as state_assignment
    from labbook.actions.runs.remarks import remarks_on
    from labbook.actions.runs.rig_line import rig_lines_of_runs
    from labbook.book.report_numbers import outdated_reports

    runs = [] if run == NO_RUN else [run]
    with opened(book) as opened_book:
        with opened_book.session(person) as session:
            said = [state_assignment(session, file, run, why, add=add) for file in files]
            reports = outdated_reports(session)
            remarks = remarks_on(session.connection, opened_book.configuration, runs, ["log"])
        rig = [line.text for line in rig_lines_of_runs(opened_book, runs, jumps=True)]
    data = {"files": files, "run": None if run == NO_RUN else run, "said": said, "rig": rig, "reports": reports}
    return tell({**data, "remarks": remarks}, said)
