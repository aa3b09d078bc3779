import dataclasses
import subprocess
import sys
from pathlib import Path

import pytest

from data_schema import file_cache
from data_schema.file_cache import CACHE_VARIABLE, cache_folder
from data_schema.outcomes import Outcome
from reports.figures import registry as figure_cache
from reports.figures.by_level import file_name
from reports.figures.kind import draw_figure
from reports.figures.registry import DRAWN, FIGURES, Wanted, cached_figure
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN
from tests.helpers.pages import FIGURE_NAMES, quick_page, with_summary

PROJECT = Path(__file__).parents[3]
FIRST = "savings"
OTHERS = [name for name in FIGURE_NAMES if name != FIRST]
"""What is kept of a figure does not depend on what it shows."""


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache of this test's own, and the names of the figures that were drawn since."""
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    names = []

    def draw(kind, content, width_in):
        names.append(kind.name)
        return draw_figure(kind, content, width_in)

    monkeypatch.setattr(figure_cache, "draw_figure", draw)
    return names


@pytest.fixture
def figures_not_drawn(cache, monkeypatch):
    """Where it matters which figures are drawn, not what is drawn: each is its name, many times over."""

    def named(kind, content, width_in):
        cache.append(kind.name)
        return kind.name

    monkeypatch.setattr(figure_cache, "draw_figure", named)
    monkeypatch.setattr(figure_cache, "svg_bytes", lambda name: name.encode() * 100)


def templates_of_labbook(name):
    return (PROJECT / "reports" / "templates" / name).read_text(encoding="utf-8")


def one_drawn(content, wanted):
    return cached_figure(content, wanted)


def all_drawn(content):
    return {name: one_drawn(content, Wanted(FIGURES[name], ONE_COLUMN_IN, ("svg",))) for name in FIGURE_NAMES}


@pytest.mark.parametrize("name", [FIRST, *(pytest.param(name, marks=pytest.mark.soak) for name in OTHERS)])
def test_a_kept_figure_is_byte_for_byte_what_is_drawn_anew(content, written, cache, name):
    """Nor is it another than the report wrote a while ago: nothing of the clock or of an earlier drawing is in it."""
    wanted = Wanted(FIGURES[name], TWO_COLUMNS_IN, ("svg", "pdf"))
    first, again = one_drawn(content, wanted), one_drawn(content, wanted)
    assert cache == [name]
    folder = written.parent / "figures"
    called = file_name(name, content)
    assert first == again == {ending: (folder / f"{called}.{ending}").read_bytes() for ending in ("svg", "pdf")}


def test_one_changed_number_draws_the_figures_anew_that_show_it(content, cache, figures_not_drawn):
    all_drawn(content)
    cache.clear()
    all_drawn(dataclasses.replace(content, made_at="2030-01-01T00:00:00Z", claims=()))
    assert cache == []
    first, *others = content.conditions
    apex = first.summaries[Outcome.APEX]
    runs = ((apex.runs[0][0], apex.runs[0][1] + 1e-12), *apex.runs[1:])
    moved = with_summary(first, Outcome.APEX, dataclasses.replace(apex, runs=runs))
    changed = dataclasses.replace(content, conditions=(moved, *others))
    all_drawn(changed)
    assert cache == ["apex_by_level"]
    cache.clear()
    fit = dataclasses.replace(content.drains[0], robot="another")
    all_drawn(dataclasses.replace(content, drains=(fit, *content.drains[1:])))
    assert cache == ["passive_drain"]


def test_a_changed_height_draws_a_figure_of_runs_anew(content, cache, figures_not_drawn):
    kind = dataclasses.replace(FIGURES["passive_drain"], name="of_runs", shows=("runs",))
    name, run = next(iter(content.runs.items()))
    for height_m in (0.31, 0.33):
        runs = {**content.runs, name: dataclasses.replace(run, heights_m={2: height_m})}
        one_drawn(dataclasses.replace(content, runs=runs), Wanted(kind, ONE_COLUMN_IN, ("svg",)))
    assert cache == ["of_runs", "of_runs"]


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data[:-1],
        *(pytest.param(damage, marks=pytest.mark.soak) for damage in (lambda data: data + b" ", lambda data: b"")),
    ],
)
def test_a_damaged_file_is_drawn_anew(content, cache, damage):
    wanted = Wanted(FIGURES["passive_drain"], ONE_COLUMN_IN, ("svg",))
    before = one_drawn(content, wanted)
    (path,) = cache_folder(DRAWN.kind).glob("*/*.svg")
    path.write_bytes(damage(path.read_bytes()))
    assert one_drawn(content, wanted) == before
    assert one_drawn(content, wanted) == before
    assert cache == ["passive_drain", "passive_drain"]


def test_a_compiled_template_is_kept_and_a_damaged_one_compiled_anew(content, cache, tmp_path):
    own = tmp_path / "own"
    own.mkdir()
    (own / "report.html.j2").write_text(templates_of_labbook("report.html.j2") + "<!-- ours -->")
    assert "<!-- ours -->" in quick_page(content, own)  # in a sandbox, for which other code is compiled
    page = quick_page(content)
    kept = list(cache_folder(DRAWN.kind).glob("*/*.template"))
    assert kept
    assert quick_page(content) == page
    assert "<!-- ours -->" in quick_page(content, own)
    for path in kept:
        path.write_bytes(path.read_bytes()[:-1])
    assert quick_page(content) == page


@pytest.mark.parametrize(
    "place",
    ["", "labbook-figures/{}/{}"]
    + [pytest.param(place, marks=pytest.mark.soak) for place in ("labbook-figures", "labbook-figures/{}")],
)
def test_nothing_is_taken_from_where_others_may_write(content, cache, tmp_path, place):
    wanted = Wanted(FIGURES["passive_drain"], ONE_COLUMN_IN, ("svg",))
    before = one_drawn(content, wanted)
    (path,) = cache_folder(DRAWN.kind).glob("*/*.svg")
    shared = tmp_path / "cache" / place.format(DRAWN.version, path.name)
    shared.chmod(shared.stat().st_mode | 0o002)
    assert one_drawn(content, wanted) == before
    assert cache == ["passive_drain", "passive_drain"]


def test_without_a_folder_everything_is_drawn(content, cache, tmp_path):
    (tmp_path / "cache").write_text("a file is here")
    wanted = Wanted(FIGURES["passive_drain"], ONE_COLUMN_IN, ("svg",))
    assert one_drawn(content, wanted) == one_drawn(content, wanted)
    assert cache == ["passive_drain", "passive_drain"]


def test_the_oldest_go_beyond_the_bound_and_old_versions_too(content, cache, figures_not_drawn):
    all_drawn(content)
    sizes = sorted(path.stat().st_size for path in cache_folder(DRAWN.kind).glob("*/*.svg"))
    olds = [cache_folder(DRAWN.kind) / f"{number:020x}" for number in range(3)]
    for old in olds:
        old.mkdir()
    DRAWN.forget_unused(sum(sizes[:2]))
    left = [path.stat().st_size for path in cache_folder(DRAWN.kind).glob("*/*.svg")]
    assert 0 < sum(left) <= sum(sizes[:2]) or len(left) == 0
    assert len([old for old in olds if old.exists()]) == file_cache.MOST_VERSIONS - 1
    assert not list(cache_folder(DRAWN.kind).rglob("*.part"))


def test_the_version_is_of_all_that_figures_are_drawn_with():
    """Whatever of labbook the drawing loads lies under the sources that the version is a hash of."""
    code = "import sys, reports.figures.registry\nprint(*sorted(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True, check=True)
    of_labbook = {name for name in loaded.stdout.split() if name.partition(".")[0] in ("stats", "simulator", "labbook")}
    assert of_labbook == set()
    assert "matplotlib" not in loaded.stdout.split()  # a report whose figures are all kept loads no matplotlib
