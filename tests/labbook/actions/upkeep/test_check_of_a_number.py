"""`why ID --check` ends with 3 wherever a fact that the number rests on was altered, and with 0 where another was."""

from __future__ import annotations

import contextlib
import sqlite3

import pytest
import sqlalchemy as sa

from data_schema.queries.history import list_reports
from labbook.book.altered import altered_rows, inputs_altered
from labbook.book.replaying import replayed
from labbook.book.report_numbers import read_numbers
from tests.cli.shell import labbook
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

OF_JOULES = (
    "UPDATE charge SET charge_mah = charge_mah + 1 WHERE uid IN ({leaves})",
    "UPDATE charge SET resolution_mah = 9 WHERE uid IN ({leaves})",
    "UPDATE run SET jumps_made = jumps_made + 1 WHERE uid IN ({leaves})",
    "UPDATE run SET state = 'void' WHERE uid IN ({leaves})",
    "UPDATE day SET date_local = '2021-06-15' WHERE id = 1",
    "UPDATE level SET value = value + 1 WHERE value IS NOT NULL",
    "UPDATE condition SET is_control = 1 - is_control",
    "UPDATE study SET reference_voltage_v = reference_voltage_v + 1",
    "UPDATE config SET text = text || ' '",
    "UPDATE battery SET cells = cells + 1",
    "UPDATE robot SET body_mass_kg = body_mass_kg + 1",
    "DELETE FROM charge WHERE uid = (SELECT min(uid) FROM charge WHERE uid IN ({leaves}))",
)
OF_HEIGHTS = (
    "UPDATE decision SET verdict = 'accept' WHERE uid IN ({leaves}) AND verdict <> 'accept'",
    "DELETE FROM decision WHERE uid IN ({leaves})",
    "UPDATE signal SET rate_hz = 2 * rate_hz WHERE sha256 IN ({leaves})",
    "UPDATE channel SET scale = 2 * scale WHERE signal IN (SELECT id FROM signal WHERE sha256 IN ({leaves}))",
    "UPDATE jump SET apex_height_m = 2 * apex_height_m WHERE apex_height_m IS NOT NULL",
    "UPDATE run_file SET part = 'other' WHERE run IN (SELECT id FROM run WHERE uid IN ({leaves}))",
)
OF_NO_NUMBER = ("UPDATE person SET initials = 'XX' WHERE name LIKE 'Ben%'",)


def number_of(book: SmallBook, kind: str) -> tuple[str, set[str]]:
    """The number of the first report that rests on most, this kind too, and the uids and hashes at its bottom."""
    with book.open() as opened, opened.reading() as connection:
        numbers = read_numbers(opened.store.root, list_reports(connection)[0])
    leaves = {number.id: numbers.leaves_of(number) for number in numbers.numbers.values()}
    resting = {uid for uid, of in leaves.items() if kind in [leaf.input_kind for leaf in of]}
    found = max(sorted(resting), key=lambda uid: len(leaves[uid]))
    return found, {leaf.input_uid for leaf in leaves[found]}


@pytest.mark.parametrize(("kind", "statements"), [("charge", OF_JOULES), ("decision", OF_HEIGHTS)])
def test_every_fact_behind_a_number_is_found_to_be(whole: SmallBook, kind: str, statements: tuple[str, ...]) -> None:
    _number, leaves = number_of(whole, kind)
    listed = ", ".join(f"'{uid}'" for uid in leaves)
    engine = sa.create_engine(f"sqlite:///{whole.database}")
    with (
        whole.open() as book,
        replayed(book.store, book.mirror, 10**6, lambda _step: None, use_cache=True) as (replay, _record),
        replay.connect() as fresh,
        engine.connect() as connection,
    ):
        connection.exec_driver_sql("PRAGMA ignore_check_constraints = 1")
        for statement in (*statements, *OF_NO_NUMBER):
            assert connection.exec_driver_sql(statement.format(leaves=listed)).rowcount > 0, statement
            found = inputs_altered(connection, fresh, altered_rows(connection, fresh))
            connection.rollback()
            assert found
            bears = any(inputs is None or inputs & leaves for inputs in found)
            assert bears is (statement in statements), statement
    engine.dispose()


@pytest.mark.parametrize(
    ("statement", "code"),
    [
        ("UPDATE robot SET rest_length_m = rest_length_m + 0.001", 3),
        ("UPDATE config SET text = replace(text, '15.4', '16.8')", 3),
        ("UPDATE person SET initials = 'XX' WHERE name LIKE 'Ben%'", 0),
    ],
)
def test_the_command_says_so(whole: SmallBook, statement: str, code: int) -> None:
    number, _leaves = number_of(whole, "charge")
    with contextlib.closing(sqlite3.connect(whole.database)) as connection, connection:
        assert connection.execute(statement).rowcount > 0
    answer = labbook("why", number, "--check", at=whole.folder)
    assert answer.code == code
    says(answer.out, number)


def test_a_number_of_an_emptied_journal_is_not_said_to_be_unknown(whole: SmallBook) -> None:
    number, _leaves = number_of(whole, "charge")
    with contextlib.closing(sqlite3.connect(whole.database)) as connection, connection:
        connection.execute("DROP TRIGGER journal_never_deleted")
        connection.execute("DELETE FROM journal")
    assert labbook("why", number, "--check", at=whole.folder).code == 3
