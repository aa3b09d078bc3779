"""docs/your-own-data.md: every command in it works on files as it describes them, and it leaves nothing out."""

from __future__ import annotations

import os
import re
import shlex
import struct
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from data_schema.queries.detections import JumpRow
from data_schema.vocabulary import CHANNELS
from ingest.model import Limits
from labbook.config.profiles import SHEET_COLUMNS
from stats.apexes.jumps import FLAGS
from tests.cli.shell import good, labbook, process, rows
from tests.helpers.books import instrument_files, small_book, small_toml
from tests.helpers.single_jumps import SimulatedJump
from tests.helpers.wording import says
from tests.labbook.config.test_parsing import SAMPLE

PROJECT = Path(__file__).parents[2]
PAGE = (PROJECT / "docs" / "your-own-data.md").read_text(encoding="utf-8")


def blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)


def own_files(folder: Path) -> None:
    """The logs, records of a plate, sheet of recharges and run sheet that the page is about, from the small book's."""
    (folder / "logs").mkdir()
    (folder / "plate").mkdir()
    sheet = ["Versuch;geladen;Dauer;Spannung;Akku;beendet"]
    for name, data in instrument_files().items():
        lines = data.decode().splitlines()
        if name.startswith("logs/"):
            log = ["Hopper logger, firmware 7", "Zeit;z;Akku;Bemerkung"]
            for line in lines[1:]:
                time_ms, height_m, _leg, _velocity, volts, *_ = line.split(",")
                log.append(f"{time_ms};{1000 * float(height_m):.2f};{float(volts):.2f};ok".replace(".", ","))
            (folder / "logs" / f"{Path(name).stem}.txt").write_text("\n".join(log) + "\n")
            force_n = SimulatedJump(len(log), mass_kg=2.0, slower=0.5, noise_n=0.2, sway_n=0.02).force_n
            np.savetxt(folder / "plate" / f"{Path(name).stem}_plate.csv", force_n, "%.3f")
        elif name.startswith("charger/"):
            for line in lines[1:]:
                run, mah, minutes, volts, pack, ended = line.split(",")
                year, month, day = ended[:10].split("-")
                row = [run, mah, minutes, volts.replace(".", ","), pack, f"{int(day)}.{int(month)}.{year} {ended[11:]}"]
                sheet.append(";".join(row))
    (folder / "charges.csv").write_text("\n".join(sheet) + "\n")
    heights = [f"{2 * row},{812 + 700 * (row // 600) + row % 3}" for row in range(1800)]
    (folder / "heights.csv").write_text("\n".join(["t,adc_h", *heights]) + "\n")
    (folder / "runs.csv").write_bytes(instrument_files()["runs.csv"])


def test_every_command_works_from_the_first_log_to_the_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own_files(tmp_path)
    monkeypatch.setenv("LABBOOK_AS", "Ada Nwosu")
    steps = re.findall(r"^ {4}(labbook .*|cd .*)$", PAGE, re.MULTILINE)
    assert len(steps) >= 9
    folder, drafted = tmp_path, False
    for step in steps:
        words = shlex.split(step)
        if words[0] == "cd":
            folder = folder / words[1]
            (folder / "labbook.toml").write_text(small_toml())
            continue
        if drafted:  # the profiles of the page stand in labbook.toml from here on
            drafted = False
            with (folder / "labbook.toml").open("a") as toml:
                toml.write("\n" + "\n".join(block for block in blocks("toml") if "[profiles." in block))
        answer = labbook(*words[1:], at=folder)
        assert answer.code == (2 if words[2:] == ["../logs/r001.txt", "--explain"] else 0), answer  # as the page says
        assert answer.err == ""
        drafted = "--draft-profile" in words
    assert rows(folder, "SELECT count(*) FROM signal") == [(24,)]
    heights = good(labbook("show", "r001", "--json", at=folder)).json["from_plate"]
    assert 0.04 < heights["impulse_height"]["value"] < 0.15
    assert rows(folder, "SELECT count(*) FROM charge WHERE run IS NOT NULL AND ended_utc IS NOT NULL") == [(16,)]
    assert list((folder / "reports").rglob("report.html"))


@pytest.mark.soak
def test_the_gains_of_the_page_are_simulated(tmp_path: Path) -> None:
    folder = small_book(tmp_path).folder
    toml = re.sub(r"(?ms)^\[gains\..*?(?=^\[(?!gains))", "", (folder / "labbook.toml").read_text())
    (block,) = (block for block in blocks("toml") if "[gains." in block)
    (folder / "labbook.toml").write_text(toml + "\n" + block[block.index("[simulation]") :])
    assert "Simulated as it stands: k_gain" in good(labbook("compare", at=folder)).out
    (folder / "labbook.toml").write_text(toml + "\n" + block)
    told = good(labbook("compare", at=folder)).out
    assert "as it stands" not in told
    assert "1091 N/m" in told


def test_every_key_channel_and_column_is_on_the_page() -> None:
    words = set(re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", PAGE, flags=re.DOTALL)))
    keys = set(re.findall(r"(?m)^([a-z_0-9]+) = ", SAMPLE)) - {"columns"}
    assert keys - words == set()
    assert {each.name for each in fields(Limits)} - words == set()
    assert {name for name in CHANNELS if not name.startswith("cell_")} - words == set()
    assert set(SHEET_COLUMNS) - words == set()
    assert {each.name for each in fields(JumpRow)} | set(FLAGS) <= words
    tables = set(re.findall(r"(?m)^\[(\w+)", SAMPLE))
    assert {table for table in tables if not re.search(rf"`\[{table}\b", PAGE)} == set()


@pytest.mark.soak
def test_the_plug_in_of_the_page_is_installed_and_reads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (project,) = (block for block in blocks("toml") if "entry-points" in block)
    (code,) = blocks("python")
    assert sum(bool(line.strip()) for line in (project + code).splitlines()) < 40
    source, installed = tmp_path / "hopper-format", tmp_path / "installed"
    source.mkdir()
    (source / "pyproject.toml").write_text(project)
    (source / "hopper_format.py").write_text(code)
    offline = ["--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check", "--quiet"]
    install = [sys.executable, "-m", "pip", "install", *offline, "--target", installed, source]
    subprocess.run(install, check=True, capture_output=True, timeout=120)
    book = small_book(tmp_path / "small", runs=False, ingested=False)
    log = tmp_path / "r001.hop"
    log.write_bytes(b"HOP1" + b"".join(struct.pack("<Ih", 4000 * k, 4000 + k % 7) for k in range(500)))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(installed), str(PROJECT)]))
    assert "hopper-format 1.0" in process("formats", at=book.folder).out
    says(process("ingest", log, "--explain", at=book.folder).out, "hopper_binary", "1.0")
    good(process("ingest", log, at=book.folder))
    assert rows(book.folder, "SELECT reader, rate_hz FROM signal") == [("hopper_binary", pytest.approx(250.0))]
    (installed / "hopper_format.py").write_text("raise RuntimeError('no such module')\n")
    log.write_bytes(log.read_bytes() * 2)
    other = process("ingest", log, "--dry-run", at=book.folder)
    assert other.code == 2
    assert "format_unknown" in other.out
    (sentence,) = other.err.splitlines()
    says(sentence, "1.0 cannot")
