"""No stored number may change its meaning unseen: whoever changes an algorithm raises its version.

`algorithm_sources.toml` records, for every version of every algorithm, detector and file format, a hash of the source
that it had. After raising a version: LABBOOK_SOURCES=write pytest tests/labbook/analysis/test_results_sources.py adds
the new one and touches no old one. The hashes cover identifiers and imports: where only these changed, and
the frozen numbers of the demonstration are as they were, LABBOOK_SOURCES=anew records the newest versions anew.
"""

from __future__ import annotations

import functools
import importlib
import os
import pkgutil
import subprocess
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import labbook.analysis
from ingest.formats.registry import FORMATS, RECOGNISED
from labbook.analysis.algorithms import ALGORITHMS
from labbook.analysis.results.codec import Algorithm
from stats.apexes.detectors import DETECTORS
from tests.helpers.definitions import (
    LEFT_OUT,
    Definition,
    attributes_in,
    defined_in,
    digest_of,
    forget,
    named_by,
    rests_on,
)
from tests.helpers.frozen_numbers import DATA, differs, numbers_in
from tests.helpers.once import made_once
from tests.helpers.sources import closure, digest, is_module

"""The numbers of the demonstration: while they stay, a new hash of a version in use hides nothing."""
RECORD = Path(__file__).with_name("algorithm_sources.toml")
MODULES = [module.name for module in pkgutil.walk_packages(labbook.analysis.__path__, "labbook.analysis.")]
HEAD = "# Hashes of the sources behind stored numbers; see test_results_sources.py. Old versions are never edited.\n"


def sources_of(algorithm: Algorithm[Any]) -> set[Definition]:
    """What asks for its results, and all that this rests on; of what is private, what uses it in its module, too."""
    (root,) = [place for place, value in values() if value is algorithm]
    found, waiting = {root}, [root]
    while waiting:
        one = waiting.pop()
        if one is root or one[1].startswith("_"):
            new = {other for other in defined_in(root[0]) if one in named_by(other)} - found
            found |= new
            waiting += new
    return rests_on(found)


@functools.cache
def values() -> list[tuple[Definition, object]]:
    return [((module, name), vars(load(module))[name]) for module in MODULES for name in defined_names(module)]


@functools.cache
def defined_names(module: str) -> set[str]:
    return {name for _module, name in defined_in(module)} & vars(load(module)).keys()


def below(modules: set[str]) -> set[Definition]:
    """What modules rest on beside themselves: inputs as numbers, units."""
    return {
        one for one in rests_on({each for module in modules for each in defined_in(module)}) if one[0] not in modules
    }


def current() -> dict[str, tuple[int, str, set[str]]]:
    """Version, hash and modules of everything that has a version, found once a test run."""
    return made_once("current-sources", lambda _folder: found_now())


def found_now() -> dict[str, tuple[int, str, set[str]]]:
    """Version, hash and modules of everything that has a version, by name; `below_` is what that rests on further."""
    found = {}
    for algorithm in ALGORITHMS:
        sources = sources_of(algorithm)
        found[f"result.{algorithm.kind}"] = (algorithm.version, digest_of(sources), {module for module, _ in sources})
    read = [
        *(("detector", name, one.version, one.function, "stats") for name, one in DETECTORS.items()),
        *(
            ("format", format_.name, format_.version, format_.read, "ingest")
            for format_ in set(FORMATS) - set(RECOGNISED)  # those are never read
        ),
    ]
    for kind, name, version, function, package in read:
        modules = closure(function.__module__, package) | ({"stats.apexes.detectors"} if kind == "detector" else set())
        further = below(modules)
        found[f"{kind}.{name}"] = (version, digest(modules), modules)
        found[f"below_{kind}.{name}"] = (version, digest_of(further), {module for module, _ in further})
    return found


def load(module: str) -> ModuleType:
    return importlib.import_module(module)


def recorded() -> dict[str, dict[str, str]]:
    return by_name(tomllib.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {})


def by_name(tables: dict[str, dict[str, dict[str, str]]]) -> dict[str, dict[str, str]]:
    return {f"{kind}.{name}": versions for kind, table in tables.items() for name, versions in table.items()}


def write(record: dict[str, dict[str, str]]) -> None:
    tables = []
    for name, versions in sorted(record.items()):
        lines = [f'{version} = "{versions[version]}"\n' for version in sorted(versions, key=int)]
        tables.append(f"[{name}]\n{''.join(lines)}")
    RECORD.write_text("\n".join([HEAD, *tables]), encoding="utf-8")


def test_no_source_changes_without_a_new_version() -> None:
    record, now = recorded(), current()
    how = os.environ.get("LABBOOK_SOURCES")
    if how in ("write", "anew"):
        for name, (version, source, _modules) in now.items():
            versions = record.setdefault(name, {})
            if how == "anew" or str(version) not in versions:
                versions[str(version)] = source
        write(record)
    for name, (version, source, modules) in now.items():
        assert str(version) in record.get(name, {}), (
            f"{name} has version {version}, which {RECORD.name} does not know: add it with "
            f"`LABBOOK_SOURCES=write pytest {Path(__file__).name}`."
        )
        assert record[name][str(version)] == source, (
            f"the source of {name} changed, but its version is still {version}: numbers stored under it would be taken "
            f"for numbers of the new source. Where numbers moved, raise its version to {version + 1}, then add it with "
            f"`LABBOOK_SOURCES=write pytest {Path(__file__).name}`; where none did (names, imports, a new effect or "
            f"format), record it with `LABBOOK_SOURCES=anew`. It rests on {', '.join(sorted(modules))}."
        )


def test_what_is_on_record_is_never_edited() -> None:
    """What was committed stands as it was: changing a hash in place would hide that a number changed its meaning."""
    shown = subprocess.run(
        ["git", "show", f"HEAD:./{RECORD.name}"], cwd=RECORD.parent, capture_output=True, check=False
    )
    if shown.returncode:
        pytest.skip("not in a git checkout, so nothing says what the record was")
    record = recorded()
    moved = {kind for path in sorted(DATA.glob("*.csv.xz")) for kind in moved_kinds(path)}
    for name, versions in by_name(tomllib.loads(shown.stdout.decode())).items():
        newest, (what, _, kind) = max(versions, key=int), name.partition(".")
        stands = kind in moved if what == "result" else bool(moved)
        old = {version: source for version, source in versions.items() if version != newest or stands}
        assert old.items() <= record[name].items(), f"{name}: an old version was edited"


def moved_kinds(path: Path) -> set[str]:
    """Kinds of results of which a frozen number of the last commit is another one now, or gone; new ones may come."""
    at_head = ["git", "show", f"HEAD:./{path.name}"]
    shown = subprocess.run(at_head, cwd=path.parent, capture_output=True, check=True).stdout
    if shown == path.read_bytes():
        return set()
    was, now = numbers_in(shown), numbers_in(path.read_bytes())
    return {row["kind"] for uid, row in was.items() if uid not in now or differs(row, now[uid])}


def test_versions_only_rise_and_the_newest_is_in_use() -> None:
    in_use = {name: version for name, (version, _source, _modules) in current().items()}
    for name, versions in recorded().items():
        assert in_use.get(name) == max(map(int, versions)), f"{name}: a version that was used is never taken back"


def test_every_kind_of_result_is_in_the_registry() -> None:
    values = [value for module in MODULES for value in vars(load(module)).values()]
    found = {value.kind for value in values if isinstance(value, Algorithm)}
    assert found == {algorithm.kind for algorithm in ALGORITHMS}
    assert len(found) == len(ALGORITHMS)


@pytest.mark.parametrize(
    ("kind", "definition"),
    [
        ("run_energy", "data_schema.units.MAH_TO_COULOMB"),
        ("energy_budget", "data_schema.units.MAH_TO_COULOMB"),
        ("prediction_check", "reports.predicted.COVERAGE_FACTOR"),
        ("prediction", "simulator.jump.close_decision"),
        ("comparison", "stats.checks._doubles"),
        ("run_apexes", "stats.checks._doubles"),
        ("equivalence", "labbook.analysis.comparison.comparing.values_of"),
        ("condition_summary", "labbook.analysis.outcomes.run_energy.RunEnergy"),
        ("passive_drain", "labbook.analysis.outcomes.run_energy.recharge_of"),
        ("run_energy", "labbook.analysis.outcomes.run_energy.recharge_of"),
        ("run_energy", "stats.lines.passive_drain.PassiveDrain"),
        ("run_apexes", "labbook.analysis.outcomes.detection.rest_length_m"),
        ("comparison_by_day", "labbook.analysis.comparison.by_day.difference_weights"),
        ("comparison_by_day", "stats.days.reml.minimise"),
        ("prediction_check", "labbook.analysis.prediction.predicting.PredictionResult"),
        ("family", "stats.exact.tails._beta_area"),
        ("passive_drain", "labbook.analysis.results.codec._number_row"),
    ],
)
def test_what_a_number_rests_on_is_watched_wherever_it_stands(kind: str, definition: str) -> None:
    assert definition in {".".join(one) for one in sources_of(of_kind(kind))}


@pytest.mark.parametrize(
    ("kind", "definition"),
    [
        ("run_energy", "labbook.analysis.outcomes.run_energy.unused_idle"),
        ("family", "labbook.analysis.comparison.comparing.compare"),
        ("comparison", "labbook.analysis.outcomes.run_energy.run_energies"),
        ("prediction_check", "reports.predicted.Predictions"),
    ],
)
def test_what_only_reads_a_number_or_makes_another_is_not_watched(kind: str, definition: str) -> None:
    module, _dot, name = definition.rpartition(".")
    assert (module, name) in defined_in(module)
    assert (module, name) not in sources_of(of_kind(kind))


@pytest.mark.parametrize(
    ("name", "module"),
    [("below_detector.robust", "stats.checks"), ("below_format.delimited_log", "data_schema.units")],
)
def test_inputs_and_units_below_detectors_and_formats_are_watched(name: str, module: str) -> None:
    assert module in current()[name][2]


def test_no_result_holds_a_sentence() -> None:
    """What words a sentence is not watched, so that no result may store one."""
    for algorithm in ALGORITHMS:
        for module, name in sources_of(algorithm):
            assert "sentence" not in attributes_in((module, name)), (
                f"{module}.{name} words what {algorithm.kind} stores"
            )


def test_what_is_left_out_exists() -> None:
    for name in LEFT_OUT:
        module, _dot, last = name.rpartition(".")
        assert is_module(name) or (module, last) in defined_in(module)


def of_kind(kind: str) -> Algorithm[Any]:
    return next(algorithm for algorithm in ALGORITHMS if algorithm.kind == kind)


# --- what counts as a change


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path / "watched_module.py"


SPOKEN = '''
class Mean:
    """A mean."""

    value: float

    def sentence(self) -> str:
        return f"The mean is {self.value}."


def mean(values: list[float]) -> Mean:
    if not values:
        raise ValueError("no values")
    return Mean(sum(values) / len(values))


MEAN = Algorithm("mean", 1)


def ask() -> Mean:
    return MEAN, mean([1.0])
'''


def hash_of_definitions(module: Path, text: str) -> str:
    module.write_text(text, encoding="utf-8")
    importlib.invalidate_caches()
    forget()
    return digest_of(defined_in(module.stem))


@pytest.mark.parametrize(
    ("old", "new"), [("The mean is", "It is"), ("no values", "none"), ("A mean.", "It."), ("1)", "2)")]
)
def test_sentences_refusals_and_a_version_are_no_part_of_a_definition(module: Path, old: str, new: str) -> None:
    assert old in SPOKEN
    assert hash_of_definitions(module, SPOKEN) == hash_of_definitions(module, SPOKEN.replace(old, new))


@pytest.mark.parametrize(("old", "new"), [("not values", "values"), ("ValueError", "TypeError"), ("/ len", "* len")])
def test_when_a_refusal_comes_and_what_is_computed_are(module: Path, old: str, new: str) -> None:
    assert old in SPOKEN
    assert hash_of_definitions(module, SPOKEN) != hash_of_definitions(module, SPOKEN.replace(old, new))
