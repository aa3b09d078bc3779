"""What a file does not say is asked for, by flag, by profile, or at a terminal; never assumed."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.cli.shell import at_a_terminal, good, labbook, rows, unchanged
from tests.helpers.books import SmallBook
from tests.helpers.wording import says
from tests.ingest.synthetic import robot_rows


def without(folder: Path, what: str) -> Path:
    """A log of heights without a time column, or without the unit of its time."""
    path = folder / "odd.csv"
    cells = [row.split(",")[:3] for row in robot_rows()]
    lines = {
        "time": ["height [m],leg_length [m]", *(",".join(row[1:]) for row in cells)],
        "unit": ["time,height [m]", *(",".join(row[:2]) for row in cells)],
    }[what]
    path.write_text("\n".join([*lines, ""]))
    return path


def rate_of(book: SmallBook) -> float:
    ((rate_hz,),) = rows(book.folder, "SELECT rate_hz FROM signal")
    return float(rate_hz)


@pytest.mark.parametrize(
    ("what", "asked", "said", "rate_hz"),
    [
        ("time", ("rate_missing", "`--rate HZ`"), ("--rate", "300"), 300.0),
        ("unit", ("time_unit_missing", "--unit"), ("--unit", "time=ms"), pytest.approx(300.0, rel=0.01)),
        ("unit", ("time_unit_missing",), ("--column", "time=time:ms"), pytest.approx(300.0, rel=0.01)),
    ],
)
def test_what_a_log_lacks_is_asked_for_by_the_flag_that_works(
    what: str, asked: tuple[str, ...], said: tuple[str, str], rate_hz: float, fresh: SmallBook, tmp_path: Path
) -> None:
    path = without(tmp_path, what)
    with unchanged(fresh.folder):
        answer = labbook("ingest", path, "--dry-run", at=fresh.folder)
        (item,) = labbook("ingest", path, "--dry-run", "--json", at=fresh.folder).json
    assert answer.code == 2
    says(answer.out, *asked)
    assert (item["status"], asked[0] in {finding["rule"] for finding in item["findings"]}) == ("refused", True)
    good(labbook("ingest", path, *said, at=fresh.folder))
    assert rate_of(fresh) == rate_hz


def test_at_a_terminal_the_person_is_asked(fresh: SmallBook, tmp_path: Path) -> None:
    code, out, asked = at_a_terminal("ingest", without(tmp_path, "unit"), at=fresh.folder, typed="ms\n")
    assert "unit of time" in asked
    assert code == 0, out
    assert "1 imported" in out
    good(labbook("rebuild", at=fresh.folder))
    assert rate_of(fresh) == pytest.approx(300.0, rel=0.01)


@pytest.mark.soak
def test_no_answer_at_a_terminal_stores_nothing(fresh: SmallBook, tmp_path: Path) -> None:
    code, out, asked = at_a_terminal("ingest", without(tmp_path, "time"), at=fresh.folder, typed="\x04")
    assert "samples a second" in asked
    assert code == 2
    says(asked, "no answer was")
    assert "Traceback" not in asked + out
    assert rows(fresh.folder, "SELECT count(*) FROM file") == [(0,)]


@pytest.mark.parametrize(
    ("said", "rule", "remedy"),
    [
        ("--unit time=parsec", "time_unit_unknown", "`--unit time=UNIT`"),
        ("--unit tme=ms", "declared_column_absent", "did you mean 'time'?"),
        ("--unit time=ms --rate 1000", "rate_contradicts", "1000"),
        ("--unit time=ms --column nosuch=leg_length:mm", "file: declared_column_absent", "'height [m]'"),
        ("--unit time=ms --column Height=body_height", "file: declared_column_absent", "'height [m]'?"),
        ("--unit time=ms --unit height=kg", "unit_not_convertible", "for example 'm'"),
        ("--unit time=ms --column height=body_height:furlong", "unit_contradicts", "--override-units"),
    ],
)
def test_wrong_declaration_is_refused_with_what_is_right(
    said: str, rule: str, remedy: str, fresh: SmallBook, tmp_path: Path
) -> None:
    with unchanged(fresh.folder):
        answer = labbook("ingest", without(tmp_path, "unit"), *said.split(), "--dry-run", at=fresh.folder)
    assert (answer.code, answer.err) == (2, "")
    says(answer.out, rule, remedy)


CONTRADICTIONS = {
    "unit": (1e2, ("--column", "height=body_height:cm"), "--override-units", "unit_contradicts"),
    "robot": (1.0, (), "--no-robot-check", "height_implausible"),
}


@pytest.mark.parametrize("by_profile", [False, True], ids=["by flag", "by profile"])
@pytest.mark.parametrize(("scale", "said", "flag", "rule"), CONTRADICTIONS.values(), ids=CONTRADICTIONS)
def test_what_contradicts_itself_is_refused_until_a_flag_or_a_profile_decides(
    scale: float, said: tuple[str, ...], flag: str, rule: str, by_profile: bool, fresh: SmallBook, tmp_path: Path
) -> None:
    path = tmp_path / "hops.csv"
    heights = [scale * (0.2 + 0.1 * abs(math.sin(k / 40.0))) for k in range(1200)]
    path.write_text("time [ms],height [mm]\n" + "".join(f"{3 * k},{h:.7f}\n" for k, h in enumerate(heights)))
    answer = labbook("ingest", path, *said, at=fresh.folder)
    assert answer.code == 2
    says(answer.out, rule, flag)
    _decided(fresh, path, said, flag, by_profile)
    good(labbook("rebuild", at=fresh.folder))
    assert rows(fresh.folder, "SELECT count(*) FROM signal") == [(1,)]


def _decided(book: SmallBook, path: Path, said: tuple[str, ...], flag: str, by_profile: bool) -> None:
    if by_profile:
        with book.toml.open("a") as toml:
            toml.write(f'\n[profiles.decided]\nfiles = "{path.name}"\n{flag[2:].replace("-", "_")} = true\n')
        flag = "--profile=decided"
    good(labbook("ingest", path, *said, flag, at=book.folder))


@pytest.mark.parametrize("by_profile", [False, True], ids=["by flag", "by profile"])
def test_a_last_number_that_may_be_cut_counts_where_it_is_said_to_be_whole(
    by_profile: bool, fresh: SmallBook, tmp_path: Path
) -> None:
    path = tmp_path / "charges.csv"
    path.write_text("run,charge (mAh)\nr001,812\nr002,790\nr003,79")
    says(good(labbook("ingest", path, at=fresh.folder)).out, "row: last_cell_cut", "line 4", "--complete")
    assert rows(fresh.folder, "SELECT charge_mah FROM charge ORDER BY 1") == [(790.0,), (812.0,)]
    _decided(fresh, path, (), "--complete", by_profile)
    assert rows(fresh.folder, "SELECT charge_mah FROM charge ORDER BY 1") == [(79.0,), (790.0,), (812.0,)]
