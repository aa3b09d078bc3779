"""What a person says afterwards: verdicts on jumps, corrections, void runs, notes; and looking at a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from data_schema.vocabulary import ReasonCode, Verdict
from tests.cli.shell import good, labbook, refused, rows, unchanged
from tests.helpers.books import ADA, BEN, SmallBook, small_book
from tests.helpers.statements import judge_blind
from tests.helpers.wording import says


def jumps(book: SmallBook, run: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = good(labbook("jumps", "list", run, "--json", at=book.folder)).json["jumps"]
    return found


def counting(book: SmallBook, run: str) -> list[int]:
    return [item["jump"]["number"] for item in jumps(book, run) if item["excluded"] is None]


def test_verdicts_are_rows_that_are_only_added_and_can_be_taken_back(whole: SmallBook) -> None:
    before = counting(whole, "r001")
    assert 2 in before
    raw = rows(whole.folder, "SELECT * FROM jump ORDER BY id")
    said = good(labbook("jumps", "reject", "r001", "2", "--reason", "touched_by_hand", at=whole.folder)).out
    assert said.startswith("r001: reject 2.")
    assert counting(whole, "r001") == [number for number in before if number != 2]
    shown = good(labbook("jumps", "list", "r001", at=whole.folder)).out
    says(shown, "no: ", "hand")
    says(shown, "landing_extrapolated: ", "not seen")  # what the flag in the table means
    good(labbook("jumps", "accept", "r001", "2", "--note", "looked again", at=whole.folder))
    assert counting(whole, "r001") == before
    good(labbook("jumps", "reject", "r001", "1", "2", "--reason", "misfire", at=whole.folder))
    assert counting(whole, "r001") == [number for number in before if number > 2]
    good(labbook("jumps", "clear", "r001", "1", "2", at=whole.folder))
    assert counting(whole, "r001") == before
    verdicts = rows(whole.folder, "SELECT verdict, reason_code, note FROM decision ORDER BY id")
    assert verdicts[:2] == [("reject", "touched_by_hand", None), ("accept", "looks_right", "looked again")]
    assert verdicts[2:] == [("reject", "misfire", None)] * 2 + [("clear", "other", None)] * 2
    assert rows(whole.folder, "SELECT * FROM jump ORDER BY id") == raw


def test_jumps_that_a_person_reviewed_are_told_from_the_others(tmp_path: Path) -> None:
    """By whom, and whether blind; one whose verdict was taken back is not reviewed any more."""
    book = small_book(tmp_path, two_people=True)
    alone = good(labbook("show", "r001", "--json", at=book.folder)).json
    assert (alone["reviewed"], alone["not_reviewed"]) == ([], [1, 2, 3])
    good(labbook("jumps", "accept", "r001", "1", "3", "--as", "BO", at=book.folder))
    good(labbook("jumps", "clear", "r001", "3", "--as", "AN", at=book.folder))
    with book.open() as opened:
        judge_blind(opened, "r001", 2, Verdict.REJECT, ReasonCode.MISFIRE)
    reviewed = [
        {"verdict": "accept", "reason_code": "looks_right", "person": BEN, "blind": False, "jumps": [1]},
        {"verdict": "reject", "reason_code": "misfire", "person": ADA, "blind": True, "jumps": [2]},
    ]
    for words in (("show", "r001"), ("jumps", "list", "r001")):
        found = good(labbook(*words, "--json", at=book.folder)).json
        assert (found["reviewed"], found["not_reviewed"]) == (reviewed, [3])
        said = good(labbook(*words, at=book.folder)).out
        says(said, "jump 1", "accepted", BEN)
        says(said, "jump 2", "rejected", ADA, "blind", "misfire")
        says(said, "1 of 3 jumps", "not")


def test_correction_keeps_the_old_value_and_who_said_why(whole: SmallBook) -> None:
    done = good(labbook("correct", "r002", "foot=large", "--why", "typed wrong", "--json", at=whole.folder)).json
    assert set(done["changed"]) == {"condition"}
    says(good(labbook("show", "r002", at=whole.folder)).out, "foot=large", "k_gain=400", "b_ad_gain=100", "typed wrong")
    query = (
        "SELECT action, person.name, reason, old_json != new_json FROM journal JOIN person ON person = person.id "
        "ORDER BY seq DESC LIMIT 1"
    )
    assert rows(whole.folder, query) == [("set", "Ada Nwosu", "typed wrong", 1)]
    several = ("correct", "r002", "duration_s=700", "jumps_made=2", "battery=C", "day=2021-06-15", "--why", "x")
    changed = good(labbook(*several, "--json", at=whole.folder)).json["changed"]
    assert set(changed) == {"duration_s", "jumps_made", "battery", "day"}
    assert changed["duration_s"] == [720, 700]


def test_a_run_that_turns_out_idle_is_corrected_in_one_command_and_back(whole: SmallBook) -> None:
    idle = ("kind=idle", "jumps_made=0", "levels=none")
    good(labbook("correct", "r002", *idle, "--why", "motor was off", at=whole.folder))
    says(good(labbook("show", "r002", at=whole.folder)).out, "r002", "complete", "condition: none")
    levels = ("foot=small", "k_gain=400.0", "b_ad_gain=1e2")
    good(labbook("correct", "r002", "kind=jumps", "jumps_made=3.0", *levels, "--why", "x", at=whole.folder))
    says(good(labbook("show", "r002", at=whole.folder)).out, "foot=small", "k_gain=400", "b_ad_gain=100")
    with unchanged(whole.folder):
        again = labbook("correct", "r002", "k_gain=400.0", "jumps_made=3.0", "--why", "x", at=whole.folder)
        assert "says that already" in good(again).out


def test_void_can_be_taken_back_and_both_statements_stay(whole: SmallBook) -> None:
    good(labbook("void", "r003", "--reason", "foot came loose", at=whole.folder))
    assert "(jumps, void)" in good(labbook("show", "r003", at=whole.folder)).out
    good(labbook("void", "r003", "--undo", "--reason", "it was r004", at=whole.folder))
    shown = good(labbook("show", "r003", at=whole.folder)).out
    for said in ("(jumps, complete)", "foot came loose", "it was r004", "file r003.csv"):
        assert said in shown


def test_show_tells_all_that_belongs_to_a_run(whole: SmallBook) -> None:
    shown = good(labbook("show", "r001", at=whole.folder)).out
    says(shown, "run r001 (jumps, complete) on 2021-06-14, position 1")
    for part in ("battery A, 1 start, 3 jumps made", "body_height", "mAh", "note by Ada Nwosu", "declared: "):
        assert part in shown
    found = good(labbook("show", "r001", "--json", at=whole.folder)).json
    assert found["run"]["levels"] == {"foot": "small", "k_gain": "400", "b_ad_gain": "0"}
    assert [item["name"] for item in found["files"]] == ["2021-06-14.csv", "r001.csv"]


def test_notes_are_kept_word_for_word(whole: SmallBook) -> None:
    text = "left rail “squeaked” $1 <b> 50 % – größer\nsecond line"
    good(labbook("note", "r001", text, at=whole.folder))
    assert rows(whole.folder, "SELECT text FROM note ORDER BY id DESC LIMIT 1") == [(text,)]
    assert good(labbook("show", "r001", "--json", at=whole.folder)).json["notes"][-1]["text"] == text


def test_plot_makes_a_picture_in_the_form_asked_for(whole: SmallBook, tmp_path: Path) -> None:
    for ending, start in (("png", b"\x89PNG"), ("html", b"<!DOCTYPE html>")):
        out = tmp_path / f"picture.{ending}"
        with unchanged(whole.folder):
            done = good(labbook("plot", "r001", "--jump", "2", "--out", out, "--json", at=whole.folder)).json
        assert done == {"run": "r001", "figure": str(out), "remark": ""}
        assert out.read_bytes().startswith(start)
        assert out.stat().st_size > 5000


def test_plot_is_named_after_its_run(whole: SmallBook, tmp_path: Path) -> None:
    good(labbook("correct", "r001", "run=r 1/ö", "--why", "as on the sheet", at=whole.folder))
    good(labbook("plot", "r 1/ö", "--book", whole.folder, at=tmp_path))
    assert (tmp_path / "r 1_ö.png").exists()


def test_ranges_of_jumps_are_each_of_their_jumps_once(whole: SmallBook) -> None:
    said = good(labbook("jumps", "reject", "r001", "2-3", "3", "1", "--reason", "misfire", "--json", at=whole.folder))
    assert said.json["jumps"] == [2, 3, 1]
    assert rows(whole.folder, "SELECT count(*) FROM decision") == [(3,)]
    assert counting(whole, "r001") == []
    good(labbook("jumps", "clear", "r001", "1-3", at=whole.folder))
    with unchanged(whole.folder):
        refused(labbook("jumps", "reject", "r001", "2-4", "--reason", "misfire", at=whole.folder), 2, "no jump 4")


@pytest.mark.parametrize(
    ("target", "field", "said"),
    [
        ("study", "reference_voltage_v=16.8", ("reference_voltage_v = 15.4", "[study]", "16.8")),
        ("robot:hopper", "body_mass_kg=1.9", ("body_mass_kg = 1.8", "[robots.hopper]", "1.9")),
        ("battery:A", "capacity_mah=6000", ("capacity_mah = 6600.0", "[batteries.A]", "6000.0")),
        ("battery:A", "name=D", ("[batteries.A]", "[batteries.D]")),
        ("factor:k_gain", "unit=N", ("no unit", "[factors.k_gain]", 'unit = "N"')),
        ("level:foot=small", 'attributes_json={"radius_m":0.04}', ("[factors.foot.levels.small]", "radius_m = 0.04")),
    ],
)
def test_what_labbook_toml_should_say_now_is_told_and_then_all_is_well(
    target: str, field: str, said: tuple[str, ...], whole: SmallBook
) -> None:
    done = good(labbook("correct", target, field, "--why", "measured again", at=whole.folder)).out
    says(done, "labbook.toml", *said)
    assert labbook("today", at=whole.folder).code == 0
    good(labbook("note", "r001", "goes on", at=whole.folder))


def test_the_file_changed_as_told_is_taken_over_without_a_word(whole: SmallBook) -> None:
    good(labbook("correct", "study", "reference_voltage_v=16.8", "--why", "measured", at=whole.folder))
    whole.toml.write_text(whole.toml.read_text().replace("reference_voltage_v = 15.4", "reference_voltage_v = 16.8"))
    good(labbook("note", "r001", "goes on", at=whole.folder))
    assert rows(whole.folder, "SELECT reference_voltage_v FROM study") == [(16.8,)]
