"""Logs with one thing wrong, each with its outcome: bytes, text, time and values; all files are synthetic."""

from __future__ import annotations

import gzip

import pytest

from tests.ingest.bad_input import (
    LOG,
    REFUSED,
    ROWS,
    Case,
    check,
    check_one_row_lost,
    clock,
    counting,
    with_cell,
    with_column,
    with_heights,
    with_row,
    with_times,
)
from tests.ingest.formats.test_archive import zipped
from tests.ingest.reading import read, rules
from tests.ingest.synthetic import LOG_HEADER, text

BYTES = [
    Case("0 bytes", b"", "file_empty", REFUSED),
    Case("only a byte order mark", b"\xef\xbb\xbf", "file_empty", REFUSED),
    Case("only a UTF-16 mark", b"\xff\xfe", "file_empty", REFUSED),
    Case("only blank lines", b"\n\n\r\n", "file_empty", REFUSED),
    Case("only NULs", b"\0" * 2048, "file_empty nul_padding", REFUSED),
    Case("only the header", f"{LOG_HEADER}\n".encode(), "no_data_rows", REFUSED),
    Case("header without line end", LOG_HEADER.encode(), "no_data_rows", REFUSED),
    Case("UTF-8 with mark", b"\xef\xbb\xbf" + LOG),
    Case("UTF-16 LE", b"\xff\xfe" + LOG.decode().encode("utf-16-le"), "encoding_utf16"),
    Case("UTF-16 BE", b"\xfe\xff" + LOG.decode().encode("utf-16-be"), "encoding_utf16"),
    Case("UTF-16 without mark", LOG.decode().encode("utf-16-le"), "format_unknown", REFUSED),
    Case("cp1252 degree sign", LOG.replace(b"k_gain", b"temp [\xb0C]"), "encoding_declared"),
    Case("cp1252 mu", with_times(lambda _, t: 1000 * t, "time [ms]").replace(b"ms", b"\xb5s"), "encoding_declared"),
    Case("NUL in the header", LOG.replace(b"k_gain", b"k_gain\0", 1)),
    Case("NUL run of a lost sector", LOG[:9000] + b"\0" * 512 + LOG[9512:], "nul_bytes packets_dropped", 580),
    Case("NULs at the end", LOG + b"\0" * 4096, "nul_padding"),
    Case("Ctrl-Z at the end", LOG + b"\x1a", "ctrl_z"),
    Case("Ctrl-Z line inside", with_row(ROWS[50] + "\n\x1a"), "ctrl_z"),
    Case("CRLF", LOG.replace(b"\n", b"\r\n")),
    Case("CR alone", LOG.replace(b"\n", b"\r"), "line_ends_cr"),
    Case("mixed line ends", LOG.replace(b"\n", b"\r\n", 5)),
    Case("no final newline", LOG[:-1], "no_final_newline"),
    Case("last line cut in a cell", LOG[:-3], "last_line_cut", 599),
    Case("last line cut between cells", LOG[:-15], "last_line_cut", 599),
    Case(
        "last number cut before its exponent",
        text(LOG_HEADER, [f"{row.rpartition(',')[0]},0.{at % 9}e-05" for at, row in enumerate(ROWS)])[:-9]
        + b",1.23456",
        "last_line_cut",
        599,
    ),
    Case("gzip", gzip.compress(LOG)),
    Case("gzip with a bad checksum", gzip.compress(LOG)[:-8] + bytes(8), "archive_refused", REFUSED),
    Case("zip in a zip", zipped({"inner.zip": zipped({"log.csv": LOG})}), "member_read"),
    Case("one line of 50 MB", b"1," * 25_000_000, "line_too_long", REFUSED),
    Case("a line of 2 MB inside", with_row("1," * 1_000_000), "line_too_long", 599),
    Case("100 000 columns", (",".join(map(str, range(100_000))) + "\n").encode() * 3, "too_many_columns", REFUSED),
    Case("a name of 100 kB of brackets", LOG.replace(b"k_gain", b"[(" * 50_000)),
]

NAMES = "time,height,leg_length,k_gain"
TEXT = [
    Case("decimal comma with semicolons", LOG.replace(b",", b";").replace(b".", b","), "decimal_comma"),
    Case("decimal comma with commas", LOG.replace(b".", b","), "decimal_comma_unquoted", REFUSED),
    Case("decimal comma once among points", with_cell('"0,42"'), "decimal_sign_mixed", 599),
    Case("thousands separator once", with_cell('"1,234.5"', 3), "thousands_separator", 599),
    Case("thousands in a column", counting("1.234,5"), "thousands_separator", REFUSED),
    Case("decimal or thousand", counting("1,234"), "decimal_sign_unclear", REFUSED),
    Case("decimal point or thousand", counting("1.234"), "decimal_point_unclear", 300),
    Case("Arabic digits", with_cell("٠٫٥"), "not_a_number", 599),
    Case("underscore in a number", with_cell("4_0", 3), "not_a_number", 599),
    Case("hexadecimal", with_cell("0x10", 3), "not_a_number", 599),
    Case("quoted cell with a newline", with_column("note", '"a\nb"'), "text_column"),
    Case("unbalanced quote", with_row('166,"0.42,0.2,400'), "quote_unbalanced", 599),
    Case("quotes", LOG.replace(b"\n166,", b'\n"166,').replace(b"\n173,", b'\n"173,'), "quote_unbalanced", 598),
    Case("header again inside", with_row(LOG_HEADER), "header_repeated", 599),
    Case("header on every page", LOG.replace(b"00,400\n", f"00,400\n{LOG_HEADER}\n".encode()), "header_repeated"),
    Case("two recordings appended", LOG + LOG, "header_repeated time_restarted", 1200),
    Case("duplicate column names", LOG.replace(b"k_gain", b"height [m]"), "duplicate_column"),
    Case("trailing delimiter", LOG.replace(b"\n", b",\n")),
    Case("trailing delimiter in the data only", LOG.replace(b"400\n", b"400,\n")),
    Case("ragged row, short", with_row("1,2"), "ragged_row", 599),
    Case("ragged row, long", with_row(ROWS[50] + ",7"), "ragged_row", 599),
    Case("all rows longer than the header", LOG.replace(b"400\n", b"400,7,8,9,10,11\n"), "header_mismatch", REFUSED),
    Case("no header", text(ROWS[0], ROWS[1:]), "header_missing", REFUSED),
    Case("units row", text(f"{NAMES}\nms,m,m,-", ROWS)),
    Case("units row missing", text(NAMES, ROWS), "time_unit_missing unit_missing", REFUSED),
    Case("units row again", text(f"{NAMES}\nms,m,m,-", [*ROWS[:9], "ms,m,m,-", *ROWS[9:]]), "units_repeated"),
    Case("header behind a comment sign", b"#" + LOG),
    Case("comments above", b"# string pot, left rail\n% second\n" + LOG),
    Case("comment inside", with_row("# foot changed"), "comment_line", 599),
    Case("blank lines", LOG.replace(b"\n", b"\n\n")),
    Case("localised name", LOG.replace(b"height [m]", "Höhe [m]".encode()), "unknown_column"),
    Case("formula as a column name", LOG.replace(b"k_gain", b"=cmd|'/c calc'!A0"), "unknown_column"),
    Case("formula in a cell", with_cell("=1+1", 3), "not_a_number", 599),
    Case("markup in a text column", with_column("note", "<script>alert(1)</script>"), "text_column"),
    Case("empty column", with_column("spare,more", ",1"), "empty_column"),
    *(
        Case(f"missing: {word or 'blank'}", with_cell(word), "value_missing")
        for word in ("NaN", "nan", "-nan(ind)", "1.#QNAN", "N/A", "-", "", "  ", "null")
    ),
    *(Case(f"infinite: {word}", with_cell(word), "not_finite", 599) for word in ("1.#INF", "-inf", "1e999")),
    *(Case(f"no number: {word}", with_cell(word), "not_a_number", 599) for word in ("ERROR", "#DIV/0!", "err")),
    *(Case(f"number: {word}", with_cell(word)) for word in ("1e-1", "+.5", "-0.0", ".5", "5.", " 0.5 ", "5E-1")),
    *(Case(f"separator {sign!r}", LOG.replace(b",", sign)) for sign in (b"\t", b"|", b",   ", b";")),
    Case("separator blanks", LOG.replace(b",", b"  ").replace(b" [", b"[")),
]

TIME = [
    Case("one step backwards", with_times(lambda n, t: t - 20 if n == 50 else t), "time_backwards", 599),
    Case("duplicated stamp", with_times(lambda n, t: 163 if n == 50 else t), "time_duplicate", 599),
    Case("5 % equal stamps", with_times(lambda n, _: 3 * (n - n // 20)), "arrival_times"),
    Case("missing stamp", with_times(lambda n, t: "" if n == 50 else t), "time_missing", 599),
    Case("constant", with_times(lambda *_: 5), "time_duplicate too_many_rejected", REFUSED),
    Case("spike", with_times(lambda n, t: 10**8 if n == 50 else t), "time_spike", 599),
    Case("junk first stamp", with_times(lambda n, t: 10**7 if n == 0 else t), "time_spike", 599),
    Case("jump of hours", with_times(lambda n, t: t + 7_200_000 * (n > 300)), "time_restarted"),
    Case("pause of 13 s", with_times(lambda n, t: t + 13_000 * (n > 300)), "recording_paused"),
    Case("dropped packets", text(LOG_HEADER, ROWS[:100] + ROWS[103:]), "packets_dropped", 597),
    Case("milliseconds labelled seconds", with_times(lambda _, t: t, "time [s]"), "rate_implausible", REFUSED),
    Case("unit unknown", with_times(lambda _, t: t, "time [fortnight]"), "time_unit_unknown", REFUSED),
    Case("FILETIME", with_times(lambda _, t: 133_500_000_000_000_000 + t * 10_000, "time [filetime]")),
    Case("epoch in s", with_times(lambda _, t: f"{1607954342 + t / 1000:.3f}", "time [s]")),
    Case("epoch in ms", with_times(lambda _, t: 1607954342000 + t)),
    Case("epoch in us", with_times(lambda _, t: 1607954342000000 + 1000 * t, "time [us]")),
    Case("midnight", with_times(lambda _, t: clock(86_399_000 + t), "time"), "midnight_passed"),
    Case("uint32 wrap", with_times(lambda _, t: (t + 2**32 - 1000) % 2**32), "time_wrapped"),
    Case("reboot", with_times(lambda n, t: t + 5_000_000 if n < 300 else t - 1000), "time_restarted"),
    Case("clock chaos", with_times(lambda n, _: (n % 20) * 3 + 10_000 * (n // 20 % 2)), "time_unusable", REFUSED),
    Case("rate header contradicts", b"# Rate: 1000 Hz\n" + with_times(lambda n, _: 2 * n), "rate_contradicts", REFUSED),
    Case("rate header a little off", b"# Rate: 303 Hz\n" + LOG, "rate_differs"),
    Case("start not 0", with_times(lambda _, t: t + 36_548)),
    Case("no clock", with_times(lambda _, t: f"12:00:00:{t:03d}", "time"), "time_unreadable", REFUSED),
    Case("day of the year", with_times(lambda _, t: f"2021-152T{clock(t)}", "time"), "time_unreadable", REFUSED),
    Case("no zone", with_times(lambda _, t: "2021-06-05 " + clock(52_200_000 + t), "time"), "instant_unknown"),
    Case("clock of 1980", with_times(lambda _, t: "1980-01-01T" + clock(t) + "Z", "time"), "clock_implausible"),
    Case("two time columns", LOG.replace(b"leg_length [m]", b"time [ms]"), "several_time_columns", REFUSED),
    Case("no time, no rate", text("height [m]", [row.split(",")[1] for row in ROWS]), "rate_missing", REFUSED),
    Case("nothing but time", text("time [ms]", [row.split(",")[0] for row in ROWS]), "no_channels", REFUSED),
]

SPIKES = with_heights(lambda h: 9e9 if int(1e6 * h) % 50 == 0 else h)
STUCK = text(LOG_HEADER, [f"{3 * n},{ROWS[100 if 100 <= n < 140 else n].split(',', 1)[1]}" for n in range(600)])
HELD = text(LOG_HEADER, [f"{3 * n},{ROWS[n - n % 4].split(',')[1]},{row[-12:]}" for n, row in enumerate(ROWS)])
VALUES = [
    Case("cm labelled m", with_heights(lambda h: f"{100 * h:.4f}"), "out_of_range", REFUSED),
    Case("mm labelled m", with_heights(lambda h: f"{1000 * h:.3f}"), "out_of_range", REFUSED),
    Case("mV labelled V", with_heights(lambda h: 16_000 + h, "battery [V]"), "out_of_range", REFUSED),
    Case("mAh labelled Ah", b"run,charge [Ah]\nr001,812\nr002,790\n", "out_of_range", REFUSED),
    Case("inches", with_heights(lambda h: f"{h / 0.0254:.5f}", "height [in]")),
    Case("a mass as a height", with_heights(lambda h: h, "height [kg]"), "unit_not_convertible", REFUSED),
    Case("spike of 1e35", with_cell("2.2e35"), "out_of_range", 599),
    Case("spikes in 2 % of rows", SPIKES, "out_of_range too_many_rejected", REFUSED),
    Case("flat tops", with_heights(lambda h: min(h, 0.45)), "channel_clipped"),
    Case("dead sensor", with_heights(lambda _: 0), "channel_constant"),
    Case("sensor slower than the log", HELD, "channel_held"),
]

CASES = [*BYTES, *TEXT, *TIME, *VALUES]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_bad_file_has_its_outcome(case: Case) -> None:
    check(case)


SKIPPED = ("header again inside", "comment inside")


@pytest.mark.parametrize("case", [case for case in [*TEXT, *VALUES] if case.kept == 599], ids=lambda case: case.name)
def test_a_row_that_is_left_out_is_a_gap(case: Case) -> None:
    check_one_row_lost(case, "dropped" if case.name in SKIPPED else "rejected")


@pytest.mark.parametrize("case", [case for case in TIME if case.name.startswith(("epoch", "FILETIME"))])
def test_an_epoch_gives_the_instant_and_the_same_axis(case: Case) -> None:
    (part,), (clean,) = read(case.data).parts, read(LOG).parts
    instant = "2024-01-17T21:20:00.000000Z" if case.name == "FILETIME" else "2020-12-14T13:59:02.000000Z"
    assert part.start_utc == instant
    assert part.time_s == pytest.approx(clean.time_s, abs=1e-6)


def test_repeated_packets_are_a_held_gap() -> None:
    result = read(STUCK)
    assert "packets_held" in rules(result)
    (part,) = result.parts
    (gap,) = part.gaps
    assert gap.kind == "held"
    assert gap.samples_missing == 39  # rows 101 to 139 repeat row 100
    assert gap.start_s == part.time_s[100]
    assert gap.start_s + gap.length_s == pytest.approx(part.time_s[140])
