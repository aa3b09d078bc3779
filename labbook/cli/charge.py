"""`labbook charge`: what the charger's display said, typed in."""

from typing import Annotated

import typer

from labbook.cli.common import AsOption, BookOption, JsonOption, emit


def charge(
    run: Annotated[str, typer.Argument(help="The run after which the pack was charged.")],
    charge_mah: Annotated[
        float, typer.Argument(metavar="MAH", help="What the charger put back, in mAh: 0 or more, without a sign.")
    ],
    minutes: Annotated[float | None, typer.Option("--minutes", help="How long charging took.")] = None,
    end_voltage: Annotated[
        float | None, typer.Option("--end-voltage", help="The pack's voltage at the end, V.")
    ] = None,
    book: BookOption = None,
    person: AsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Type in one charge, where nobody keeps a sheet.

    Example: labbook charge r017 128 --minutes 14 --end-voltage 15.4
    """
    from labbook.actions.runs.charges import state_charge
    from labbook.actions.runs.remarks import remark_lines, remarks_on
    from labbook.actions.upkeep.stale import stale_lines
    from labbook.book.opening import opened

    with opened(book) as opened_book, opened_book.session(person) as session:
        uid = state_charge(session, opened_book.configuration, run, charge_mah, minutes, end_voltage)
        remarks = remarks_on(session.connection, opened_book.configuration, [run], ["charge_mah"])
        stale = session.stale
    emit(
        {"run": run, "charge": uid, "charge_mah": charge_mah, "stale": stale, "remarks": remarks},
        [
            f"run {run}: {charge_mah:g} mAh (charge:{uid}).",
            *(stale_lines(stale) if stale else ()),
            *remark_lines(remarks),
        ],
        as_json,
    )
