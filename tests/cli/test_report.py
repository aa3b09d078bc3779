"""`labbook report` and `labbook why`: the page holds the numbers, and every number leads to the bytes."""

from __future__ import annotations

import csv
import hashlib
import html
import json
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labbook.actions.upkeep.tracing import find_number, trace
from labbook.book.opening import opened
from tests.cli.shell import good, labbook, refused, unchanged
from tests.helpers.books import SmallBook, small_book
from tests.helpers.tomls import without
from tests.helpers.wording import says

SELECTED = ("r001", "r002", "r004", "r006", "r009", "r010", "r012", "r014")
"""The runs of the small foot."""


@dataclass(frozen=True)
class Reported:
    """A book and the report of its small foot."""

    book: SmallBook
    out: Path
    said: dict[str, Any]

    @property
    def page(self) -> str:
        return (self.out / "report.html").read_text(encoding="utf-8")

    def table(self, name: str) -> list[dict[str, str]]:
        return list(csv.DictReader((self.out / "tables" / f"{name}.csv").read_text(encoding="utf-8").splitlines()))


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> Reported:
    above = tmp_path_factory.mktemp("reported")
    book = small_book(above)
    said = good(labbook("report", "--foot", "small", "--out", above / "paper", "--json", at=book.folder)).json
    return Reported(book, above / "paper", said)


def joules_by_hand(book: SmallBook) -> dict[str, float]:
    """Joules a jump of every jump run, from the instruments' own files (thesis 5.1.4)."""
    sheet = {row["run"]: row for row in csv.DictReader((book.instruments / "runs.csv").read_text().splitlines())}
    charge_mah: dict[str, float] = {}
    for path in sorted((book.instruments / "charger").glob("*.csv")):
        charge_mah |= {row["run"]: float(row["mAh"]) for row in csv.DictReader(path.read_text().splitlines())}
    idle = [name for name, row in sheet.items() if row["kind"] == "idle"]
    slope, intercept = np.polyfit([float(sheet[name]["duration_s"]) for name in idle], [charge_mah[n] for n in idle], 1)
    return {
        name: 3.6 * 15.4 * (mah - float(slope * float(sheet[name]["duration_s"]) + intercept)) / float(jumps)
        for name, mah in charge_mah.items()
        if (jumps := sheet[name]["jumps_made"]) and name not in idle
    }


def test_the_drain_line_is_shown_where_the_protocol_has_no_run_duration(whole: SmallBook, tmp_path: Path) -> None:
    """It is then read at the mean duration of the idle runs, which is no round number of minutes."""
    without(whole.folder, r"run_duration_s = 720\n")
    good(labbook("correct", "r007", "duration_s=1230", "--why", "misread", at=whole.folder))
    good(labbook("report", "--out", tmp_path / "paper", at=whole.folder))
    found = Reported(whole, tmp_path / "paper", {})
    minutes = "37.6"  # of 1230, 2400, 1800 and 3600 s
    assert f"at {minutes} min" in [row["quantity"] for row in found.table("passive_drain")]
    says(html.unescape(found.page), "The electronics draw", f"in {minutes} min")


def test_numbers_are_those_of_the_instruments_files(reported: Reported) -> None:
    joules = joules_by_hand(reported.book)
    values = {row["run"]: float(row["joules_J"]) for row in reported.table("each_run") if row["joules_J"]}
    assert values == pytest.approx({run: joules[run] for run in SELECTED})
    control = [joules[run] for run in ("r001", "r006", "r009", "r014")]
    treated = [joules[run] for run in ("r002", "r004", "r010", "r012")]
    conditions = {row["b_ad_gain"]: row for row in reported.table("joules_by_condition")}
    for gain, expected in (("0", control), ("100", treated)):
        assert float(conditions[gain]["mean_j"]) == pytest.approx(np.mean(expected))
        assert float(conditions[gain]["sd_j"]) == pytest.approx(np.std(expected, ddof=1))
        assert int(conditions[gain]["n_runs"]) == 4
    (headline,) = reported.table("headlines")
    savings = 1 - np.mean(treated) / np.mean(control)
    assert float(headline["savings_percent"]) == pytest.approx(100 * savings)
    counted = [int(headline[f"{of}n_{side}"]) for of in ("", "apex_") for side in ("control", "treatment")]
    assert counted == [len(control), len(treated), 4, 4]
    assert f"{100 * savings:.1f}\N{NO-BREAK SPACE}%" in reported.said["claims"][0]


def test_page_shows_the_claims_the_numbers_and_where_they_come_from(reported: Reported) -> None:
    text = html.unescape(re.sub(r"<[^>]+>", "", reported.page)).replace("\N{NO-BREAK SPACE}", " ")
    for claim in reported.said["claims"]:
        assert claim.replace("\N{NO-BREAK SPACE}", " ") in text
    for row in reported.table("joules_by_condition"):
        assert f"{float(row['mean_j']):.0f}" in text
        assert row["provenance"] in text
    for said in ("foot=small", "1091 N/m", "67.36 N/m", "outside"):  # 12 minutes lies outside the idle runs
        assert said in text


def test_every_provenance_id_of_the_page_leads_to_the_bytes(reported: Reported) -> None:
    on_page = set(re.findall(r'id="why-([0-9a-f]+)"', reported.page))
    ids = {row["id"] for row in reported.table("provenance")}
    assert len(ids) > 20
    assert on_page <= ids
    measured = [*reported.book.instruments.glob("logs/*"), *reported.book.instruments.glob("charger/*")]
    files = {hashlib.sha256(path.read_bytes()).hexdigest() for path in measured}
    values = {float(row["mean_j"]) for row in reported.table("joules_by_condition")}
    with opened(reported.book.folder) as book, book.reading() as connection:
        for uid in ids:
            found = trace(connection, find_number(book, connection, uid))
            assert found.number.id == uid
            assert found.shown_in
            traced = set(re.findall(r"sha256 ([0-9a-f]{64})", str(found.trace)))
            assert traced
            assert traced <= files
            values.discard(found.number.value or 0.0)
    assert values == set()


def test_every_id_of_page_tables_and_macros_is_in_numbers_json(reported: Reported) -> None:
    numbers = json.loads((reported.out / "numbers.json").read_text(encoding="utf-8"))
    known = set(numbers["numbers"])
    assert {one["result"] for one in numbers["numbers"].values()} <= set(numbers["results"])
    assert set(re.findall(r'why-([0-9a-f]+)"', reported.page)) <= known
    macros = re.findall(r"% ([0-9a-f]{12})$", (reported.out / "numbers.tex").read_text(encoding="utf-8"), re.MULTILINE)
    assert len(macros) > 10
    assert set(macros) <= known
    rows = [row for path in (reported.out / "tables").glob("*.csv") for row in reported.table(path.stem)]
    columns = {uid for row in rows for uid in row.get("provenance", "").split()}
    assert len(columns) > 20
    assert columns <= known == {row["id"] for row in reported.table("provenance")}
    for uid in [*sorted(known)[::40], macros[0]]:
        told = good(labbook("why", uid, at=reported.book.folder)).out
        value = numbers["numbers"][uid]["value"]
        assert told.startswith(f"{uid}: ")
        assert value is None or f"= {value!r} " in told.splitlines()[0]


def test_why_is_told_as_a_tree_and_by_the_beginning_of_an_id(reported: Reported) -> None:
    uid = reported.table("headlines")[0]["provenance"]
    found = good(labbook("why", uid, "--json", at=reported.book.folder)).json
    assert (found["number"]["id"], found["trace"]["kind"]) == (uid, "decision")
    told = good(labbook("why", uid, at=reported.book.folder)).out
    assert told.startswith(f"{uid}: savings = ")
    says(told, "of file", "2021-06-14", "sha256")
    assert good(labbook("why", uid[:10], at=reported.book.folder)).out == told
    refused(labbook("why", "", at=reported.book.folder), 2, "copy the whole id")


def test_a_second_report_says_the_same(reported: Reported, tmp_path: Path) -> None:
    where = ("report", "--where", "foot=small", "--out", tmp_path / "again", "--json")
    said = good(labbook(*where, at=reported.book.folder)).json
    assert said["claims"] == reported.said["claims"]
    written = [*(reported.out / "tables").iterdir(), reported.out / "numbers.json"]
    for path in sorted(one.relative_to(reported.out) for one in written):
        assert (tmp_path / "again" / path).read_bytes() == (reported.out / path).read_bytes()


def test_a_corrected_charge_is_in_the_history_of_its_run_and_in_the_chain_of_earlier_numbers(
    reported: Reported, tmp_path: Path
) -> None:
    book = tmp_path / "book"
    shutil.copytree(reported.book.folder, book)
    (charge,) = good(labbook("show", "r001", "--json", at=book)).json["charges"]
    was = f"{charge['charge_mah']:g}"
    good(labbook("correct", "r001", "mah=56.1", "jumps=2", "--why", "slip", at=book))
    shown = " ".join(good(labbook("show", "r001", at=book)).out.split())
    assert f"corrected charge {charge['uid']}: charge_mah {was} to 56.1 (slip)" in shown
    uid = reported.table("headlines")[0]["provenance"]
    for flags in ([], ["--check"]):
        told = good(labbook("why", uid, *flags, at=book)).out.splitlines()
        (line,) = [line for line in told if f"charge_mah {was} to 56.1" in line]
        says(line, "charge: charge_mah 56.1", "corrected after the last report")
        says(told, "run: run r001,", "jumps_made 3 to 2")
    good(labbook("correct", "r001", f"mah={was}", "jumps=3", "--why", "it was right", at=book))
    assert "corrected after" not in good(labbook("why", uid, at=book)).out


def test_folder_that_cannot_be_written_to_is_named(reported: Reported, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    with unchanged(reported.book.folder):
        words = ("report", "--foot", "small", "--out", tmp_path / "taken")
        refused(labbook(*words, at=reported.book.folder), 2, "taken", "--out")
