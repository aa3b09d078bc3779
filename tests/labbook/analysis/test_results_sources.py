"""No stored number may change its meaning unseen: whoever changes an algorithm raises its version.

`algorithm_sources.toml` records, for every version of every algorithm, detector and file format, a hash of the source
that it had. After raising a version: LABBOOK_SOURCES=write pytest tests/labbook/analysis/test_results_sources.py, which
adds the new version and never touches an old one.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import subprocess
import tomllib
from pathlib import Path

import pytest

import labbook.analysis
from ingest.formats import FORMATS
from ingest.formats.recognised import RECOGNISED
from labbook.analysis.algorithms import ALGORITHMS
from labbook.analysis.workbench import Algorithm
from stats.apexes import DETECTORS
from tests.helpers.sources import WORDS_ONLY, closure, digest, imports

RECORD = Path(__file__).with_name("algorithm_sources.toml")
HEAD = "# Hashes of the sources behind stored numbers; see test_results_sources.py. Old versions are never edited.\n"


def sources_of(algorithm: Algorithm) -> set[str]:
    """Its own modules, and what the statistics and the simulation among them rest on."""
    found = set(algorithm.modules)
    for module in algorithm.modules:
        package = module.partition(".")[0]
        if package in ("stats", "simulator"):
            found |= closure(module, package)
    return found


def current() -> dict[str, tuple[int, set[str]]]:
    """Version and sources of everything that has a version, by name."""
    found = {f"result.{algorithm.kind}": (algorithm.version, sources_of(algorithm)) for algorithm in ALGORITHMS}
    for name, detector in DETECTORS.items():
        modules = closure(detector.function.__module__, "stats") | {"stats.apexes"}
        found[f"detector.{name}"] = (detector.version, modules)
    for format_ in set(FORMATS) - set(RECOGNISED):  # those are never read
        found[f"format.{format_.name}"] = (format_.version, closure(format_.read.__module__, "ingest"))
    return found


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
    record = recorded()
    if os.environ.get("LABBOOK_SOURCES") == "write":
        for name, (version, modules) in current().items():
            record.setdefault(name, {}).setdefault(str(version), digest(modules))
        write(record)
    for name, (version, modules) in current().items():
        assert str(version) in record.get(name, {}), (
            f"{name} has version {version}, which {RECORD.name} does not know: add it with "
            f"`LABBOOK_SOURCES=write pytest {Path(__file__).name}`."
        )
        assert record[name][str(version)] == digest(modules), (
            f"the source of {name} changed, but its version is still {version}: numbers stored under it would be taken "
            f"for numbers of the new source. Raise its version to {version + 1}, then add it with "
            f"`LABBOOK_SOURCES=write pytest {Path(__file__).name}`. Its source is {', '.join(sorted(modules))}."
        )


def test_what_is_on_record_is_never_edited() -> None:
    """What was committed stands as it was: changing a hash in place would hide that a number changed its meaning."""
    shown = subprocess.run(
        ["git", "show", f"HEAD:./{RECORD.name}"], cwd=RECORD.parent, capture_output=True, check=False
    )
    if shown.returncode:
        pytest.skip("not in a git checkout, so nothing says what the record was")
    record = recorded()
    for name, versions in by_name(tomllib.loads(shown.stdout.decode())).items():
        assert versions.items() <= record[name].items(), f"{name}: an old version was edited"


def test_versions_only_rise_and_the_newest_is_in_use() -> None:
    in_use = {name: version for name, (version, _modules) in current().items()}
    for name, versions in recorded().items():
        assert in_use.get(name) == max(map(int, versions)), f"{name}: a version that was used is never taken back"


def test_every_kind_of_result_is_in_the_registry() -> None:
    names = [module.name for module in pkgutil.iter_modules(labbook.analysis.__path__, "labbook.analysis.")]
    values = [value for name in names for value in vars(importlib.import_module(name)).values()]
    found = {value.kind for value in values if isinstance(value, Algorithm)}
    assert found == {algorithm.kind for algorithm in ALGORITHMS}
    assert len(found) == len(ALGORITHMS)


@pytest.mark.parametrize("algorithm", ALGORITHMS, ids=lambda algorithm: algorithm.kind)
def test_an_algorithm_names_its_own_module_and_modules_that_exist(algorithm: Algorithm) -> None:
    assert any(module.startswith("labbook.analysis.") for module in algorithm.modules)
    assert all(importlib.util.find_spec(module) is not None for module in algorithm.modules)


def test_all_statistics_that_results_use_are_watched() -> None:
    """Whatever of `stats` a module of analysis imports is among the sources of an algorithm of that module."""
    watched: dict[str, set[str]] = {}
    for algorithm in ALGORITHMS:
        for module in algorithm.modules:
            if module.startswith("labbook.analysis."):
                watched.setdefault(module, set()).update(sources_of(algorithm))
    for module, sources in watched.items():
        used = {name for name in imports(module) if name.startswith("stats.")} - WORDS_ONLY
        assert used <= sources, f"{module} computes with {sorted(used - sources)}, which no algorithm of it names"


# --- what counts as a change


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path / "watched_module.py"


SOURCE = '''"""A module."""

LIMIT = 3.0
"""In metres."""


def double(x: float) -> float:
    """Twice as much."""
    # because
    return 2.0 * x
'''


def digest_of(module: Path, text: str) -> str:
    module.write_text(text, encoding="utf-8")
    importlib.invalidate_caches()
    return digest([module.stem])


@pytest.mark.parametrize(
    ("old", "new"),
    [("A module.", "Another word."), ("# because\n", "# for a reason\n\n"), ("In metres.", "m"), ("\n\n\n", "\n\n")],
)
def test_words_about_a_source_do_not_count(module: Path, old: str, new: str) -> None:
    assert old in SOURCE
    assert digest_of(module, SOURCE) == digest_of(module, SOURCE.replace(old, new))


@pytest.mark.parametrize(("old", "new"), [("2.0 * x", "2.0 + x"), ("3.0", "3.1"), ("return 2.0", "return  -2.0")])
def test_what_it_does_counts(module: Path, old: str, new: str) -> None:
    assert old in SOURCE
    assert digest_of(module, SOURCE) != digest_of(module, SOURCE.replace(old, new))
