"""Bad text: decimal signs, missing-value spellings, quotes, headers, delimiters; all files are synthetic."""

from __future__ import annotations

import pytest

from tests.ingest.bad_input import LOG, ROWS, Case, check, check_one_row_lost, with_cell, with_row
from tests.ingest.synthetic import LOG_HEADER, text

TEXT = [
    Case("decimal comma with semicolons", LOG.replace(b",", b";").replace(b".", b","), False, "decimal_comma", 600),
    Case(
        "decimal comma with commas",
        (LOG_HEADER + "\n").encode() + "\n".join(ROWS).replace(".", ",").encode(),
        True,
        "decimal_comma_unquoted",
    ),
    Case(
        "quoted decimal comma",
        text(
            LOG_HEADER, [",".join(f'"{c}"' for c in row.replace(".", ";").split(",")).replace(";", ",") for row in ROWS]
        ),
        False,
        "decimal_comma",
        600,
    ),
    Case("decimal comma once among points", with_cell('"0,42"'), False, "decimal_sign_mixed", 599),
    Case("thousands separator once", with_cell('"1,234.5"', 3), False, "thousands_separator", 599),
    Case(
        "thousands in a column",
        text("time [ms];counts", [f"{n};1.234,5" for n in range(300)]),
        True,
        "thousands_separator",
        0,
    ),
    Case(
        "decimal or thousand",
        text("time [ms];counts", [f"{n};1,234" for n in range(300)]),
        True,
        "decimal_sign_unclear",
    ),
    Case(
        "decimal point or thousand",
        text("time [ms];counts", [f"{n};1.234" for n in range(300)]),
        False,
        "decimal_point_unclear",
        300,
    ),
    Case("Arabic digits", with_cell("٠٫٥"), False, "not_a_number", 599),
    Case("underscore in a number", with_cell("4_0", 3), False, "not_a_number", 599),
    Case("hexadecimal", with_cell("0x10", 3), False, "not_a_number", 599),
    Case(
        "quoted cell with a newline",
        text(LOG_HEADER + ",note", [f'{row},"a\nb"' for row in ROWS]),
        False,
        "text_column",
        600,
    ),
    Case("unbalanced quote", with_row('166,"0.42,0.2,400'), False, "quote_unbalanced", 599),
    Case(
        "unbalanced quotes in two rows",
        text(LOG_HEADER, [f'"{row}' if n in (50, 52) else row for n, row in enumerate(ROWS)]),
        False,
        "quote_unbalanced",
        598,
    ),
    Case("header again inside", with_row(LOG_HEADER), False, "header_repeated", 599),
    Case(
        "header on every page",
        text(
            LOG_HEADER, [line for n, row in enumerate(ROWS) for line in ([LOG_HEADER, row] if n % 50 == 0 else [row])]
        ),
        False,
        "header_repeated",
        600,
    ),
    Case("two recordings appended", LOG + LOG, False, "header_repeated time_restarted", 1200),
    Case("duplicate column names", LOG.replace(b"k_gain", b"height [m]"), False, "duplicate_column", 600),
    Case("trailing delimiter", text(LOG_HEADER + ",", [row + "," for row in ROWS]), False, "", 600),
    Case("trailing delimiter in the data only", text(LOG_HEADER, [row + "," for row in ROWS]), False, "", 600),
    Case("ragged row, short", with_row("1,2"), False, "ragged_row", 599),
    Case("ragged row, long", with_row(ROWS[50] + ",7"), False, "ragged_row", 599),
    Case(
        "all rows longer than the header",
        text(LOG_HEADER, [row + ",7,8,9,10,11" for row in ROWS]),
        True,
        "header_mismatch",
    ),
    Case("no header", text(ROWS[0], ROWS[1:]), True, "header_missing"),
    Case("units row", text("time,height,leg_length,k_gain\nms,m,m,-", ROWS), False, "", 600),
    Case("units row missing", text("time,height,leg_length,k_gain", ROWS), True, "time_unit_missing unit_missing"),
    Case(
        "units row again",
        text("time,height,leg_length,k_gain\nms,m,m,-", [*ROWS[:9], "ms,m,m,-", *ROWS[9:]]),
        False,
        "units_repeated",
        600,
    ),
    Case("header behind a comment sign", b"#" + LOG, False, "", 600),
    Case("comments above", b"# string pot, left rail\n% second\n" + LOG, False, "", 600),
    Case("comment inside", with_row("# foot changed"), False, "comment_line", 599),
    Case("blank lines", LOG.replace(b"\n", b"\n\n"), False, "", 600),
    Case("localised name", LOG.replace(b"height [m]", "Höhe [m]".encode()), False, "unknown_column", 600),
    Case("formula as a column name", LOG.replace(b"k_gain", b"=cmd|'/c calc'!A0"), False, "unknown_column", 600),
    Case("formula in a cell", with_cell("=1+1", 3), False, "not_a_number", 599),
    Case(
        "markup in a text column",
        text(LOG_HEADER + ",note", [row + ",<script>alert(1)</script>" for row in ROWS]),
        False,
        "text_column",
        600,
    ),
    Case("empty column", text(LOG_HEADER + ",spare,more", [row + ",,1" for row in ROWS]), False, "empty_column", 600),
    *(
        Case(f"missing: {word or 'blank'}", with_cell(word), False, "value_missing", 600)
        for word in ("NaN", "nan", "-nan(ind)", "1.#QNAN", "N/A", "-", "", "  ", "null")
    ),
    *(Case(f"infinite: {word}", with_cell(word), False, "not_finite", 599) for word in ("1.#INF", "-inf", "1e999")),
    *(Case(f"no number: {word}", with_cell(word), False, "not_a_number", 599) for word in ("ERROR", "#DIV/0!", "err")),
    *(
        Case(f"number: {word}", with_cell(word), False, "", 600)
        for word in ("1e-1", "+.5", "-0.0", ".5", "5.", " 0.5 ", "5E-1")
    ),
    *(
        Case(f"separator {name}", LOG.replace(b",", sign), False, "", 600)
        for name, sign in (("tab", b"\t"), ("bar", b"|"), ("padded comma", b",   "), ("semicolon", b";"))
    ),
    Case("separator blanks", LOG.replace(b",", b"  ").replace(b" [", b"["), False, "", 600),
]


@pytest.mark.parametrize("case", TEXT, ids=lambda case: case.name)
def test_bad_text_has_its_outcome(case: Case) -> None:
    check(case)


SKIPPED = ("header again inside", "comment inside")


@pytest.mark.parametrize("case", [case for case in TEXT if case.kept == 599], ids=lambda case: case.name)
def test_a_row_that_is_left_out_is_a_gap(case: Case) -> None:
    check_one_row_lost(case, "dropped" if case.name in SKIPPED else "rejected")
